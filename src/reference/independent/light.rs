//! Light list and light sampling of the independent mode: brute and plain, to share nothing with src/light.
//!
//! Emitters are chosen in proportion to area times mean luminance, the sky with a fixed share; points on emitters are uniform
//! in area (density d^2/(A cos) per solid angle); the sky by a cumulative table over its texels, uniform in solid angle inside
//! one. A sphere seen from outside shows only its near side: points on the far side bring nothing, and have no density.

use std::collections::{BTreeSet, HashMap};
use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};

use super::{Independent, rgb, value};
use crate::light::Lamp;
use crate::prepare::records::NONE;
use crate::reference::path::{LightSample, Random, luminance};
use crate::reference::tree::{Hit, Ray, Shape};
use crate::sampler;
use crate::scene::{Image, Pixels, SkyRadiance};

/// Share of light samples that go to the sky when there are other lights too.
const SKY_SHARE: f64 = 0.5;
/// Share of the rest that goes to lamps, each alike, when there are emitting surfaces too.
const LAMP_SHARE: f64 = 0.5;

#[derive(Clone, Debug, Default)]
pub struct Lights {
    pub sky: Sky,
    sky_share: f64,
    /// Of all samples.
    lamp_share: f64,
    /// Each with its light group.
    lamps: Vec<(Lamp, u32)>,
    pub sky_group: u32,
    /// Names of the light groups, as they rank in the alphabet.
    groups: BTreeSet<String>,
    /// Primitive numbers, and the cumulative probability up to and including each.
    emitters: Vec<(u32, f64)>,
    /// By primitive: probability among the emitters; empty when there are none.
    probability: HashMap<u32, f64>,
}

impl Lights {
    pub fn of(world: &Independent) -> Self {
        let instances = world.scene.instances.iter().enumerate();
        let shining = instances.filter(|(_, i)| world.scene.materials[i.material].emits());
        let weights: Vec<(u32, f64)> = shining
            .flat_map(|(number, _)| world.primitives.of_instance(number))
            .map(|p| (p, emitted(world, p)))
            .filter(|w| w.1 > 0.0)
            .collect();
        let total: f64 = weights.iter().map(|w| w.1).sum();
        let mut lights = Self { sky: Sky::of(world), groups: groups(world), ..Self::default() };
        let lamps = world.scene.lights.iter().map(|l| (l.lamp, lights.group(&l.group))).collect::<Vec<_>>();
        lights.sky_group = lights.group(&world.scene.sky_group);
        if total > 0.0 {
            let mut sum = 0.0;
            for &(primitive, weight) in &weights {
                sum += weight;
                lights.emitters.push((primitive, sum / total));
            }
            lights.probability = weights.iter().map(|w| (w.0, w.1 / total)).collect();
        }
        lights.sky_share = match (lights.sky.has_light(), total > 0.0 || !lamps.is_empty()) {
            (true, true) => SKY_SHARE,
            (true, false) => 1.0,
            _ => 0.0,
        };
        let share = match (lamps.is_empty(), total > 0.0) {
            (true, _) => 0.0,
            (false, true) => LAMP_SHARE,
            (false, false) => 1.0,
        };
        (lights.lamp_share, lights.lamps) = (share * (1.0 - lights.sky_share), lamps);
        lights
    }

    /// How many names come before this one.
    fn group(&self, name: &Option<String>) -> u32 {
        let name = name.clone().unwrap_or_else(|| "default".to_owned());
        self.groups.range::<String, _>(..&name).count() as u32
    }

    /// By material.
    pub fn material_groups(&self, world: &Independent) -> Vec<u32> {
        world.scene.materials.iter().map(|m| self.group(&m.group)).collect()
    }

    pub fn sky_density(&self, direction: DVec3) -> f64 {
        self.sky_share * self.sky.density(direction)
    }

    /// Suns seen in this direction: radiance, density and group.
    pub fn suns(&self, direction: DVec3, visit: &mut dyn FnMut(DVec3, f64, u32)) {
        for (lamp, group) in &self.lamps {
            let (radiance, density) = lamp.model().arriving(direction);
            if radiance != DVec3::ZERO {
                visit(radiance, density * self.lamp_share / self.lamps.len() as f64, *group);
            }
        }
    }

    pub fn emitter_density(&self, world: &Independent, ray: &Ray, hit: &Hit) -> f64 {
        let probability = self.probability.get(&hit.primitive).copied().unwrap_or(0.0);
        let point = world.point(hit.primitive, hit.barycentric, ray.at(hit.t));
        let cosine = ray.direction.dot(point.geometric_normal);
        let shape = &world.primitives.get(hit.primitive).shape;
        if cosine == 0.0 || is_far_side(shape, ray.origin, cosine) {
            return 0.0;
        }
        (1.0 - self.sky_share - self.lamp_share) * probability * hit.t * hit.t / (area(shape) * cosine.abs())
    }

    pub fn sample<R: Random>(&self, world: &Independent, from: DVec3, random: &R, vertex: u32) -> Option<LightSample> {
        let u = [random.unit(vertex, sampler::LIGHT_U), random.unit(vertex, sampler::LIGHT_V)];
        let which = random.unit(vertex, sampler::LIGHT_INDEX);
        if which < self.sky_share {
            let direction = self.sky.sample(random.unit(vertex, sampler::SKY_INDEX), u)?;
            return Some(LightSample {
                direction,
                distance: f64::INFINITY,
                radiance: self.sky.radiance(direction),
                density: self.sky_density(direction),
                is_delta: false,
                primitive: NONE,
                group: self.sky_group,
            });
        }
        if which < self.sky_share + self.lamp_share {
            let count = self.lamps.len();
            let (lamp, group) =
                self.lamps[((random.unit(vertex, sampler::LIGHT_FRACTION) * count as f64) as usize).min(count - 1)];
            let c = lamp.model().connect(from, u);
            return Some(LightSample {
                direction: c.wi,
                distance: c.distance,
                radiance: c.radiance,
                density: c.pdf * self.lamp_share / count as f64,
                is_delta: lamp.kind().is_delta(),
                primitive: NONE,
                group,
            });
        }
        let choice = random.unit(vertex, sampler::LIGHT_FRACTION);
        let last = self.emitters.len().checked_sub(1)?;
        let (primitive, _) = self.emitters[self.emitters.partition_point(|e| e.1 <= choice).min(last)];
        let shape = &world.primitives.get(primitive).shape;
        let (barycentric, position) = on_shape(shape, u);
        let point = world.point(primitive, barycentric, position);
        let to_light = point.position - from;
        let distance = to_light.length();
        let direction = to_light / distance;
        let cosine = direction.dot(point.geometric_normal);
        if distance == 0.0 || cosine == 0.0 || is_far_side(shape, from, cosine) {
            return None;
        }
        let material = world.material(primitive);
        // A surface that is there with probability alpha shines with alpha times its radiance.
        let radiance = world.emission(material, &point, direction) * world.alpha(material, &point);
        let hit = Hit { t: distance, primitive, barycentric, is_far: false };
        let ray = Ray { origin: from, direction, leaves: primitive, ignores: primitive, cone: DVec2::ZERO };
        let density = self.emitter_density(world, &ray, &hit);
        let group = self.group(&material.group);
        Some(LightSample { direction, distance, radiance, density, is_delta: false, primitive, group })
    }
}

/// Every name that a light has.
fn groups(world: &Independent) -> BTreeSet<String> {
    let scene = world.scene;
    let of_shape = |i: &crate::scene::Instance| {
        let material = &scene.materials[i.material];
        material.emits().then(|| material.group.clone())
    };
    let lamps = scene.lights.iter().map(|l| l.group.clone());
    let sky = scene.sky.as_ref().map(|_| scene.sky_group.clone());
    let all = scene.instances.iter().filter_map(of_shape).chain(lamps).chain(sky);
    all.map(|group| group.unwrap_or_else(|| "default".to_owned())).collect()
}

/// From outside, a sphere hides the points that face away. `OUTSIDE` keeps points of the sphere itself, rounded, inside.
fn is_far_side(shape: &Shape, from: DVec3, cosine: f64) -> bool {
    const OUTSIDE: f64 = 1.0 + 1e-9;
    matches!(shape, Shape::Sphere { center, radius } if cosine > 0.0 && from.distance(*center) > *radius * OUTSIDE)
}

pub(super) fn area(shape: &Shape) -> f64 {
    match shape {
        Shape::Triangle(v) => 0.5 * (v[1] - v[0]).cross(v[2] - v[0]).length(),
        Shape::Sphere { radius, .. } => 4.0 * PI * radius * radius,
        Shape::Disc { radius, .. } => PI * radius * radius,
    }
}

/// Uniform point: barycentric weights for a triangle (Turk 1990), position for a sphere (Archimedes) or disc (polar).
pub(super) fn on_shape(shape: &Shape, u: [f64; 2]) -> ([f64; 2], DVec3) {
    match shape {
        Shape::Triangle(v) => {
            let root = u[0].sqrt();
            let b = [root * (1.0 - u[1]), root * u[1]];
            (b, (1.0 - root) * v[0] + b[0] * v[1] + b[1] * v[2])
        }
        Shape::Sphere { center, radius } => ([0.0; 2], center + radius * on_sphere(1.0 - 2.0 * u[0], TAU * u[1])),
        Shape::Disc { center, normal, radius } => {
            let (x, y) = normal.any_orthonormal_pair();
            let (sin, cos) = (TAU * u[1]).sin_cos();
            ([0.0; 2], center + radius * u[0].sqrt() * (cos * x + sin * y))
        }
    }
}

fn on_sphere(y: f64, longitude: f64) -> DVec3 {
    let r = (1.0 - y * y).max(0.0).sqrt();
    DVec3::new(r * longitude.sin(), y, -r * longitude.cos())
}

/// Area times mean luminance over 64 points; 0 for what does not emit.
fn emitted(world: &Independent, primitive: u32) -> f64 {
    let material = world.material(primitive);
    let Some(emission) = &material.emission else { return 0.0 };
    let shape = &world.primitives.get(primitive).shape;
    let sides = if material.emission_two_sided { 2.0 } else { 1.0 };
    let mean: f64 = (0..64)
        .map(|i| {
            let u = [(f64::from(i % 8) + 0.5) / 8.0, (f64::from(i / 8) + 0.5) / 8.0];
            let (b, position) = on_shape(shape, u);
            luminance(rgb(world.evaluate(emission, &world.point(primitive, b, position)))) / 64.0
        })
        .sum();
    // A texture may be dark at all 64 points and bright between them: no emitter is left without a chance.
    let floor = 1e-3;
    sides * area(shape) * if matches!(emission, crate::scene::Value::Constant(_)) { mean } else { mean.max(floor) }
}

/// Light from infinity, with a cumulative table for images.
#[derive(Clone, Debug, Default)]
pub struct Sky {
    /// Uniform radiance, or the factor on the texels.
    scale: DVec3,
    rotation_rad: f64,
    image: Option<Image>,
    /// Cumulative probability up to and including each texel, row by row.
    cumulative: Vec<f64>,
}

impl Sky {
    fn of(world: &Independent) -> Self {
        let Some(sky) = &world.scene.sky else { return Self::default() };
        match sky.radiance {
            SkyRadiance::Uniform(radiance) => Self { scale: radiance * sky.scale, ..Self::default() },
            SkyRadiance::Image(image) => Self {
                scale: DVec3::splat(sky.scale),
                rotation_rad: sky.rotation_rad,
                image: Some(world.scene.images[image].clone()),
                cumulative: Vec::new(),
            }
            .with_table(),
        }
    }

    fn with_table(mut self) -> Self {
        let Some(image) = &self.image else { return self };
        let (width, height) = (image.width, image.height);
        let mut sum = 0.0;
        let mut table = Vec::with_capacity(width as usize * height as usize);
        for j in 0..height {
            for i in 0..width {
                // Mean of the bilinear interpolant over the texel: 6/8 of itself and 1/8 of each neighbour, per axis. It is
                // positive wherever the look-up can be.
                let mut mean = 0.0;
                for (dj, wj) in [(-1.0, 0.125), (0.0, 0.75), (1.0, 0.125)] {
                    for (di, wi) in [(-1.0, 0.125), (0.0, 0.75), (1.0, 0.125)] {
                        let t = sky_texel(image, f64::from(i) + di, f64::from(j) + dj);
                        mean += wi * wj * luminance(rgb(t));
                    }
                }
                sum += mean * cell_solid_angle(width, height, j);
                table.push(sum);
            }
        }
        table.iter_mut().for_each(|c| *c /= sum);
        self.cumulative = if sum > 0.0 { table } else { Vec::new() };
        self
    }

    fn has_light(&self) -> bool {
        self.scale != DVec3::ZERO && (self.image.is_none() || !self.cumulative.is_empty())
    }

    /// The direction as the image sees it: the sky is turned about +y, so the direction is turned back.
    fn turned(&self, d: DVec3, angle: f64) -> DVec3 {
        let (s, c) = angle.sin_cos();
        DVec3::new(c * d.x + s * d.z, d.y, -s * d.x + c * d.z)
    }

    /// Image position in texels.
    fn position(&self, image: &Image, direction: DVec3) -> (f64, f64) {
        let d = self.turned(direction, -self.rotation_rad);
        let u = 0.5 + d.x.atan2(-d.z) / TAU;
        let v = d.y.clamp(-1.0, 1.0).acos() / PI;
        (u * f64::from(image.width), v * f64::from(image.height))
    }

    pub fn radiance(&self, direction: DVec3) -> DVec3 {
        let Some(image) = &self.image else { return self.scale };
        let (x, y) = self.position(image, direction);
        self.scale * rgb(value::bilinear(x, y, |i, j| sky_texel(image, i, j)))
    }

    fn density(&self, direction: DVec3) -> f64 {
        let Some(image) = &self.image else { return 0.25 / PI };
        let (x, y) = self.position(image, direction);
        let (i, j) = ((x as u32).min(image.width - 1), (y as u32).min(image.height - 1));
        let at = j as usize * image.width as usize + i as usize;
        let before = if at > 0 { self.cumulative[at - 1] } else { 0.0 };
        (self.cumulative[at] - before) / cell_solid_angle(image.width, image.height, j)
    }

    fn sample(&self, choice: f64, u: [f64; 2]) -> Option<DVec3> {
        let Some(image) = &self.image else { return Some(on_sphere(1.0 - 2.0 * u[0], TAU * u[1])) };
        let at = self.cumulative.partition_point(|c| *c <= choice).min(self.cumulative.len().checked_sub(1)?);
        let (i, j) = ((at as u32 % image.width), at as u32 / image.width);
        let top = (PI * f64::from(j) / f64::from(image.height)).cos();
        let bottom = (PI * f64::from(j + 1) / f64::from(image.height)).cos();
        let longitude = TAU * ((f64::from(i) + u[1]) / f64::from(image.width) - 0.5);
        Some(self.turned(on_sphere(top + (bottom - top) * u[0], longitude), self.rotation_rad))
    }
}

fn cell_solid_angle(width: u32, height: u32, row: u32) -> f64 {
    let edge = |j: u32| (PI * f64::from(j) / f64::from(height)).cos();
    TAU / f64::from(width) * (edge(row) - edge(row + 1))
}

/// Texel of a lat-long image: wraps in longitude, stops at the poles.
fn sky_texel(image: &Image, i: f64, j: f64) -> [f64; 4] {
    let x = i.rem_euclid(f64::from(image.width)) as usize;
    let y = j.clamp(0.0, f64::from(image.height) - 1.0) as usize;
    let at = y * image.width as usize + x;
    match &image.pixels {
        Pixels::RgbF32(p) => [f64::from(p[3 * at]), f64::from(p[3 * at + 1]), f64::from(p[3 * at + 2]), 1.0],
        Pixels::Rgba8(p) => [0, 1, 2, 3].map(|k| f64::from(p[4 * at + k]) / 255.0),
        Pixels::Rgba16(p) => [0, 1, 2, 3].map(|k| f64::from(p[4 * at + k]) / 65535.0),
    }
}
