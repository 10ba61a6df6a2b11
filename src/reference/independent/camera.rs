//! Cameras and meters of the independent mode: from `scene::Camera`, without records, alias tables or the shared maps.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};

use super::super::path::Random;
use super::super::tree::Shape;
use super::{Independent, Stream, light};
use crate::camera::Start;
use crate::sampler::{self, Purpose};
use crate::scene::{Projection, SurfaceMeter, TextureFilter};

/// Elements of a surface meter: number of the primitive, and cumulative share of the area up to and including it.
pub(super) type Elements = Vec<(u32, f64)>;

/// Those of the scene's camera; empty for other cameras.
pub(super) fn elements(world: &Independent) -> Elements {
    let (Projection::MeterSurface(meter) | Projection::MeterLeaving(meter)) = &world.scene.camera.projection else {
        return Elements::new();
    };
    let instances = (0..world.scene.instances.len()).filter(|i| meter.shapes.contains(i));
    let of_meter = instances.flat_map(|i| world.primitives.of_instance(i));
    let areas: Vec<(u32, f64)> = of_meter.map(|n| (n, light::area(&world.primitives.get(n).shape))).collect();
    let total: f64 = areas.iter().map(|a| a.1).sum();
    let mut sum = 0.0;
    areas
        .into_iter()
        .map(|(primitive, area)| {
            sum += area;
            (primitive, sum / total)
        })
        .collect()
}

/// Diameter and growth of a pixel's cone: how far apart are the rays of two pixels in the middle, one above the other. Meters: 0.
pub(super) fn cone(world: &Independent) -> DVec2 {
    let film = &world.scene.film;
    let is_meter = !matches!(
        world.scene.camera.projection,
        Projection::Perspective { .. }
            | Projection::ThinLens { .. }
            | Projection::Orthographic { .. }
            | Projection::Panorama
    );
    if is_meter || world.scene.texture_filter != TextureFilter::Mipmap {
        return DVec2::ZERO;
    }
    let random = Stream::new(0, [0, 0], 0);
    let at = DVec2::new(0.5 * f64::from(film.width), 0.5 * f64::from(film.height));
    // A small step, so that the chord is the angle.
    let step = 1e-3;
    let [a, b] = [-0.5, 0.5].map(|k| start(world, at + DVec2::new(0.0, k * step), &random));
    DVec2::new(a.origin.distance(b.origin), a.direction.distance(b.direction)) / step
}

/// Through `film`, in pixels.
pub(super) fn start(world: &Independent, film: DVec2, random: &Stream) -> Start {
    let camera = &world.scene.camera;
    let size = DVec2::new(f64::from(world.scene.film.width), f64::from(world.scene.film.height));
    let position = camera.to_world.translation;
    let [x_axis, y_axis, z_axis] = {
        let m = camera.to_world.matrix3;
        [m.x_axis.normalize(), m.y_axis.normalize(), m.z_axis.normalize()]
    };
    // From -1 to 1 across the film, y up.
    let (x, y) = (2.0 * film.x / size.x - 1.0, 1.0 - 2.0 * film.y / size.y);
    let ahead = |fov_y_rad: f64| {
        let half_height = (0.5 * fov_y_rad).tan();
        x * half_height * size.x / size.y * x_axis + y * half_height * y_axis - z_axis
    };
    let number = |purpose: Purpose| random.unit(0, purpose);
    let plain = |origin: DVec3, direction: DVec3| Start {
        origin,
        direction: direction.normalize(),
        weight: 1.0,
        receiver: None,
    };
    match &camera.projection {
        Projection::Perspective { fov_y_rad } => plain(position, ahead(*fov_y_rad)),
        Projection::ThinLens { fov_y_rad, lens_radius, focus_distance } => {
            // Polar, where the shared map is concentric.
            let (r, angle) = (lens_radius * number(sampler::LENS_U).sqrt(), TAU * number(sampler::LENS_V));
            let lens = r * (angle.cos() * x_axis + angle.sin() * y_axis);
            plain(position + lens, focus_distance.unwrap_or(1.0) * ahead(*fov_y_rad) - lens)
        }
        Projection::Orthographic { half_width, half_height } => {
            let half_height = half_height.max(half_width * size.y / size.x);
            plain(position + half_height * (x * size.x / size.y * x_axis + y * y_axis), -z_axis)
        }
        Projection::Panorama => {
            // By the sky's formulas: u = 1/2 + longitude/(2 pi), v = (angle from up)/pi.
            let (longitude, from_up) = (TAU * (film.x / size.x - 0.5), PI * film.y / size.y);
            let level = longitude.sin() * x_axis - longitude.cos() * z_axis;
            plain(position, from_up.sin() * level + from_up.cos() * y_axis)
        }
        Projection::MeterRay => plain(position, -z_axis),
        Projection::MeterPoint => {
            let direction = hemisphere(-z_axis, random);
            Start { origin: position, direction, weight: PI, receiver: Some(-z_axis) }
        }
        Projection::MeterSurface(meter) => {
            let (origin, normal) = on_surface(world, meter, random);
            Start { origin, direction: hemisphere(normal, random), weight: PI, receiver: Some(normal) }
        }
        Projection::MeterLeaving(meter) => {
            let (origin, normal) = on_surface(world, meter, random);
            Start { origin, direction: -hemisphere(normal, random), weight: PI, receiver: None }
        }
    }
}

/// With density cos/pi about the unit `normal`: sin^2 of the angle is uniform.
fn hemisphere(normal: DVec3, random: &Stream) -> DVec3 {
    let (u, turn) = (random.unit(0, sampler::BSDF_U), TAU * random.unit(0, sampler::BSDF_V));
    let aside = normal.any_orthonormal_vector();
    let flat = turn.cos() * aside + turn.sin() * normal.cross(aside);
    u.sqrt() * flat + (1.0 - u).sqrt() * normal
}

/// A point a hair beside the measured side, uniform by area, and the side's normal.
fn on_surface(world: &Independent, meter: &SurfaceMeter, random: &Stream) -> (DVec3, DVec3) {
    let choice = random.unit(0, sampler::SENSOR_INDEX);
    let at = world.elements.partition_point(|e| e.1 <= choice).min(world.elements.len() - 1);
    let primitive = world.elements[at].0;
    let shape = &world.primitives.get(primitive).shape;
    let u = [random.unit(0, sampler::LENS_U), random.unit(0, sampler::LENS_V)];
    let (barycentric, position) = light::on_shape(shape, u);
    let front = world.point(primitive, barycentric, position).geometric_normal;
    let normal = if meter.is_back { -front } else { front };
    let extent = match shape {
        Shape::Triangle(v) => (v[1] - v[0]).length().max((v[2] - v[0]).length()),
        Shape::Sphere { radius, .. } | Shape::Disc { radius, .. } => *radius,
    };
    (position + 1e-9 * (extent + position.abs().max_element()) * normal, normal)
}
