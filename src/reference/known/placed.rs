//! Radiance does not change with the scale of what is placed, nor with distance.

use glam::{DAffine3, DQuat, DVec3};

use super::{Known, camera, lambert, lamp, narrow, place};
use crate::scene::{Mesh, Shape, Sky, SkyRadiance};

/// Copies of one white octahedron, a thousandth to a thousand times as large, stretched and mirrored, and black walls that shine with
/// radiance 1 at distances from 3 m to 30 km, under a sky of radiance 1: every surface sees 1 and sends 1 on.
pub fn scaled_copies() -> Known {
    let mut scene = narrow("scaled-copies", DVec3::ZERO, DVec3::NEG_Z);
    scene.camera = camera(DVec3::ZERO, DVec3::NEG_Z, 0.9);
    scene.sky = Some(Sky { radiance: SkyRadiance::Uniform(DVec3::ONE), rotation_rad: 0.0, scale: 1.0 });
    let axes = [DVec3::X, DVec3::Y, DVec3::Z, DVec3::NEG_X, DVec3::NEG_Y, DVec3::NEG_Z];
    // Upper and lower pyramid about y, fronts outside.
    let ring = [0u32, 5, 3, 2];
    let side = |k: usize| [[ring[k], ring[(k + 1) % 4], 1], [ring[(k + 1) % 4], ring[k], 4]];
    scene.meshes.push(Mesh {
        positions: axes.map(|v| v.as_vec3().to_array()).to_vec(),
        triangles: (0..4).flat_map(side).collect(),
        ..Mesh::default()
    });
    for k in 0..13u32 {
        let size = 10f64.powf(f64::from(k) / 2.0 - 3.0);
        let (row, column) = (f64::from(k / 4) - 1.5, f64::from(k % 4) - 1.5);
        let stretch = DVec3::new(1.0, 0.6, if k.is_multiple_of(2) { 1.4 } else { -1.4 });
        let turn = DQuat::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), f64::from(k));
        let center = DVec3::new(1.2 * column, 1.2 * row, -6.0) * size;
        let to_world = DAffine3::from_scale_rotation_translation(0.5 * size * stretch, turn, center);
        place(&mut scene, "copy", Shape::Mesh(0), to_world, lambert(DVec3::ONE));
    }
    for k in 0..3u32 {
        let distance = 3.0 * 100f64.powi(k as i32);
        let center = DVec3::new(0.35 * f64::from(k) - 0.35, -0.3, -1.0) * distance;
        let to_world = DAffine3::from_scale_rotation_translation(
            DVec3::splat(0.1 * distance),
            DQuat::from_rotation_y(0.4),
            center,
        );
        let mut wall = lamp(DVec3::ONE);
        wall.emission_two_sided = true;
        place(&mut scene, "wall", Shape::Rectangle, to_world, wall);
    }
    Known {
        name: "scaled copies",
        about: "radiance 1 from placed white copies of every scale and from walls at every distance, under a sky of 1",
        scene,
        radiance: DVec3::ONE,
    }
}
