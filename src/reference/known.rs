//! Scenes whose radiance is known in closed form: the oracle must meet it, and so must every device (gate 7).
//!
//! Each builder returns a scene whose image is the answer in every pixel, so that the mean of the image is the test. The
//! camera is a narrow cone (2 mrad), so that the answer at its axis holds to 1e-6 where it depends on the point.

pub mod lights;
pub mod placed;

use std::f64::consts::PI;
use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3};

use crate::bsdf;
use crate::scene::*;

/// A scene and the radiance of each of its pixels, W/(m2 sr).
pub struct Known {
    pub name: &'static str,
    /// What is tested, and the formula of the answer.
    pub about: &'static str,
    pub scene: Scene,
    pub radiance: DVec3,
}

/// Camera at `from`, looking at `at`, with the given vertical field of view.
pub fn camera(from: DVec3, at: DVec3, fov_y_rad: f64) -> Camera {
    let z = (from - at).normalize();
    let up = if z.y.abs() > 0.99 { DVec3::Z } else { DVec3::Y };
    let x = up.cross(z).normalize();
    let to_world = DAffine3::from_mat3_translation(DMat3::from_cols(x, z.cross(x), z), from);
    Camera { to_world, projection: Projection::Perspective { fov_y_rad }, is_placed: true }
}

/// A material of model `keyword` with the model's defaults, `set` overriding by input name.
///
/// # Panics
/// When the model or an input does not exist: scenes here are part of the program.
pub fn material(keyword: &str, set: &[(&str, Value)]) -> Material {
    let bsdf = bsdf::MODELS.iter().position(|m| m.keyword == keyword).expect("a model of the list");
    let inputs = bsdf::MODELS[bsdf]
        .inputs
        .iter()
        .map(|input| {
            let given = set.iter().find(|s| s.0 == input.name).map(|s| s.1.clone());
            given.unwrap_or_else(|| Value::rgb(input.default[0], input.default[1], input.default[2]))
        })
        .collect();
    Material {
        name: keyword.to_owned(),
        bsdf,
        inputs,
        emission: None,
        emission_two_sided: false,
        group: None,
        alpha: Alpha::Opaque,
        normal_map: None,
        interior: None,
        priority: 0,
        parts: Vec::new(),
    }
}

/// Lambert of one albedo.
pub fn lambert(albedo: DVec3) -> Material {
    material("lambert", &[("albedo", Value::rgb(albedo.x, albedo.y, albedo.z))])
}

/// Black, emitting `radiance`.
pub fn lamp(radiance: DVec3) -> Material {
    Material { emission: Some(Value::rgb(radiance.x, radiance.y, radiance.z)), ..lambert(DVec3::ZERO) }
}

/// Adds a shape with its own material.
pub fn place(scene: &mut Scene, name: &str, shape: Shape, to_world: DAffine3, material: Material) {
    scene.materials.push(material);
    let material = scene.materials.len() - 1;
    scene.instances.push(Instance { name: name.to_owned(), shape, to_world, material });
}

pub fn sphere_at(center: DVec3, radius: f64) -> DAffine3 {
    DAffine3::from_scale_rotation_translation(DVec3::splat(radius), glam::DQuat::IDENTITY, center)
}

/// Rectangle of half-size `half`, facing +y.
pub fn floor_at(center: DVec3, half: f64) -> DAffine3 {
    let turn = glam::DQuat::from_rotation_x(-0.5 * PI);
    DAffine3::from_scale_rotation_translation(DVec3::splat(half), turn, center)
}

/// A narrow view of 8 x 8 pixels.
pub fn narrow(name: &str, from: DVec3, at: DVec3) -> Scene {
    Scene { name: name.to_owned(), camera: camera(from, at, 0.002), film: Film::sized(8, 8), ..Scene::default() }
}

/// Inside a sphere of albedo rho that emits Le on both sides: L = Le/(1 - rho).
pub fn furnace_sphere() -> Known {
    let (albedo, emission) = (DVec3::new(0.5, 0.2, 0.8), DVec3::new(1.0, 2.0, 0.5));
    let mut scene = narrow("furnace-sphere", DVec3::new(0.1, 0.2, 0.3), DVec3::new(0.5, -0.1, 0.0));
    let mut wall = lambert(albedo);
    wall.emission = Some(Value::rgb(emission.x, emission.y, emission.z));
    wall.emission_two_sided = true;
    place(&mut scene, "wall", Shape::Sphere, sphere_at(DVec3::ZERO, 1.0), wall);
    Known {
        name: "furnace sphere",
        about: "inside a sphere of albedo rho that emits Le: L = Le/(1 - rho)",
        scene,
        radiance: emission / (DVec3::ONE - albedo),
    }
}

/// The same with an albedo so high that paths have two hundred edges: more loops than some drivers let an invocation make.
pub fn deep_furnace() -> Known {
    let albedo = DVec3::splat(0.995);
    let mut known = furnace_sphere();
    known.scene.name = "deep-furnace".to_owned();
    known.scene.materials[0].inputs[0] = Value::rgb(albedo.x, albedo.y, albedo.z);
    known.scene.materials[0].emission = Some(Value::rgb(1.0, 1.0, 1.0));
    Known { name: "deep furnace", radiance: DVec3::ONE / (DVec3::ONE - albedo), ..known }
}

/// Lambert plane under a uniform sky: E = pi L, so the radiance is rho L.
pub fn uniform_sky() -> Known {
    let (albedo, sky) = (DVec3::new(0.7, 0.5, 0.3), DVec3::new(1.0, 1.5, 2.0));
    let mut scene = narrow("uniform-sky", DVec3::new(0.0, 1.0, 0.5), DVec3::ZERO);
    place(&mut scene, "floor", Shape::Rectangle, floor_at(DVec3::ZERO, 10.0), lambert(albedo));
    scene.sky = Some(Sky { radiance: SkyRadiance::Uniform(sky), rotation_rad: 0.0, scale: 1.0 });
    Known { name: "uniform sky", about: "E = pi L on a plane", scene, radiance: albedo * sky }
}

/// Sphere lamp of radius R at distance d, seen from the plane under the angle theta: E = pi L (R/d)^2 cos(theta).
pub fn sphere_lamp() -> Known {
    let (albedo, emission) = (DVec3::new(0.7, 0.5, 0.3), DVec3::new(10.0, 8.0, 4.0));
    let (radius, distance, theta) = (0.3, 2.0, 50f64.to_radians());
    let mut scene = narrow("sphere-lamp", DVec3::new(0.0, 1.0, 0.5), DVec3::ZERO);
    place(&mut scene, "floor", Shape::Rectangle, floor_at(DVec3::ZERO, 10.0), lambert(albedo));
    let center = distance * DVec3::new(theta.sin(), theta.cos(), 0.0);
    place(&mut scene, "lamp", Shape::Sphere, sphere_at(center, radius), lamp(emission));
    let irradiance = PI * emission * (radius / distance).powi(2) * theta.cos();
    Known { name: "sphere lamp", about: "E = pi L (R/d)^2 cos(theta)", scene, radiance: albedo * irradiance / PI }
}

/// Degrees of `tilted_receiver` that the cosine law is held to, 0 first.
pub const TILTS_DEG: [f64; 9] = [0.0, 15.0, 30.0, 45.0, 60.0, 75.0, 85.0, 89.0, 89.9];

/// White receiver turned by theta from a lamp of radius R at the distance d straight above: E = pi L (R/d)^2 cos(theta). R/d is
/// 1e-4, so that the whole lamp stays above the receiver's horizon up to 89.99 degrees.
pub fn tilted_receiver(theta_deg: f64) -> Known {
    let (radius, distance, emission) = (0.1, 1000.0, DVec3::new(3e8, 2e8, 1e8));
    let normal = DVec3::new(theta_deg.to_radians().sin(), theta_deg.to_radians().cos(), 0.0);
    let mut scene = narrow("tilted-receiver", normal + 0.5 * DVec3::Z, DVec3::ZERO);
    let turn = glam::DQuat::from_rotation_arc(DVec3::Z, normal);
    let receiver = DAffine3::from_scale_rotation_translation(DVec3::splat(0.5), turn, DVec3::ZERO);
    place(&mut scene, "receiver", Shape::Rectangle, receiver, lambert(DVec3::ONE));
    place(&mut scene, "lamp", Shape::Sphere, sphere_at(distance * DVec3::Y, radius), lamp(emission));
    let irradiance = PI * emission * (radius / distance).powi(2) * theta_deg.to_radians().cos();
    Known {
        name: "tilted receiver",
        about: "E(theta)/E(0) = cos(theta) under a distant lamp",
        scene,
        radiance: irradiance / PI,
    }
}

/// Square lamp of side 1 parallel to the floor, 1 above its corner's foot: E from the form factor of a parallel rectangle
/// (Siegel and Howell, configuration 4, differential element to rectangle) times pi L.
pub fn rectangle_lamp() -> Known {
    let (albedo, emission) = (DVec3::new(0.7, 0.5, 0.3), DVec3::new(10.0, 8.0, 4.0));
    let mut scene = narrow("rectangle-lamp", DVec3::new(0.0, 0.5, 1.0), DVec3::ZERO);
    place(&mut scene, "floor", Shape::Rectangle, floor_at(DVec3::ZERO, 10.0), lambert(albedo));
    let turn = glam::DQuat::from_rotation_x(0.5 * PI);
    let to_world = DAffine3::from_scale_rotation_translation(DVec3::splat(0.5), turn, DVec3::new(0.5, 1.0, 0.5));
    place(&mut scene, "lamp", Shape::Rectangle, to_world, lamp(emission));
    let half = 0.5f64.sqrt();
    let factor = (2.0 * half * half.atan()) / (2.0 * PI);
    Known {
        name: "rectangle lamp",
        about: "form factor of a square above the point below its corner",
        scene,
        radiance: albedo * emission * factor,
    }
}

/// Disc lamp of radius R parallel to the floor, h above it, seen from `aside` off its axis: E = pi L F with
/// F = (1 - (h^2 + a^2 - R^2)/sqrt((h^2 + a^2 + R^2)^2 - 4 a^2 R^2))/2 (Siegel and Howell, differential element to a parallel
/// disc), which on the axis is R^2/(R^2 + h^2).
fn disc_lamp_at(name: &'static str, about: &'static str, aside: f64) -> Known {
    let (albedo, emission) = (DVec3::new(0.7, 0.5, 0.3), DVec3::new(10.0, 8.0, 4.0));
    let (radius, height) = (0.6, 0.9);
    let mut scene = narrow(name, DVec3::new(0.0, 0.4, 1.6), DVec3::ZERO);
    place(&mut scene, "floor", Shape::Rectangle, floor_at(DVec3::ZERO, 10.0), lambert(albedo));
    let turn = glam::DQuat::from_rotation_x(0.5 * PI);
    let center = DVec3::new(aside, height, 0.0);
    let to_world = DAffine3::from_scale_rotation_translation(DVec3::splat(radius), turn, center);
    place(&mut scene, "lamp", Shape::Disc, to_world, lamp(emission));
    let (h2, a2, r2) = (height * height, aside * aside, radius * radius);
    let factor = 0.5 * (1.0 - (h2 + a2 - r2) / ((h2 + a2 + r2).powi(2) - 4.0 * a2 * r2).sqrt());
    Known { name, about, scene, radiance: albedo * emission * factor }
}

/// Below the middle of a disc lamp.
pub fn disc_lamp() -> Known {
    disc_lamp_at("disc lamp", "E = pi L R^2/(R^2 + h^2) on the axis of a disc", 0.0)
}

/// Beside it.
pub fn disc_lamp_aside() -> Known {
    disc_lamp_at("disc lamp aside", "form factor of a parallel disc off its axis", 1.1)
}

/// Sky of 8 x 4 texels whose columns have colours that are linear in the column; turned by +90 degrees about +y, which carries
/// -z (the image's centre) to -x, 2 texels to the left. Toward the centre of column `column` one now sees `column` + 2.
fn turned_columns(scene: &mut Scene, column: u32) -> (DVec3, DVec3) {
    let (width, height) = (8u32, 4u32);
    let color = |i: u32| DVec3::new(1.0 + f64::from(i), 9.0 - f64::from(i), 0.5 * f64::from(i));
    let pixels = (0..width * height).flat_map(|k| color(k % width).to_array().map(|c| c as f32)).collect::<Vec<f32>>();
    scene.images.push(Image { name: "columns".to_owned(), width, height, pixels: Pixels::RgbF32(Arc::new(pixels)) });
    scene.sky = Some(Sky { radiance: SkyRadiance::Image(0), rotation_rad: 0.5 * PI, scale: 2.0 });
    let longitude = std::f64::consts::TAU * ((f64::from(column) + 0.5) / f64::from(width) - 0.5);
    (DVec3::new(longitude.sin(), 0.0, -longitude.cos()), 2.0 * color(column + 2))
}

/// A turned sky seen directly at a texel's centre on the horizon.
pub fn turned_sky() -> Known {
    let from = DVec3::new(3.0, 1.0, 2.0);
    let mut scene = narrow("turned-sky", from, DVec3::ZERO);
    let (direction, radiance) = turned_columns(&mut scene, 3);
    scene.camera = camera(from, from + direction, 0.002);
    Known {
        name: "turned sky",
        about: "a sky turned by +90 degrees about +y, read at a texel's centre",
        scene,
        radiance,
    }
}

/// A mirror ball that is looked at head-on shows the sky behind the viewer. Its index is imaginary, so it reflects all.
pub fn mirror_ball() -> Known {
    let mut scene = narrow("mirror-ball", DVec3::ZERO, DVec3::X);
    let (direction, radiance) = turned_columns(&mut scene, 4);
    scene.camera = camera(3.0 * direction, DVec3::ZERO, 0.002);
    let inputs = [
        ("eta", Value::scalar(0.0)),
        ("k", Value::scalar(1.0)),
        ("roughness", Value::scalar(0.0)),
        ("roughness_y", Value::scalar(-1.0)),
    ];
    place(&mut scene, "ball", Shape::Sphere, sphere_at(DVec3::ZERO, 1.0), material("conductor", &inputs));
    Known { name: "mirror ball", about: "head-on, a mirror ball shows the sky behind the viewer", scene, radiance }
}

/// A slab of absorbing glass under a uniform sky, seen along its normal. With r = ((n-1)/(n+1))^2 and t = exp(-a d), all
/// orders of internal reflection sum to T = (1-r)^2 t/(1 - r^2 t^2) and R = r + r (1-r)^2 t^2/(1 - r^2 t^2).
pub fn absorbing_slab() -> Known {
    let (absorption, depth, index) = (DVec3::new(0.2, 1.0, 4.0), 0.7, 1.5f64);
    let mut scene = narrow("absorbing-slab", DVec3::new(0.1, 2.0, 0.2), DVec3::new(0.1, 0.0, 0.2));
    let mut glass = material("dielectric", &[("eta", Value::scalar(index)), ("roughness", Value::scalar(0.0))]);
    glass.interior = Some(Medium { absorption });
    place(&mut scene, "top", Shape::Rectangle, floor_at(DVec3::ZERO, 50.0), glass.clone());
    let turn = glam::DQuat::from_rotation_x(0.5 * PI);
    let below = DAffine3::from_scale_rotation_translation(DVec3::splat(50.0), turn, DVec3::Y * -depth);
    place(&mut scene, "bottom", Shape::Rectangle, below, glass);
    scene.sky = Some(Sky { radiance: SkyRadiance::Uniform(DVec3::ONE), rotation_rad: 0.0, scale: 1.0 });
    let r = ((index - 1.0) / (index + 1.0)).powi(2);
    let sum = |a: f64| {
        let t = (-a * depth).exp();
        let series = (1.0 - r).powi(2) / (1.0 - r * r * t * t);
        series * t + r + r * t * t * series
    };
    Known {
        name: "absorbing slab",
        about: "transmission and reflection of an absorbing plate, all internal reflections",
        scene,
        radiance: DVec3::new(sum(absorption.x), sum(absorption.y), sum(absorption.z)),
    }
}

/// A black lamp under glass, seen along the normal: radiance shrinks by 1/n^2 on leaving, L = (1 - r) Le/n^2.
pub fn lamp_in_glass() -> Known {
    let (emission, index) = (DVec3::new(3.0, 2.0, 1.0), 1.5f64);
    let mut scene = narrow("lamp-in-glass", DVec3::new(0.1, 2.0, 0.2), DVec3::new(0.1, 0.0, 0.2));
    let glass = material("dielectric", &[("eta", Value::scalar(index)), ("roughness", Value::scalar(0.0))]);
    place(&mut scene, "surface", Shape::Rectangle, floor_at(DVec3::ZERO, 5.0), glass);
    place(&mut scene, "lamp", Shape::Rectangle, floor_at(DVec3::NEG_Y, 5.0), lamp(emission));
    let r = ((index - 1.0) / (index + 1.0)).powi(2);
    Known {
        name: "lamp in glass",
        about: "radiance leaving glass is divided by n^2",
        scene,
        radiance: emission * (1.0 - r) / (index * index),
    }
}

/// All of them.
pub fn all() -> Vec<Known> {
    let mut all = vec![
        furnace_sphere(),
        uniform_sky(),
        sphere_lamp(),
        rectangle_lamp(),
        disc_lamp(),
        disc_lamp_aside(),
        turned_sky(),
        mirror_ball(),
        absorbing_slab(),
        lamp_in_glass(),
        placed::scaled_copies(),
    ];
    all.extend(lights::all());
    all
}
