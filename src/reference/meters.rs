//! Meters whose reading is known in closed form. As a meter is a camera, each is a `Known` like the scenes of `known`: every pixel is the
//! answer, here in the meter's own unit.

use std::f64::consts::PI;

use glam::{DAffine3, DMat3, DVec3};

use super::known::{Known, floor_at, lambert, lamp, material, place, sphere_at};
use crate::light::Lamp;
use crate::light::directional::Directional;
use crate::light::integrals::polygon_irradiance;
use crate::light::point::Point;
use crate::light::sun::Sun;
use crate::scene::*;

/// `scene` as `place` of it sees it, in 8 x 8 pixels.
fn known(name: &'static str, about: &'static str, mut scene: Scene, place: Place, answer: DVec3) -> Known {
    let sensor = Sensor { name: name.to_owned(), quantity: Quantity::Irradiance, place };
    scene.name = name.replace(' ', "-");
    scene.film = Film { width: 8, height: 8, ..Film::default() };
    scene.camera = sensor.camera(&scene);
    Known { name, about, scene, radiance: answer }
}

fn point(position: DVec3, normal: DVec3) -> Place {
    Place::Point { position, normal: normal.normalize() }
}

fn surface(shapes: &[usize], is_back: bool, is_leaving: bool) -> Place {
    Place::Surface { meter: SurfaceMeter { shapes: shapes.to_vec(), is_back }, is_leaving }
}

fn sky(radiance: DVec3) -> Option<Sky> {
    Some(Sky { radiance: SkyRadiance::Uniform(radiance), rotation_rad: 0.0, scale: 1.0 })
}

/// A tilted patch whose hemisphere is all sky.
pub fn under_the_sky() -> Known {
    let radiance = DVec3::new(1.0, 0.5, 2.0);
    let mut scene = Scene { sky: sky(radiance), ..Scene::default() };
    let normal = DVec3::new(0.3, 0.9, -0.2);
    place(&mut scene, "ball", Shape::Sphere, sphere_at(-3.0 * normal, 1.0), lambert(DVec3::splat(0.5)));
    let about = "irradiance under a uniform sky: E = pi L";
    known("meter under the sky", about, scene, point(DVec3::ZERO, normal), PI * radiance)
}

/// Cosine law and inverse square at once, the lamp 5 degrees above the horizon of the patch.
pub fn grazing_lamp() -> Known {
    let emission = DVec3::new(100.0, 80.0, 40.0);
    let (radius, distance, theta) = (0.1, 3.0, 85f64.to_radians());
    let mut scene = Scene::default();
    let center = distance * DVec3::new(theta.sin(), theta.cos(), 0.0);
    place(&mut scene, "lamp", Shape::Sphere, sphere_at(center, radius), lamp(emission));
    let answer = PI * emission * (radius / distance).powi(2) * theta.cos();
    let about = "irradiance of a sphere lamp: E = pi L (R/d)^2 cos(theta), theta = 85 degrees";
    known("meter at a grazing lamp", about, scene, point(DVec3::ZERO, DVec3::Y), answer)
}

/// The horizon of the patch cuts the lamp.
pub fn polygon_lamp() -> Known {
    let emission = DVec3::new(3.0, 2.0, 1.0);
    let corners = [[-0.5, -0.3, 1.0], [0.5, -0.3, 1.2], [0.7, 0.6, 1.1], [-0.5, 0.6, 0.9]].map(DVec3::from);
    // Flat: the last corner is moved into the plane of the others.
    let plane = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize();
    let corners = [corners[0], corners[1], corners[2], corners[3] - plane * plane.dot(corners[3] - corners[0])];
    let corners = corners.map(|c| c.as_vec3().as_dvec3());
    let mut scene = Scene::default();
    scene.meshes.push(Mesh {
        positions: corners.iter().map(|c| c.as_vec3().to_array()).collect(),
        // Facing the origin.
        triangles: vec![[0, 2, 1], [0, 3, 2]],
        ..Mesh::default()
    });
    place(&mut scene, "lamp", Shape::Mesh(0), DAffine3::IDENTITY, lamp(emission));
    let normal = DVec3::new(0.3, 0.8, 0.4).normalize();
    let answer = emission * polygon_irradiance(DVec3::ZERO, normal, &corners);
    let about = "irradiance of a quadrangle by Lambert's formula, cut by the horizon";
    known("meter and polygon", about, scene, point(DVec3::ZERO, normal), answer)
}

/// Disc of radius R at height h above the patch: E = pi L R^2/(R^2 + h^2).
pub fn disc_lamp() -> Known {
    let emission = DVec3::new(3.0, 2.0, 1.0);
    let (radius, height) = (0.8, 1.1);
    let mut scene = Scene::default();
    place(&mut scene, "lamp", Shape::Disc, disc(DVec3::Y * height, radius, DVec3::NEG_Y), lamp(emission));
    let answer = PI * emission * radius * radius / (radius * radius + height * height);
    let about = "irradiance under a disc lamp: E = pi L R^2/(R^2 + h^2)";
    known("meter and disc", about, scene, point(DVec3::ZERO, DVec3::Y), answer)
}

fn disc(center: DVec3, radius: f64, normal: DVec3) -> DAffine3 {
    let turn = glam::DQuat::from_rotation_arc(DVec3::Z, normal);
    DAffine3::from_scale_rotation_translation(DVec3::splat(radius), turn, center)
}

/// Flux of a sphere lamp through a disc below it: intensity pi R^2 L times the disc's solid angle.
pub fn flux_through_disc() -> Known {
    let emission = DVec3::new(3.0, 2.0, 1.0);
    let (lamp_radius, radius, height) = (0.2, 0.9, 0.6);
    let mut scene = Scene::default();
    let plate = disc(DVec3::new(2.0, 1.0, -1.0), radius, DVec3::X);
    place(&mut scene, "plate", Shape::Disc, plate, lambert(DVec3::splat(0.5)));
    let center = DVec3::new(2.0 + height, 1.0, -1.0);
    place(&mut scene, "lamp", Shape::Sphere, sphere_at(center, lamp_radius), lamp(emission));
    let solid_angle = 2.0 * PI * (1.0 - height / height.hypot(radius));
    let answer = PI * lamp_radius * lamp_radius * emission * solid_angle / (PI * radius * radius);
    known("flux through a disc", "flux of a sphere lamp through a disc", scene, surface(&[0], false, false), answer)
}

/// All of a lamp's power arrives inside a black ball around it: E = Phi/A, wherever in the ball the lamp is.
pub fn lamp_in_a_ball() -> Known {
    let emission = DVec3::new(3.0, 2.0, 1.0);
    let (small, large) = (0.25, 1.5);
    let mut scene = Scene::default();
    place(&mut scene, "lamp", Shape::Sphere, sphere_at(DVec3::new(0.4, -0.3, 0.6), small), lamp(emission));
    place(&mut scene, "ball", Shape::Sphere, sphere_at(DVec3::ZERO, large), lambert(DVec3::ZERO));
    let answer = PI * emission * (small / large).powi(2);
    let about = "flux into a closed ball around a lamp is the lamp's power";
    known("flux into a ball", about, scene, surface(&[1], true, false), answer)
}

/// Area, mirroring and stretching of a mesh, and choice by area: a sphere lamp above a flat mesh of unequal triangles acts as a point of
/// intensity pi R^2 L, whose flux through the mesh is that times the solid angle of the mesh.
pub fn unequal_triangles() -> Known {
    let emission = DVec3::new(3.0, 2.0, 1.0);
    let (radius, center) = (0.2, DVec3::new(0.4, 1.0, 0.1));
    let mut scene = Scene::default();
    scene.meshes.push(Mesh {
        // [-1, 1]^2 in x and z, a fan about a point off the middle; front towards -y, which the mirror makes +y.
        positions: vec![[-1.0, 0.0, -1.0], [1.0, 0.0, -1.0], [1.0, 0.0, 1.0], [-1.0, 0.0, 1.0], [0.75, 0.0, -0.5]],
        triangles: vec![[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]],
        ..Mesh::default()
    });
    let to_world = DAffine3::from_mat3(DMat3::from_diagonal(DVec3::new(2.0, -1.0, 1.0)));
    place(&mut scene, "plate", Shape::Mesh(0), to_world, lambert(DVec3::splat(0.5)));
    place(&mut scene, "lamp", Shape::Sphere, sphere_at(center, radius), lamp(emission));
    // Solid angle of a rectangle from a point above: signed quarters, each atan(a b/(h sqrt(a^2 + b^2 + h^2))).
    let quarter = |a: f64, b: f64| (a * b / (center.y * (a * a + b * b + center.y * center.y).sqrt())).atan();
    let (x, z) = ([-2.0 - center.x, 2.0 - center.x], [-1.0 - center.z, 1.0 - center.z]);
    let solid_angle = quarter(x[1], z[1]) - quarter(x[0], z[1]) - quarter(x[1], z[0]) + quarter(x[0], z[0]);
    let answer = PI * radius * radius * emission * solid_angle / (4.0 * 2.0);
    let about = "flux of a sphere lamp through a mirrored, stretched mesh of unequal triangles";
    known("flux through a mesh", about, scene, surface(&[0], false, false), answer)
}

/// What leaves a floor that shines and reflects: M = pi (Le + rho L).
pub fn leaving_floor() -> Known {
    let (albedo, emission, radiance) =
        (DVec3::new(0.5, 0.2, 0.8), DVec3::new(1.0, 2.0, 0.5), DVec3::new(2.0, 1.0, 1.5));
    let mut scene = Scene { sky: sky(radiance), ..Scene::default() };
    let mut floor = lambert(albedo);
    floor.emission = Some(Value::rgb(emission.x, emission.y, emission.z));
    place(&mut scene, "floor", Shape::Rectangle, floor_at(DVec3::new(1.0, 2.0, 3.0), 1.5), floor);
    let about = "exitance of a floor that shines and reflects: M = pi (Le + rho L)";
    known("leaving floor", about, scene, surface(&[0], false, true), PI * (emission + albedo * radiance))
}

/// The first law: along a ray radiance does not change, from 1 mm or from 1 km, nor when a lamp is made larger.
pub fn far_wall() -> Known {
    let emission = DVec3::new(3.0, 2.0, 1.0);
    let mut scene = Scene::default();
    place(&mut scene, "wall", Shape::Rectangle, floor_at(DVec3::ZERO, 50.0), lamp(emission));
    let ray =
        Place::Ray { position: DVec3::new(0.0, 1000.0, 0.0), direction: DVec3::new(0.01, -1.0, 0.02).normalize() };
    known("ray to a far wall", "radiance of a wall a kilometre away", scene, ray, emission)
}

fn lit_by(lamp: Lamp) -> Scene {
    Scene { lights: vec![Light { name: "lamp".to_owned(), lamp, group: None }], ..Scene::default() }
}

/// The lecture's lamp of 800 lm: 63.66 cd, and 15.92 lx at 2 m; in watts over 683.
pub fn lumen_lamp() -> Known {
    let intensity = DVec3::splat(800.0 / 683.0 / (4.0 * PI));
    let mut scene = lit_by(Lamp::Point(Point { position: DVec3::new(0.0, 1.2, 1.6), intensity }));
    // Something to see, behind the meter.
    place(&mut scene, "ball", Shape::Sphere, sphere_at(DVec3::new(0.0, -3.0, -4.0), 1.0), lambert(DVec3::splat(0.5)));
    let answer = DVec3::splat(15.915_494_309_189_5 / 683.0);
    let about = "800 lm from a point: 15.92 lx at 2 m";
    known("meter at a lumen lamp", about, scene, point(DVec3::ZERO, DVec3::new(0.0, 0.6, 0.8)), answer)
}

/// A beam on a tilted plate: A = A' cos(theta), so the mean irradiance is that of the beam times the cosine.
pub fn tilted_plate() -> Known {
    let (irradiance, theta) = (DVec3::new(3.0, 2.0, 1.0), 70f64.to_radians());
    let to_light = DVec3::new(theta.sin(), theta.cos(), 0.0);
    let mut scene = lit_by(Lamp::Directional(Directional { to_light, irradiance }));
    place(&mut scene, "plate", Shape::Rectangle, floor_at(DVec3::new(5.0, 1.0, 2.0), 1.5), lambert(DVec3::splat(0.5)));
    let about = "flux of a beam on a plate tilted by 70 degrees: E A cos(theta)";
    known("flux of a beam", about, scene, surface(&[0], false, false), irradiance * theta.cos())
}

/// A disc of 40 degrees, infinitely far away and wholly above the horizon.
pub fn wide_sun() -> Known {
    let (irradiance, theta) = (DVec3::new(3.0, 2.0, 1.0), 60f64.to_radians());
    let to_light = DVec3::new(theta.sin(), theta.cos(), 0.0);
    let mut scene = lit_by(Lamp::Sun(Sun { to_light, irradiance, half_angle_rad: 20f64.to_radians() }));
    place(&mut scene, "ball", Shape::Sphere, sphere_at(DVec3::NEG_Y * 3.0, 1.0), lambert(DVec3::splat(0.5)));
    let about = "irradiance of a wide sun: E cos(theta)";
    known("meter under a wide sun", about, scene, point(DVec3::ZERO, DVec3::Y), irradiance * theta.cos())
}

/// Under an endless lamp in an absorbing medium: E = 2 pi L E3(a h), by Simpson's rule for E3(x) = integral of m e^(-x/m) over m in [0, 1].
pub fn meter_in_medium() -> Known {
    let (emission, absorption, height) = (DVec3::new(3.0, 2.0, 1.0), DVec3::new(0.5, 1.0, 2.0), 0.8);
    let mut scene = Scene::default();
    let mut glass = material("dielectric", &[("eta", Value::scalar(1.3))]);
    glass.interior = Some(Medium { absorption });
    place(&mut scene, "ball", Shape::Sphere, sphere_at(DVec3::ZERO, 500.0), glass);
    // What is not above the lamp's edges, 100 m away, is below e^-50.
    let turn = glam::DQuat::from_rotation_x(0.5 * PI);
    let above = DAffine3::from_scale_rotation_translation(DVec3::splat(100.0), turn, DVec3::Y * height);
    place(&mut scene, "lamp", Shape::Rectangle, above, lamp(emission));
    let steps = 20_000;
    let third = |x: f64| {
        let f = |k: i32| {
            let m = f64::from(k) / f64::from(steps);
            if k == 0 { 0.0 } else { m * (-x / m).exp() }
        };
        let inner: f64 = (1..steps).map(|k| f(k) * if k % 2 == 1 { 4.0 } else { 2.0 }).sum();
        (f(0) + inner + f(steps)) / (3.0 * f64::from(steps))
    };
    let answer = 2.0 * PI * emission * (absorption * height).map(third);
    let about = "irradiance under an endless lamp in an absorbing medium: 2 pi L E3(a h)";
    known("meter in a medium", about, scene, point(DVec3::ZERO, DVec3::Y), answer)
}

/// A ball lens of radius 1 before a sphere lamp; the meter stands where the lamp's image is.
const BALL_INDEX: f64 = 1.5;
const LAMP_AT: f64 = 20.0;
const LAMP_RADIUS: f64 = 0.5;
const METER_AT: f64 = -1.62;

/// Irradiance at the focus of a ball lens, by quadrature over the angle of rays traced backwards in one plane.
pub fn ball_lens() -> Known {
    let emission = DVec3::new(30.0, 20.0, 10.0);
    let mut scene = Scene::default();
    let glass = material("dielectric", &[("eta", Value::scalar(BALL_INDEX)), ("roughness", Value::scalar(0.0))]);
    place(&mut scene, "ball", Shape::Sphere, sphere_at(DVec3::ZERO, 1.0), glass);
    place(&mut scene, "lamp", Shape::Sphere, sphere_at(DVec3::Z * LAMP_AT, LAMP_RADIUS), lamp(emission));
    let steps = 400_000;
    let sum: f64 = (0..steps)
        .map(|k| {
            let theta = 0.5 * PI * (f64::from(k) + 0.5) / f64::from(steps);
            seen_through_ball(theta) * theta.sin() * theta.cos()
        })
        .sum();
    let factor = 2.0 * PI * sum * 0.5 * PI / f64::from(steps);
    let about = "irradiance at the focus of a ball lens: quadrature over rays of one plane, all internal reflections";
    known("focus of a ball lens", about, scene, point(DVec3::Z * METER_AT, DVec3::Z), emission * factor)
}

/// Share of the lamp's radiance that arrives at the meter under the angle `theta` to the axis.
fn seen_through_ball(theta: f64) -> f64 {
    let direction = glam::DVec2::new(theta.sin(), theta.cos());
    let from = glam::DVec2::new(0.0, METER_AT);
    let sees_lamp = |origin: glam::DVec2, d: glam::DVec2| {
        let to_lamp = glam::DVec2::new(0.0, LAMP_AT) - origin;
        to_lamp.dot(d) > 0.0 && to_lamp.perp_dot(d).abs() < LAMP_RADIUS
    };
    let along = -from.dot(direction);
    let offset2 = from.length_squared() - along * along;
    if offset2 >= 1.0 {
        return f64::from(u8::from(sees_lamp(from, direction)));
    }
    // Into the ball: the angle of refraction is the same at every further meeting, so is the reflectance.
    let entry = from + (along - (1.0 - offset2).sqrt()) * direction;
    let cos_out = (1.0 - offset2).sqrt();
    let cos_in = (1.0 - offset2 / (BALL_INDEX * BALL_INDEX)).sqrt();
    let (s, p) = (
        (cos_out - BALL_INDEX * cos_in) / (cos_out + BALL_INDEX * cos_in),
        (BALL_INDEX * cos_out - cos_in) / (BALL_INDEX * cos_out + cos_in),
    );
    let reflectance = 0.5 * (s * s + p * p);
    let mut at = entry;
    let mut inside = direction / BALL_INDEX + (cos_out / BALL_INDEX - cos_in) * entry;
    let (mut share, mut total) = ((1.0 - reflectance) * (1.0 - reflectance), 0.0);
    for _ in 0..12 {
        // Normalised each time: rounding would grow sixfold with every meeting.
        at = (at + 2.0 * cos_in * inside).normalize();
        let leaving = BALL_INDEX * inside + (cos_out - BALL_INDEX * cos_in) * at;
        if sees_lamp(at, leaving) {
            total += share;
        }
        share *= reflectance;
        inside = (inside - 2.0 * inside.dot(at) * at).normalize();
    }
    total
}

/// Radiance along the axis of a ball lens: what one face does not reflect, with all reflections within, 2n/(n^2 + 1).
pub fn through_ball() -> Known {
    let Known { scene, .. } = ball_lens();
    let emission = DVec3::new(30.0, 20.0, 10.0);
    let ray = Place::Ray { position: DVec3::Z * -3.0, direction: DVec3::Z };
    let answer = emission * (2.0 * BALL_INDEX / (BALL_INDEX * BALL_INDEX + 1.0));
    known(
        "ray through a ball lens",
        "a lens gives no more radiance than its source has: 2n/(n^2 + 1)",
        scene,
        ray,
        answer,
    )
}

/// All of them.
pub fn all() -> Vec<Known> {
    vec![
        under_the_sky(),
        grazing_lamp(),
        polygon_lamp(),
        disc_lamp(),
        flux_through_disc(),
        lamp_in_a_ball(),
        unequal_triangles(),
        leaving_floor(),
        far_wall(),
        lumen_lamp(),
        tilted_plate(),
        wide_sun(),
        meter_in_medium(),
        ball_lens(),
        through_ball(),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lens_raises_irradiance_and_not_radiance() {
        let bare = PI * (LAMP_RADIUS / (LAMP_AT - METER_AT)).powi(2);
        let with = ball_lens().radiance.x / 30.0;
        // The lens fills a cone of sin = 1/1.62; aberration takes its part.
        assert!(with > 10.0 * bare && with < PI / (METER_AT * METER_AT), "{with} {bare}");
        assert!(through_ball().radiance.x < 30.0);
        // On the axis the quadrature's integrand is the closed form.
        assert!((seen_through_ball(1e-9) - 12.0 / 13.0).abs() < 1e-9);
    }
}
