//! Meshes that are placed many times: enough triangles saved that `prepare` keeps them once.

use std::f64::consts::TAU;

use glam::{DAffine3, DQuat, DVec3};

use super::{bumpy_sphere, empty, hot_sky, wall};
use crate::reference::known::{camera, lambert, lamp, material, place, sphere_at};
use crate::scene::*;

/// Balls of one mesh: turned, stretched unevenly, mirrored, large and small; painted, brushed, normal-mapped, veiled and of absorbing
/// glass; over a flat floor, under a sky and a lamp. 64 placements of 9216 triangles.
pub fn placed(size: u32) -> Scene {
    let mut s = empty("placed", camera(DVec3::new(0.4, 2.4, 5.0), DVec3::Y * 0.5, 40f64.to_radians()), size);
    s.images.push(hot_sky());
    s.sky = Some(Sky { radiance: SkyRadiance::Image(0), rotation_rad: 0.7, scale: 0.8 });
    s.textures.push(Texture::Checker { a: [0.8; 4], b: [0.1, 0.2, 0.4, 1.0], scale: [6.0, 6.0] });
    s.textures.push(Texture::Checker { a: [0.7, 0.4, 0.9, 1.0], b: [0.4, 0.35, 0.9, 1.0], scale: [8.0, 5.0] });
    let look_up = |texture| Value::Texture { texture, uv_set: 0, uv_transform: glam::DAffine2::IDENTITY };
    let painted = |value| material("lambert", &[("albedo", value)]);
    place(&mut s, "floor", Shape::Rectangle, wall(DVec3::ZERO, DVec3::Y, [4.0, 4.0]), lambert(DVec3::splat(0.6)));
    let mapped = Material { normal_map: Some((look_up(1), 0.8)), ..painted(Value::rgb(0.7, 0.5, 0.4)) };
    let veil = Material { alpha: Alpha::Blend { value: Value::scalar(0.5) }, ..painted(Value::rgb(0.2, 0.7, 0.3)) };
    let mut glass = material("dielectric", &[("roughness", Value::scalar(0.0))]);
    glass.interior = Some(Medium { absorption: DVec3::new(4.0, 1.0, 0.5) });
    let tinted = Value::Multiply(Box::new(Value::VertexColor), Box::new(look_up(0)));
    let brushed = material("conductor", &[("roughness", Value::scalar(0.5)), ("roughness_y", Value::scalar(0.2))]);
    let looks = [painted(tinted), mapped, brushed, veil, glass];
    let first = s.materials.len();
    s.materials.extend(looks);
    s.meshes.push(bumpy_sphere(96, 48));
    for i in 0..64u32 {
        let (row, column) = (f64::from(i / 8), f64::from(i % 8));
        let radius = 0.14 + 0.09 * (f64::from(i) * 0.9).sin();
        let mirror = if i.is_multiple_of(3) { -1.0 } else { 1.0 };
        let stretch = DVec3::new(1.0 + 0.6 * (f64::from(i) * 0.7).cos(), 1.0, mirror * (0.8 + 0.1 * f64::from(i % 5)));
        let turn = DQuat::from_axis_angle(DVec3::new(0.3, 0.5, 0.8).normalize(), TAU * f64::from(i) / 9.0);
        let center = DVec3::new(0.55 * (column - 3.5), radius + 0.12 * row, 0.6 * (3.0 - row));
        let to_world = DAffine3::from_scale_rotation_translation(radius * stretch, turn, center);
        let material = first + (i as usize * 7 + i as usize / 8) % 5;
        s.instances.push(Instance { name: format!("ball {i}"), shape: Shape::Mesh(0), to_world, material });
    }
    let center = DVec3::new(1.6, 2.2, 1.0);
    place(&mut s, "lamp", Shape::Sphere, sphere_at(center, 0.3), lamp(DVec3::new(10.0, 9.0, 7.0)));
    s
}
