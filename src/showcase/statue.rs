//! The statue of scenes/peer_b.toml: a turned, fluted and twisted figure on a plinth, 1.6 m high, 70,400 triangles, as .ply.
//!
//! Radius and twist over the height are smooth sums, so that normals are those of the surface itself (central differences of the
//! formula, not of the triangles). Lengths are rounded to 2^-16 m, as the showcase's are, so that every machine writes the same
//! bytes. It stands for the scanned statue on which other renderers were timed: any mesh of that size will do.

use std::f64::consts::TAU;

use glam::DVec3;

const COLUMNS: usize = 176;
const ROWS: usize = 200;
const HEIGHT: f64 = 1.6;
/// Least radius, 1 mm: the crown stays open by it, so that neighbours on its last ring are still apart after rounding.
const CROWN: f64 = 0.001;

/// (height, radius) of the figure without flutes, from the foot to the crown; between them by a smooth step.
const PROFILE: [(f64, f64); 12] = [
    (0.0, 0.34),
    (0.10, 0.33),
    (0.16, 0.24),
    (0.30, 0.20),
    (0.55, 0.27),
    (0.80, 0.16),
    (1.00, 0.24),
    (1.18, 0.21),
    (1.26, 0.07),
    (1.40, 0.14),
    (1.52, 0.10),
    (1.60, 0.0),
];

/// 0 below `from`, 1 above `to`.
fn smooth_step(from: f64, to: f64, x: f64) -> f64 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

fn radius(y: f64) -> f64 {
    let above = PROFILE.iter().position(|p| p.0 > y).unwrap_or(PROFILE.len() - 1);
    let (low, high) = (PROFILE[above - 1], PROFILE[above]);
    low.1 + (high.1 - low.1) * smooth_step(low.0, high.0, y)
}

/// Point of the surface; `angle` and `y` may lie a little outside of their ranges.
fn surface(angle: f64, y: f64) -> DVec3 {
    // No flutes on the plinth and the crown.
    let body = smooth_step(0.12, 0.3, y) * (1.0 - smooth_step(1.15, 1.3, y));
    let fluted = 0.10 * (7.0 * angle + 5.0 * y).cos() + 0.04 * (16.0 * angle - 9.0 * y).cos() + 0.03 * (23.0 * y).sin();
    let r = radius(y.clamp(0.0, HEIGHT)).max(CROWN) * (1.0 + body * fluted);
    // A slow turn and a lean, which straighten out towards the plinth.
    let turned = angle + 1.3 * smooth_step(0.2, 1.4, y);
    let lean = 0.05 * smooth_step(0.2, 1.0, y) * (2.2 * y).sin();
    DVec3::new(r * turned.sin() + lean, y, r * turned.cos())
}

/// Bytes of the file, binary little-endian, positions and normals.
pub fn ply() -> Vec<u8> {
    let vertices = COLUMNS * (ROWS + 1);
    let faces = 2 * COLUMNS * ROWS;
    let mut bytes = format!(
        "ply\nformat binary_little_endian 1.0\ncomment steradian generate peers\nelement vertex {vertices}\n\
         property float x\nproperty float y\nproperty float z\nproperty float nx\nproperty float ny\nproperty float nz\n\
         element face {faces}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    .into_bytes();
    let fixed = |v: f64| ((v * 65536.0).round() / 65536.0) as f32;
    for row in 0..=ROWS {
        let y = HEIGHT * row as f64 / ROWS as f64;
        for column in 0..COLUMNS {
            let angle = TAU * column as f64 / COLUMNS as f64;
            let step = 1e-4;
            let around = surface(angle + step, y) - surface(angle - step, y);
            let (low, high) = ((y - step).max(0.0), (y + step).min(HEIGHT));
            let along = surface(angle, high) - surface(angle, low);
            let normal = around.cross(along).normalize_or(DVec3::Y);
            for x in surface(angle, y).to_array().into_iter().chain(normal.to_array()) {
                bytes.extend(fixed(x).to_le_bytes());
            }
        }
    }
    for row in 0..ROWS {
        for column in 0..COLUMNS {
            let corner = |r: usize, c: usize| ((row + r) * COLUMNS + (column + c) % COLUMNS) as i32;
            for triangle in [[corner(0, 0), corner(0, 1), corner(1, 1)], [corner(0, 0), corner(1, 1), corner(1, 0)]] {
                bytes.push(3);
                triangle.iter().for_each(|i| bytes.extend(i.to_le_bytes()));
            }
        }
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_a_smooth_figure_of_the_size_it_says() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("statue.ply");
        std::fs::write(&path, ply()).unwrap();
        let scene = crate::scene::load(&path).unwrap();
        let mesh = &scene.meshes[0];
        assert_eq!((mesh.triangles.len(), scene.notes.len()), (70_400, 0));
        let normals = mesh.normals.as_ref().unwrap();
        let at = |i: u32| DVec3::from(mesh.positions[i as usize].map(f64::from));
        let mut turned_over = 0;
        for &[a, b, c] in &mesh.triangles {
            let face = (at(b) - at(a)).cross(at(c) - at(a));
            let mean: DVec3 = [a, b, c].iter().map(|&i| DVec3::from(normals[i as usize].map(f64::from))).sum();
            turned_over += usize::from(face.dot(mean) <= 0.0);
        }
        assert_eq!(turned_over, 0);
        let (low, high) = crate::scene::bounds(&scene).unwrap();
        assert!(low.y == 0.0 && (high.y - HEIGHT).abs() < 1e-4, "{low} {high}");
    }
}
