//! Small scenes without a closed form, for comparing image with image (gate 7) and estimator with estimator.
//!
//! Each needs features that the others lack, so that a fault names its place.

mod layers;
pub mod lights;
mod placed;

pub use layers::{layers, mixtures};

use std::f64::consts::PI;

use glam::{DAffine3, DQuat, DVec3};

use super::known::{camera, lambert, lamp, material, place, sphere_at};
use crate::scene::*;
pub use placed::placed;

fn empty(name: &str, camera: Camera, size: u32) -> Scene {
    Scene { name: name.to_owned(), camera, film: Film::sized(size, size), ..Scene::default() }
}

/// Rectangle of half-sizes `half` whose front faces `normal`.
fn wall(center: DVec3, normal: DVec3, half: [f64; 2]) -> DAffine3 {
    let turn = DQuat::from_rotation_arc(DVec3::Z, normal);
    DAffine3::from_scale_rotation_translation(DVec3::new(half[0], half[1], 1.0), turn, center)
}

/// Box mesh [-1,1]^3 with flat sides, front outside.
fn block() -> Mesh {
    let corner = |i: u32| [0, 1, 2].map(|a| if i >> a & 1 == 1 { 1.0f32 } else { -1.0 });
    let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    Mesh {
        name: "block".to_owned(),
        positions: (0..8).map(corner).collect(),
        triangles: quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).collect(),
        ..Mesh::default()
    }
}

/// The Cornell box (Goral et al. 1984, proportions simplified): 5 walls, a lamp in the ceiling, two turned blocks.
pub fn cornell(size: u32) -> Scene {
    let mut s = empty("cornell", camera(DVec3::new(0.0, 1.0, 3.9), DVec3::Y, 38f64.to_radians()), size);
    let (white, red, green) = (DVec3::splat(0.73), DVec3::new(0.63, 0.06, 0.05), DVec3::new(0.14, 0.45, 0.09));
    let mut side = |name, center, normal, albedo| {
        place(&mut s, name, Shape::Rectangle, wall(center, normal, [1.0, 1.0]), lambert(albedo));
    };
    side("floor", DVec3::ZERO, DVec3::Y, white);
    side("ceiling", DVec3::Y * 2.0, DVec3::NEG_Y, white);
    side("back", DVec3::new(0.0, 1.0, -1.0), DVec3::Z, white);
    side("left", DVec3::new(-1.0, 1.0, 0.0), DVec3::X, red);
    side("right", DVec3::new(1.0, 1.0, 0.0), DVec3::NEG_X, green);
    s.meshes.push(block());
    for (name, center, half_height, angle) in [
        ("tall", DVec3::new(-0.35, 0.6, -0.3), 0.6, 0.3 * PI / 3.0),
        ("short", DVec3::new(0.35, 0.3, 0.35), 0.3, -0.3 * PI / 3.0),
    ] {
        let to_world = DAffine3::from_scale_rotation_translation(
            DVec3::new(0.3, half_height, 0.3),
            DQuat::from_rotation_y(angle),
            center,
        );
        place(&mut s, name, Shape::Mesh(0), to_world, lambert(white));
    }
    let emission = DVec3::new(17.0, 12.0, 4.0);
    place(&mut s, "lamp", Shape::Rectangle, wall(DVec3::Y * 1.99, DVec3::NEG_Y, [0.25, 0.2]), lamp(emission));
    s
}

/// A sphere lamp beside a diffuse ball on a floor: solid-angle sampling of spheres, soft shadows.
pub fn sphere_lamps(size: u32) -> Scene {
    let mut s = empty("sphere-lamps", camera(DVec3::new(0.0, 1.2, 4.0), DVec3::Y * 0.5, 40f64.to_radians()), size);
    place(&mut s, "floor", Shape::Rectangle, wall(DVec3::ZERO, DVec3::Y, [4.0, 4.0]), lambert(DVec3::splat(0.6)));
    let ball = lambert(DVec3::new(0.2, 0.5, 0.8));
    place(&mut s, "ball", Shape::Sphere, sphere_at(DVec3::new(-0.5, 0.5, 0.0), 0.5), ball);
    let bright = lamp(DVec3::new(9.0, 7.0, 5.0));
    place(&mut s, "lamp", Shape::Sphere, sphere_at(DVec3::new(0.8, 1.1, 0.3), 0.25), bright);
    let mut large = lamp(DVec3::new(1.5, 2.0, 3.0));
    large.emission_two_sided = true;
    place(&mut s, "large lamp", Shape::Sphere, sphere_at(DVec3::new(-3.0, 4.0, 2.0), 1.0), large);
    s
}

/// Alpha-blended and masked sheets, one of them shining, over a floor under a sky.
pub fn alpha_sheets(size: u32) -> Scene {
    let mut s = empty("alpha-sheets", camera(DVec3::new(0.0, 1.5, 4.0), DVec3::Y * 0.6, 40f64.to_radians()), size);
    s.textures.push(Texture::Checker { a: [1.0; 4], b: [0.0; 4], scale: [6.0, 6.0] });
    let checker = || Value::Texture { texture: 0, uv_set: 0, uv_transform: glam::DAffine2::IDENTITY };
    place(&mut s, "floor", Shape::Rectangle, wall(DVec3::ZERO, DVec3::Y, [3.0, 3.0]), lambert(DVec3::splat(0.7)));
    let half = Material { alpha: Alpha::Blend { value: Value::scalar(0.4) }, ..lambert(DVec3::new(0.8, 0.3, 0.2)) };
    place(&mut s, "veil", Shape::Rectangle, wall(DVec3::new(-0.8, 0.8, 0.3), DVec3::Z, [0.6, 0.7]), half.clone());
    place(&mut s, "veil ball", Shape::Sphere, sphere_at(DVec3::new(0.0, 0.5, 0.9), 0.35), half);
    let grid = Material { alpha: Alpha::Mask { value: checker(), cutoff: 0.5 }, ..lambert(DVec3::new(0.2, 0.6, 0.3)) };
    place(&mut s, "grid", Shape::Rectangle, wall(DVec3::new(0.8, 0.8, 0.0), DVec3::Z, [0.6, 0.7]), grid);
    let mut neon = lamp(DVec3::new(6.0, 4.0, 8.0));
    neon.emission_two_sided = true;
    neon.alpha = Alpha::Blend { value: Value::scalar(0.5) };
    neon.group = Some("neon".to_owned());
    place(&mut s, "neon", Shape::Rectangle, wall(DVec3::new(0.0, 1.6, -0.6), DVec3::Z, [0.8, 0.1]), neon);
    s.sky = Some(Sky { radiance: SkyRadiance::Uniform(DVec3::new(0.3, 0.4, 0.6)), rotation_rad: 0.0, scale: 1.0 });
    s
}

/// A 16 x 8 sky: dim, with one hot texel in its upper half.
fn hot_sky() -> Image {
    let (width, height) = (16u32, 8u32);
    let texel = |k: u32| match (k % width, k / width) {
        (11, 2) => [90.0, 80.0, 60.0],
        (_, j) if j < height / 2 => [0.4, 0.6, 0.9],
        _ => [0.15, 0.12, 0.1],
    };
    let pixels = (0..width * height).flat_map(texel).collect::<Vec<f32>>();
    Image { name: "hot sky".to_owned(), width, height, pixels: Pixels::RgbF32(pixels.into()) }
}

/// Transform of the stretched ball of `textured`: its normals need the inverse transpose.
pub fn stretched_ball() -> DAffine3 {
    DAffine3::from_scale_rotation_translation(
        DVec3::new(0.5, 0.9, 0.3),
        DQuat::from_rotation_z(0.5),
        DVec3::new(-0.9, 0.9, 0.0),
    )
}

/// Textures, vertex colours, uv transforms, a normal map, a stretched and two mirrored instances, under a turned sky.
pub fn textured(size: u32) -> Scene {
    let mut s = empty("textured", camera(DVec3::new(0.5, 1.8, 4.0), DVec3::Y * 0.5, 40f64.to_radians()), size);
    s.images.push(hot_sky());
    s.sky = Some(Sky { radiance: SkyRadiance::Image(0), rotation_rad: 0.7, scale: 0.8 });
    let (width, height) = (8u32, 8u32);
    let bytes: Vec<u8> = (0..width * height)
        .flat_map(|k| {
            let (x, y) = (k % width, k / width);
            [(40 + 25 * x) as u8, (230 - 24 * y) as u8, if (x + y) % 2 == 0 { 220 } else { 60 }, 255]
        })
        .collect();
    s.images.push(Image { name: "grid".to_owned(), width, height, pixels: Pixels::Rgba8(bytes.into()) });
    let image = |filter, encoding, wrap| {
        let minify = Minify { filter, ..Minify::default() };
        Texture::Image { image: 1, wrap: [wrap; 2], filter, minify, encoding }
    };
    s.textures.push(image(Filter::Linear, Encoding::Srgb, Wrap::Repeat));
    s.textures.push(image(Filter::Nearest, Encoding::Linear, Wrap::Mirror));
    s.textures.push(Texture::Checker { a: [0.8; 4], b: [0.1, 0.1, 0.3, 1.0], scale: [4.0, 4.0] });
    let look_up = |texture, scale: f64, angle: f64| Value::Texture {
        texture,
        uv_set: 0,
        uv_transform: glam::DAffine2::from_scale_angle_translation(
            glam::DVec2::splat(scale),
            angle,
            glam::DVec2::new(0.13, -0.4),
        ),
    };
    let painted = |value| material("lambert", &[("albedo", value)]);
    let floor = wall(DVec3::ZERO, DVec3::Y, [3.0, 3.0]);
    place(&mut s, "floor", Shape::Rectangle, floor, painted(look_up(2, 2.0, 0.3)));
    s.meshes.push(bumpy_sphere(24, 12));
    let body =
        |scale, angle, center| DAffine3::from_scale_rotation_translation(scale, DQuat::from_rotation_z(angle), center);
    place(&mut s, "stretched", Shape::Mesh(0), stretched_ball(), painted(look_up(0, 2.0, 0.0)));
    let mirrored = body(DVec3::new(-0.6, 0.6, 0.6), 0.2, DVec3::new(0.9, 0.6, 0.2));
    let tinted = Value::Multiply(Box::new(Value::VertexColor), Box::new(look_up(1, 3.0, 0.4)));
    place(&mut s, "mirrored", Shape::Mesh(0), mirrored, painted(tinted));
    place(&mut s, "globe", Shape::Sphere, mirrored_globe(), slanted(painted(look_up(0, 1.0, 0.0))));
    s
}

/// Transform of the globe of `textured`: turned and mirrored.
pub fn mirrored_globe() -> DAffine3 {
    DAffine3::from_scale_rotation_translation(
        DVec3::new(-0.4, 0.4, 0.4),
        DQuat::from_rotation_x(0.9),
        DVec3::new(0.0, 0.4, 1.0),
    )
}

/// With a normal map that tilts every normal alike, towards growing u and up the picture.
pub fn slanted(material: Material) -> Material {
    Material { normal_map: Some((Value::rgb(0.65, 0.6, 0.95), 1.0)), ..material }
}

/// Pictures seen far smaller than their texels, read by footprints: a floor to the horizon, mirrored, turned and by normal map.
pub fn mipmapped(size: u32) -> Scene {
    let mut s = textured(size);
    s.name = "mipmapped".to_owned();
    s.texture_filter = TextureFilter::Mipmap;
    // Odd sizes, and an alpha that colours are weighed by.
    let (width, height) = (53u32, 37u32);
    let bytes: Vec<u8> = (0..width * height)
        .flat_map(|k| {
            let (x, y) = (k % width, k / width);
            let is_odd = (x / 3 + y / 2) % 2 == 1;
            [if is_odd { 230 } else { 20 }, (5 * x % 256) as u8, (7 * y % 256) as u8, if is_odd { 255 } else { 90 }]
        })
        .collect();
    s.images.push(Image { name: "fine".to_owned(), width, height, pixels: Pixels::Rgba8(bytes.into()) });
    let image = s.images.len() - 1;
    let first = s.textures.len();
    for (encoding, levels) in [(Encoding::Srgb, Some(Filter::Linear)), (Encoding::Linear, Some(Filter::Nearest))] {
        let minify = Minify { filter: Filter::Linear, levels };
        s.textures.push(Texture::Image { image, wrap: [Wrap::Repeat; 2], filter: Filter::Nearest, minify, encoding });
    }
    let look_up = |texture: usize, scale: f64| Value::Texture {
        texture: first + texture,
        uv_set: 0,
        uv_transform: glam::DAffine2::from_scale_angle_translation(
            glam::DVec2::new(scale, 0.7 * scale),
            0.2,
            glam::DVec2::new(0.1, 0.3),
        ),
    };
    s.materials[s.instances[0].material] = material("lambert", &[("albedo", look_up(0, 9.0))]);
    let ball = s.instances[1].material;
    s.materials[ball] = material("lambert", &[("albedo", Value::rgb(0.5, 0.6, 0.7))]);
    s.materials[ball].normal_map = Some((look_up(1, 3.0), 0.2));
    let mut sheet = material("lambert", &[("albedo", look_up(0, 4.0))]);
    sheet.alpha = Alpha::Blend { value: Value::Channel(Box::new(look_up(0, 4.0)), 3) };
    place(&mut s, "sheet", Shape::Rectangle, wall(DVec3::new(0.0, 1.0, -1.5), DVec3::Z, [1.5, 0.6]), sheet);
    let mirror = material("conductor", &[("roughness", Value::scalar(0.0))]);
    place(&mut s, "mirror", Shape::Rectangle, wall(DVec3::new(-1.8, 0.8, 0.2), DVec3::X, [0.8, 0.8]), mirror);
    s
}

/// Unit sphere of columns x rows quads with smooth normals, uvs, tangents and vertex colours.
fn bumpy_sphere(columns: u32, rows: u32) -> Mesh {
    let mut mesh = Mesh { name: "ball".to_owned(), ..Mesh::default() };
    let (mut normals, mut tangents, mut uvs, mut colors) = (vec![], vec![], vec![], vec![]);
    for j in 0..=rows {
        for i in 0..=columns {
            let (u, v) = (f64::from(i) / f64::from(columns), f64::from(j) / f64::from(rows));
            let (phi, theta) = (2.0 * PI * u, PI * v);
            let n = DVec3::new(theta.sin() * phi.sin(), theta.cos(), -theta.sin() * phi.cos());
            let t = DVec3::new(phi.cos(), 0.0, phi.sin());
            mesh.positions.push(n.as_vec3().to_array());
            normals.push(n.as_vec3().to_array());
            tangents.push(t.as_vec3().extend(1.0).to_array());
            uvs.push([u as f32, v as f32]);
            colors.push([1.0, (0.4 + 0.6 * v) as f32, (1.0 - 0.7 * u) as f32, 1.0]);
        }
    }
    for j in 0..rows {
        for i in 0..columns {
            let a = j * (columns + 1) + i;
            let (b, c, d) = (a + 1, a + columns + 2, a + columns + 1);
            // Seen from outside, u grows to the left of -z: counter-clockwise is a, b, c.
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh.normals = Some(normals);
    mesh.tangents = Some(tangents);
    mesh.uvs = [Some(uvs), None];
    mesh.colors = Some(colors);
    mesh
}

/// Spheres of every model that is not Lambert, on a floor, under the hot sky and a lamp. The model's tables, delta lobes,
/// anisotropy, absorption and thin walls are all in use.
pub fn materials(size: u32) -> Scene {
    let mut s = empty("materials", camera(DVec3::new(0.0, 1.6, 4.2), DVec3::Y * 0.6, 40f64.to_radians()), size);
    s.images.push(hot_sky());
    s.sky = Some(Sky { radiance: SkyRadiance::Image(0), rotation_rad: 2.0, scale: 0.7 });
    let floor = wall(DVec3::ZERO, DVec3::Y, [3.0, 3.0]);
    place(&mut s, "floor", Shape::Rectangle, floor, lambert(DVec3::new(0.6, 0.55, 0.5)));
    let value = Value::scalar;
    let mut absorbing = material("dielectric", &[]);
    absorbing.interior = Some(Medium { absorption: DVec3::new(0.3, 1.0, 2.5) });
    let balls = [
        material("conductor", &[("roughness", value(0.5)), ("roughness_y", value(0.25))]),
        absorbing,
        material("dielectric", &[("roughness", value(0.45)), ("eta", value(1.4))]),
        material(
            "gltf",
            &[("base_color", Value::rgb(0.8, 0.3, 0.2)), ("metallic", value(0.3)), ("roughness", value(0.5))],
        ),
        material("conductor", &[("roughness", value(0.0))]),
    ];
    for (k, ball) in balls.into_iter().enumerate() {
        let center = DVec3::new(0.8 * (k as f64 - 2.0), 0.38, 0.2 * (k % 2) as f64);
        place(&mut s, &format!("ball {k}"), Shape::Sphere, sphere_at(center, 0.38), ball);
    }
    let pane = material("thin_dielectric", &[("tint", Value::rgb(0.9, 0.5, 0.4))]);
    place(&mut s, "pane", Shape::Rectangle, wall(DVec3::new(-0.8, 0.7, 0.9), DVec3::Z, [0.25, 0.4]), pane);
    let center = DVec3::new(1.2, 1.9, 0.8);
    place(&mut s, "lamp", Shape::Sphere, sphere_at(center, 0.3), lamp(DVec3::new(8.0, 7.0, 5.0)));
    s
}

/// Discs in every use: painted, brushed, veiled, mirrored, and shining.
pub fn discs(size: u32) -> Scene {
    let mut s = empty("discs", camera(DVec3::new(0.3, 1.4, 4.0), DVec3::Y * 0.5, 40f64.to_radians()), size);
    s.textures.push(Texture::Checker { a: [0.8; 4], b: [0.1, 0.2, 0.4, 1.0], scale: [6.0, 6.0] });
    let checker = || Value::Texture { texture: 0, uv_set: 0, uv_transform: glam::DAffine2::IDENTITY };
    let plate = |center, normal, radius| wall(center, normal, [radius, radius]);
    let painted = material("lambert", &[("albedo", checker())]);
    place(&mut s, "floor", Shape::Disc, plate(DVec3::ZERO, DVec3::Y, 2.5), painted.clone());
    let tilted = DVec3::new(0.5, 0.3, 0.8).normalize();
    let brushed = material("conductor", &[("roughness", Value::scalar(0.5)), ("roughness_y", Value::scalar(0.2))]);
    place(&mut s, "brushed", Shape::Disc, plate(DVec3::new(-0.9, 0.7, 0.0), tilted, 0.6), brushed);
    let mirror = DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0));
    place(&mut s, "mirrored", Shape::Disc, plate(DVec3::new(0.9, 0.6, -0.2), DVec3::Z, 0.55) * mirror, painted);
    let veil = Material { alpha: Alpha::Blend { value: Value::scalar(0.4) }, ..lambert(DVec3::new(0.8, 0.3, 0.2)) };
    place(&mut s, "veil", Shape::Disc, plate(DVec3::new(0.1, 0.5, 1.0), DVec3::new(-0.6, 0.0, 0.8), 0.4), veil);
    let down = DVec3::new(0.1, -1.0, 0.2).normalize();
    let center = DVec3::new(0.2, 2.2, 0.4);
    place(&mut s, "lamp", Shape::Disc, plate(center, down, 0.35), lamp(DVec3::new(9.0, 8.0, 6.0)));
    let mut small = lamp(DVec3::new(20.0, 30.0, 40.0));
    small.emission_two_sided = true;
    place(&mut s, "small lamp", Shape::Disc, plate(DVec3::new(-0.3, 0.9, 0.5), DVec3::X, 0.06), small);
    s
}

/// A glass ball full of absorbing water with a metal ball in it, a smaller glass across its wall, on a floor under a sky and a lamp.
pub fn nested(size: u32) -> Scene {
    let mut s = empty("nested", camera(DVec3::new(0.0, 1.2, 3.6), DVec3::Y * 0.6, 40f64.to_radians()), size);
    let floor = wall(DVec3::ZERO, DVec3::Y, [3.0, 3.0]);
    place(&mut s, "floor", Shape::Rectangle, floor, lambert(DVec3::new(0.6, 0.55, 0.5)));
    let body = |index, roughness, absorption, priority| {
        let inputs = [("eta", Value::scalar(index)), ("roughness", Value::scalar(roughness))];
        Material { interior: Some(Medium { absorption }), priority, ..material("dielectric", &inputs) }
    };
    let center = DVec3::Y * 0.75;
    place(&mut s, "glass", Shape::Sphere, sphere_at(center, 0.7), body(1.5, 0.0, DVec3::new(0.3, 0.1, 0.2), 1));
    place(&mut s, "water", Shape::Sphere, sphere_at(center, 0.6), body(1.33, 0.0, DVec3::new(1.2, 0.4, 0.1), 2));
    let metal = material("conductor", &[("roughness", Value::scalar(0.3))]);
    place(&mut s, "metal", Shape::Sphere, sphere_at(center - 0.2 * DVec3::X, 0.2), metal);
    let across = body(1.7, 0.4, DVec3::new(0.2, 0.8, 0.8), 3);
    place(&mut s, "across", Shape::Sphere, sphere_at(center + DVec3::new(0.45, 0.2, 0.3), 0.25), across);
    s.sky = Some(Sky { radiance: SkyRadiance::Uniform(DVec3::new(0.4, 0.5, 0.7)), rotation_rad: 0.0, scale: 1.0 });
    let bright = lamp(DVec3::new(9.0, 7.0, 5.0));
    place(&mut s, "lamp", Shape::Sphere, sphere_at(DVec3::new(0.8, 2.1, 0.8), 0.4), bright);
    s
}

/// A wide floor with a ball and a small lamp beside it, under a dim sky with a sun of half a degree.
pub fn small_sun(size: u32) -> Scene {
    let mut s = empty("small-sun", camera(DVec3::new(0.0, 1.2, 4.0), DVec3::Y * 0.5, 40f64.to_radians()), size);
    let (width, height) = (720u32, 360u32);
    let texel = |k: u32| match (k % width, k / width) {
        (500, 100) => [60_000.0, 55_000.0, 45_000.0],
        (_, j) if j < height / 2 => [0.2, 0.3, 0.5],
        _ => [0.1, 0.1, 0.1],
    };
    let pixels = (0..width * height).flat_map(texel).collect::<Vec<f32>>();
    s.images.push(Image { name: "sun".to_owned(), width, height, pixels: Pixels::RgbF32(pixels.into()) });
    s.sky = Some(Sky { radiance: SkyRadiance::Image(0), rotation_rad: 0.0, scale: 1.0 });
    place(&mut s, "floor", Shape::Rectangle, wall(DVec3::ZERO, DVec3::Y, [30.0, 30.0]), lambert(DVec3::splat(0.5)));
    place(&mut s, "ball", Shape::Sphere, sphere_at(DVec3::new(0.3, 0.5, 0.0), 0.5), lambert(DVec3::splat(0.7)));
    let center = DVec3::new(-0.9, 0.4, 0.5);
    place(&mut s, "lamp", Shape::Sphere, sphere_at(center, 0.05), lamp(DVec3::new(400.0, 300.0, 200.0)));
    s
}

/// The Cornell box closed by a wall with a window in front, seen from inside, under a white sky.
pub fn room_with_window(size: u32) -> Scene {
    let mut s = cornell(size);
    s.name = "room".to_owned();
    s.camera = camera(DVec3::new(0.0, 1.0, 0.9), DVec3::Y, 80f64.to_radians());
    for (center, half) in [
        (DVec3::new(0.0, 0.3, 1.0), [1.0, 0.3]),
        (DVec3::new(0.0, 1.7, 1.0), [1.0, 0.3]),
        (DVec3::new(-0.7, 1.0, 1.0), [0.3, 0.4]),
        (DVec3::new(0.7, 1.0, 1.0), [0.3, 0.4]),
    ] {
        place(&mut s, "front", Shape::Rectangle, wall(center, DVec3::NEG_Z, half), lambert(DVec3::splat(0.73)));
    }
    s.sky = Some(Sky { radiance: SkyRadiance::Uniform(DVec3::splat(6.0)), rotation_rad: 0.0, scale: 1.0 });
    s
}

/// All of them at a size.
pub fn all(size: u32) -> Vec<Scene> {
    vec![
        cornell(size),
        sphere_lamps(size),
        alpha_sheets(size),
        textured(size),
        materials(size),
        nested(size),
        discs(size),
        lights::lamps(size),
        lights::glowing(size),
        layers(size),
        placed(size),
        mixtures(size),
    ]
}
