//! The layered models on one floor, and mixtures.

use glam::{DAffine3, DQuat, DVec3};

use super::{bumpy_sphere, empty, hot_sky, wall};
use crate::reference::known::{camera, lambert, lamp, material, place, sphere_at};
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

/// `parts` with their shares, which add to 1.
fn mix(parts: Vec<(Material, Value)>) -> Material {
    let (bsdf, inputs) = (parts[0].0.bsdf, parts[0].0.inputs.clone());
    let parts = parts.into_iter().map(|(m, share)| Part { bsdf: m.bsdf, inputs: m.inputs, share }).collect();
    Material { bsdf, inputs, parts, ..lambert(DVec3::ONE) }
}

/// Mixtures: by a texture, of one kind twice, of what transmits with what does not, with delta lobes.
pub fn mixtures(size: u32) -> Scene {
    let mut s = empty("mixtures", camera(DVec3::new(0.0, 1.5, 4.0), DVec3::Y * 0.5, 40f64.to_radians()), size);
    s.images.push(hot_sky());
    s.sky = Some(Sky { radiance: SkyRadiance::Image(0), rotation_rad: 1.0, scale: 0.7 });
    s.textures.push(Texture::Checker { a: [0.9; 4], b: [0.2; 4], scale: [5.0, 5.0] });
    let checker = || Value::Texture { texture: 0, uv_set: 0, uv_transform: glam::DAffine2::IDENTITY };
    let value = Value::scalar;
    let metal = |roughness: f64| material("conductor", &[("roughness", value(roughness))]);
    let (rest, share) = (Value::Rest(Box::new(checker())), Value::Share(Box::new(checker())));
    let floor = wall(DVec3::ZERO, DVec3::Y, [3.0, 3.0]);
    let tiles = mix(vec![(lambert(DVec3::new(0.7, 0.6, 0.5)), rest), (metal(0.5), share)]);
    place(&mut s, "floor", Shape::Rectangle, floor, tiles);
    let paint = material("plastic", &[("color", Value::rgb(0.7, 0.1, 0.05)), ("roughness", value(0.5))]);
    let glass = material("dielectric", &[("roughness", value(0.5))]);
    let balls = [
        mix(vec![(metal(0.3), value(0.4)), (metal(0.7), value(0.6))]),
        mix(vec![(glass, value(0.5)), (paint.clone(), value(0.3)), (lambert(DVec3::new(0.1, 0.6, 0.2)), value(0.2))]),
        mix(vec![(metal(0.0), value(0.25)), (paint, value(0.75))]),
    ];
    for (k, ball) in balls.into_iter().enumerate() {
        let center = DVec3::new(1.1 * (k as f64 - 1.0), 0.45, 0.0);
        place(&mut s, &format!("ball {k}"), Shape::Sphere, sphere_at(center, 0.45), ball);
    }
    place(&mut s, "lamp", Shape::Sphere, sphere_at(DVec3::new(1.2, 2.1, 1.2), 0.3), lamp(DVec3::new(8.0, 7.0, 5.0)));
    s
}
