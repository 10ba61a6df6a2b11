//! A pebble beach of any number of stones, placed copies of three: what a scene of a million instances costs, as a picture.
//!
//! `files(count)` returns stones.toml, three stones of 528 triangles (.ply) and their placements (.txt, 12 numbers a line). Stones lie on a
//! jittered grid of 4 cm cells in front of the camera, each turned about the vertical, flattened and scaled by its own hash.

use std::f64::consts::TAU;
use std::fmt::Write;

use glam::{DAffine3, DMat3, DQuat, DVec3};

use crate::sampler::hash::pcg4d;

const COLUMNS: usize = 24;
const ROWS: usize = 12;
/// Side of a cell, m.
const CELL: f64 = 0.04;
/// Name, linear colour, and the seed of the shape.
const KINDS: [(&str, [f64; 3], f64); 3] =
    [("granite", [0.42, 0.4, 0.38], 0.0), ("brick", [0.45, 0.2, 0.13], 2.1), ("slate", [0.16, 0.19, 0.23], 4.4)];

/// Name and bytes of every file.
pub fn files(count: u32) -> Vec<(String, Vec<u8>)> {
    let mut files = vec![("stones.toml".to_owned(), scene().into_bytes())];
    let mut places = KINDS.map(|_| String::new());
    let columns = f64::from(count).sqrt().ceil().max(1.0) as u32;
    for k in 0..count {
        let (kind, place) = placement(k, columns);
        let m = place.matrix3;
        let rows = [0, 1, 2]
            .map(|r| format!("{:.5} {:.5} {:.5} {:.4}", m.x_axis[r], m.y_axis[r], m.z_axis[r], place.translation[r]));
        // A String takes whatever is written to it.
        let _ = writeln!(places[kind], "{}", rows.join(" "));
    }
    for ((name, _, seed), places) in KINDS.iter().zip(places) {
        files.push((format!("stone_{name}.ply"), ply(*seed).into_bytes()));
        files.push((format!("stones_{name}.txt"), places.into_bytes()));
    }
    files
}

/// Which stone the k-th is and where it lies: rows of cells from the camera away.
fn placement(k: u32, columns: u32) -> (usize, DAffine3) {
    let words = pcg4d([k, 0x5703, 0, 0]);
    let more = pcg4d([k, 0x5703, 1, 0]);
    let unit = |w: u32| f64::from(w) / 4_294_967_296.0;
    let x = f64::from(k % columns) - 0.5 * f64::from(columns) + unit(words[0]);
    let z = -f64::from(k / columns) - unit(words[1]);
    let size = CELL * (0.35 + 0.65 * unit(words[2]).powi(3));
    let flat = 0.4 + 0.35 * unit(words[3]);
    let turn = DQuat::from_rotation_y(TAU * unit(more[0]));
    let lean =
        DQuat::from_rotation_x(0.5 * (unit(more[1]) - 0.5)) * DQuat::from_rotation_z(0.5 * (unit(more[2]) - 0.5));
    let matrix3 = DMat3::from_quat(turn * lean) * DMat3::from_diagonal(DVec3::new(size, size * flat, size));
    // Waves along the beach; each stone sits in the sand up to a third.
    let height = 0.012 * (0.35 * x * CELL).sin() * (0.5 * z * CELL).cos();
    let translation = DVec3::new(x * CELL, height + 0.35 * size * flat, z * CELL);
    let kind = [0, 0, 1, 2, 2][(more[3] % 5) as usize];
    (kind, DAffine3 { matrix3, translation })
}

/// A ball with gentle bumps, no longer than 1 from its middle.
fn ply(seed: f64) -> String {
    let mut text = format!(
        "ply\nformat ascii 1.0\ncomment steradian generate stones\nelement vertex {}\nproperty float x\nproperty float y\n\
         property float z\nelement face {}\nproperty list uchar int vertex_indices\nend_header\n",
        COLUMNS * (ROWS - 1) + 2,
        2 * COLUMNS * (ROWS - 1)
    );
    let bumpy = |d: DVec3| {
        let wave =
            (2.3 * d.x + seed).sin() * (1.9 * d.z - seed).cos() + 0.5 * (4.1 * d.y + 3.3 * d.x + 2.0 * seed).sin();
        d * (0.84 + 0.1 * wave)
    };
    let mut vertex = |d: DVec3| {
        let p = bumpy(d);
        let _ = writeln!(text, "{:.4} {:.4} {:.4}", p.x, p.y, p.z);
    };
    vertex(DVec3::Y);
    for row in 1..ROWS {
        let (sin, cos) = (0.5 * TAU * row as f64 / ROWS as f64).sin_cos();
        for column in 0..COLUMNS {
            let (s, c) = (TAU * column as f64 / COLUMNS as f64).sin_cos();
            vertex(DVec3::new(sin * s, cos, sin * c));
        }
    }
    vertex(DVec3::NEG_Y);
    let at = |row: usize, column: usize| 1 + (row - 1) * COLUMNS + column % COLUMNS;
    let last = 1 + COLUMNS * (ROWS - 1);
    for column in 0..COLUMNS {
        let _ = writeln!(text, "3 0 {} {}", at(1, column), at(1, column + 1));
        for row in 1..ROWS - 1 {
            let [a, b] = [at(row, column), at(row, column + 1)];
            let [c, d] = [at(row + 1, column), at(row + 1, column + 1)];
            let _ = writeln!(text, "3 {a} {c} {d}\n3 {a} {d} {b}");
        }
        let _ = writeln!(text, "3 {} {last} {}", at(ROWS - 1, column), at(ROWS - 1, column + 1));
    }
    text
}

fn scene() -> String {
    let mut text = "# A pebble beach in the evening: made by `steradian generate stones`. Its light groups are sky and sun.\n\
                    [camera]\nposition = [0, 0.9, 1.2]\ntarget = [0, 0, -2.2]\nfov_y_deg = 50\n\
                    [sky]\nradiance = [0.25, 0.34, 0.5]\ngroup = \"sky\"\n\
                    [[light]]\ntype = \"directional\"\ndirection = [-0.75, -0.45, 0.35]\nirradiance = [3.2, 2.2, 1.3]\n\
                    angular_diameter_deg = 0.533\ngroup = \"sun\"\n\
                    [[material]]\nname = \"sand\"\nalbedo = [0.5, 0.42, 0.3]\n\
                    [[shape]]\ntype = \"rectangle\"\nname = \"sand\"\nmaterial = \"sand\"\ncenter = [0, -0.01, 0]\nu = [500, 0, 0]\nv = [0, 0, -500]\n"
        .to_owned();
    for (name, color, _) in KINDS {
        let _ = write!(
            text,
            "[[material]]\nname = \"{name}\"\nalbedo = {color:?}\n[[shape]]\ntype = \"mesh\"\nname = \"{name}\"\nmaterial = \"{name}\"\n\
             file = \"stone_{name}.ply\"\ncopies_file = \"stones_{name}.txt\"\n"
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use crate::scene::{self, Shape};

    #[test]
    fn every_stone_is_placed_and_closed() {
        let folder = tempfile::tempdir().unwrap();
        for (name, bytes) in super::files(1000) {
            std::fs::write(folder.path().join(name), bytes).unwrap();
        }
        let scene = scene::load(&folder.path().join("stones.toml")).unwrap();
        let stones = scene.instances.iter().filter(|i| matches!(i.shape, Shape::Mesh(_)));
        assert_eq!((stones.count(), scene.instances.len(), scene.meshes.len()), (1000, 1001, 3));
        assert_eq!(scene.light_groups(), ["sky", "sun"]);
        for mesh in &scene.meshes {
            // Euler's formula of a ball, and fronts outside.
            assert_eq!(mesh.positions.len() + mesh.triangles.len() - 3 * mesh.triangles.len() / 2, 2);
            let volume = |t: &[u32; 3]| {
                let [a, b, c] = t.map(|i| glam::Vec3::from(mesh.positions[i as usize]));
                a.dot(b.cross(c)) / 6.0
            };
            assert!(mesh.triangles.iter().map(volume).sum::<f32>() > 1.0);
        }
    }
}
