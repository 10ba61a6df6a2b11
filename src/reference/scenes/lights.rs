//! Scenes of lights: every lamp at once, and emission from textures.

use glam::{DAffine2, DVec3};

use super::{empty, wall};
use crate::light::Lamp;
use crate::light::directional::Directional;
use crate::light::point::Point;
use crate::light::spot::{Falloff, Spot, one_minus_cos};
use crate::light::sun::Sun;
use crate::reference::known::{camera, lambert, lamp, place, sphere_at};
use crate::scene::*;

/// Every light without a surface, beside a sphere lamp and a sky: two balls and a shelf on a floor, each light with its own colour.
pub fn lamps(size: u32) -> Scene {
    let mut s = empty("lamps", camera(DVec3::new(0.0, 1.6, 4.2), DVec3::Y * 0.5, 40f64.to_radians()), size);
    place(&mut s, "floor", Shape::Rectangle, wall(DVec3::ZERO, DVec3::Y, [3.0, 3.0]), lambert(DVec3::splat(0.6)));
    for (x, color) in [(-0.8, DVec3::new(0.8, 0.3, 0.2)), (0.7, DVec3::new(0.3, 0.5, 0.8))] {
        place(&mut s, "ball", Shape::Sphere, sphere_at(DVec3::new(x, 0.45, 0.0), 0.45), lambert(color));
    }
    let shelf = wall(DVec3::new(0.0, 1.1, -0.6), DVec3::Y, [0.8, 0.2]);
    place(&mut s, "shelf", Shape::Rectangle, shelf, lambert(DVec3::splat(0.5)));
    let practical = Material { group: Some("practical".to_owned()), ..lamp(DVec3::new(6.0, 5.0, 3.0)) };
    place(&mut s, "globe", Shape::Sphere, sphere_at(DVec3::new(1.4, 1.4, 0.4), 0.15), practical);
    s.sky = Some(Sky { radiance: SkyRadiance::Uniform(DVec3::new(0.03, 0.04, 0.06)), rotation_rad: 0.0, scale: 1.0 });
    let h = |deg: f64| one_minus_cos(deg.to_radians());
    let toward = |x: f64, y: f64, z: f64| DVec3::new(x, y, z).normalize();
    let spot = |x: f64, axis, falloff, intensity| {
        Lamp::Spot(Spot { position: DVec3::new(x, 2.2, 0.8), axis, intensity, falloff })
    };
    let lamps = [
        Lamp::Point(Point { position: DVec3::new(0.0, 0.8, -0.6), intensity: DVec3::new(0.4, 0.6, 0.4) }),
        spot(-1.0, toward(0.1, -1.0, -0.4), Falloff::Hard { cone_h: h(16.0) }, DVec3::new(3.0, 1.0, 0.5)),
        spot(
            0.0,
            toward(0.0, -1.0, -0.3),
            Falloff::Smooth { inner_h: h(8.0), outer_h: h(22.0) },
            DVec3::new(0.5, 3.0, 1.0),
        ),
        spot(1.0, toward(0.2, -1.0, 0.1), Falloff::Cosine { exponent: 9.0 }, DVec3::new(0.5, 1.0, 3.0)),
        Lamp::Directional(Directional { to_light: toward(-1.0, 1.2, 0.6), irradiance: DVec3::new(0.5, 0.3, 0.4) }),
        Lamp::Sun(Sun {
            to_light: toward(1.0, 1.5, 1.0),
            irradiance: DVec3::new(0.6, 0.55, 0.4),
            half_angle_rad: 0.06,
        }),
    ];
    // The point and the sun are one group, spots and the directional light have none.
    let group = |k: usize| [0, 5].contains(&k).then(|| "key".to_owned());
    let light = |(k, lamp)| Light { name: format!("lamp {k}"), lamp, group: group(k) };
    s.lights = lamps.into_iter().enumerate().map(light).collect();
    s.sky_group = Some("sky".to_owned());
    s
}

/// Two wide suns of different light groups in view, over a ball on a floor, under a sky of a third.
pub fn suns(size: u32) -> Scene {
    let mut s = empty("suns", camera(DVec3::new(0.0, 1.2, 4.0), DVec3::Y, 70f64.to_radians()), size);
    place(&mut s, "floor", Shape::Rectangle, wall(DVec3::ZERO, DVec3::Y, [3.0, 3.0]), lambert(DVec3::splat(0.6)));
    let center = DVec3::new(-0.4, 0.5, 0.5);
    place(&mut s, "ball", Shape::Sphere, sphere_at(center, 0.5), lambert(DVec3::new(0.7, 0.6, 0.3)));
    let sun = |name: &str, x: f64, irradiance| Light {
        name: name.to_owned(),
        lamp: Lamp::Sun(Sun { to_light: DVec3::new(x, 0.4, -1.0).normalize(), irradiance, half_angle_rad: 0.25 }),
        group: Some(name.to_owned()),
    };
    s.lights = vec![sun("morning", 0.6, DVec3::new(0.8, 0.5, 0.3)), sun("evening", -0.5, DVec3::new(0.7, 0.3, 0.2))];
    s.sky = Some(Sky { radiance: SkyRadiance::Uniform(DVec3::new(0.1, 0.2, 0.4)), rotation_rad: 0.0, scale: 1.0 });
    s.sky_group = Some("sky".to_owned());
    s
}

/// Emission from textures on a rectangle, a mesh and a sphere, partly black, over a floor.
pub fn glowing(size: u32) -> Scene {
    let mut s = empty("glowing", camera(DVec3::new(0.0, 1.4, 4.0), DVec3::Y * 0.6, 40f64.to_radians()), size);
    place(&mut s, "floor", Shape::Rectangle, wall(DVec3::ZERO, DVec3::Y, [3.0, 3.0]), lambert(DVec3::splat(0.7)));
    s.textures.push(Texture::Checker { a: [4.0, 3.0, 1.0, 1.0], b: [0.0; 4], scale: [5.0, 5.0] });
    let bytes = (0..16u32).flat_map(|k| [(k * 17) as u8, (255 - k * 13) as u8, if k < 8 { 0 } else { 200 }, 255]);
    let pixels = Pixels::Rgba8(std::sync::Arc::new(bytes.collect()));
    s.images.push(Image { name: "glow".to_owned(), width: 4, height: 4, pixels });
    let (wrap, filter, encoding) = ([Wrap::Repeat; 2], Filter::Linear, Encoding::Srgb);
    s.textures.push(Texture::Image { image: 0, wrap, filter, minify: Minify::default(), encoding });
    let look_up = |texture| Value::Texture { texture, uv_set: 0, uv_transform: DAffine2::IDENTITY };
    let glow = |texture, strength: f64| Material {
        emission: Some(Value::Multiply(Box::new(look_up(texture)), Box::new(Value::scalar(strength)))),
        ..lambert(DVec3::splat(0.2))
    };
    let panel = Material { group: Some("panel".to_owned()), ..glow(0, 1.0) };
    place(&mut s, "panel", Shape::Rectangle, wall(DVec3::new(-0.9, 1.0, -0.5), DVec3::Z, [0.6, 0.5]), panel);
    place(&mut s, "globe", Shape::Sphere, sphere_at(DVec3::new(0.8, 0.7, 0.2), 0.4), glow(1, 3.0));
    s.meshes.push(Mesh {
        name: "tile".to_owned(),
        positions: vec![[-0.5, 0.02, 0.9], [0.5, 0.02, 0.9], [0.0, 0.3, 1.4]],
        uvs: [Some(vec![[0.0, 0.0], [2.0, 0.0], [1.0, 2.0]]), None],
        triangles: vec![[0, 1, 2]],
        ..Mesh::default()
    });
    let tile = Material { emission_two_sided: true, ..glow(1, 1.0) };
    place(&mut s, "tile", Shape::Mesh(0), glam::DAffine3::IDENTITY, tile);
    s
}
