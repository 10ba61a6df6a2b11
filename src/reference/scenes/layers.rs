//! The layered models on one floor.

use glam::{DAffine3, DQuat, DVec3};

use super::{bumpy_sphere, empty, hot_sky, wall};
use crate::reference::known::{camera, lamp, material, place, sphere_at};
use crate::scene::*;

/// Rough diffuse floor; plastic, smooth and rough; glTF's surface with anisotropy (also mirrored), specular and clearcoat.
pub fn layers(size: u32) -> Scene {
    let mut s = empty("layers", camera(DVec3::new(0.0, 1.6, 4.2), DVec3::Y * 0.6, 40f64.to_radians()), size);
    s.images.push(hot_sky());
    s.sky = Some(Sky { radiance: SkyRadiance::Image(0), rotation_rad: 1.0, scale: 0.7 });
    s.meshes.push(bumpy_sphere(24, 12));
    let value = Value::scalar;
    let floor = wall(DVec3::ZERO, DVec3::Y, [3.0, 3.0]);
    let rough = |color, roughness: f64| material("rough_diffuse", &[("color", color), ("roughness", value(roughness))]);
    place(&mut s, "floor", Shape::Rectangle, floor, rough(Value::rgb(0.8, 0.75, 0.7), 0.9));
    let paint =
        |roughness: f64| material("plastic", &[("color", Value::rgb(0.7, 0.1, 0.05)), ("roughness", value(roughness))]);
    let coated = material(
        "gltf",
        &[
            ("base_color", Value::rgb(0.1, 0.3, 0.7)),
            ("metallic", value(0.4)),
            ("roughness", value(0.6)),
            ("specular", value(0.7)),
            ("specular_color", Value::rgb(1.0, 0.4, 0.3)),
            ("clearcoat", value(0.9)),
            ("clearcoat_roughness", value(0.3)),
        ],
    );
    let varnished = material(
        "gltf",
        &[("base_color", Value::rgb(0.9, 0.6, 0.3)), ("roughness", value(0.5)), ("clearcoat", value(1.0))],
    );
    let balls = [paint(0.0), paint(0.4), coated, varnished, rough(Value::rgb(0.9, 0.5, 0.1), 0.5)];
    for (k, ball) in balls.into_iter().enumerate() {
        let center = DVec3::new(0.8 * (k as f64 - 2.0), 0.38, 0.2 * (k % 2) as f64);
        place(&mut s, &format!("ball {k}"), Shape::Sphere, sphere_at(center, 0.38), ball);
    }
    let brushed = material(
        "gltf",
        &[("base_color", Value::rgb(0.9, 0.8, 0.6)), ("roughness", value(0.4)), ("anisotropy", value(0.9))]
            .into_iter()
            .chain([("anisotropy_rotation", value(0.6))])
            .collect::<Vec<_>>(),
    );
    for (name, x, side) in [("brushed", -0.6, 1.0), ("mirrored", 0.6, -1.0)] {
        let to_world = DAffine3::from_scale_rotation_translation(
            DVec3::new(0.4 * side, 0.4, 0.4),
            DQuat::from_rotation_z(0.3),
            DVec3::new(x, 1.2, 0.0),
        );
        place(&mut s, name, Shape::Mesh(0), to_world, brushed.clone());
    }
    let lamp_at = sphere_at(DVec3::new(1.2, 2.1, 1.2), 0.3);
    place(&mut s, "lamp", Shape::Sphere, lamp_at, lamp(DVec3::new(8.0, 7.0, 5.0)));
    s
}
