//! The replay world: `Prepared`'s own f32 records, decoded to f64, and the device's own integer stream.
//!
//! Every table is read as the kernel reads it (same alias words, same thresholds, same sampling maps), but intersection, path
//! loop and arithmetic are the oracle's. So `path` of a (pixel, sample) follows the device's path until rounding parts them.
//! This is also `--device cpu`. Faults in `Prepared` are invisible here: `independent` is for those.

mod pattern;
mod placed;
mod stream;

use std::sync::Arc;

use glam::{DVec2, DVec3};

use super::nested::{Inside, Medium};
use super::path::{LightSample, Random, Sample, VertexTrace, World, trace};
use super::surface::Surface;
use super::tree::{Hit, Ray, Shape, Tree};
use crate::bsdf::mixture::{self, Mixture};
use crate::bsdf::{InputKind, MODELS, Params};
use crate::camera::{self, Start, View};
use crate::film::filter;
use crate::integrator::{Estimator, SamplerKind, Settings};
use crate::light::{self, Place, Reach, alias};
use crate::prepare::Prepared;
use crate::prepare::media::is_index;
use crate::prepare::pattern::Role;
use crate::prepare::records::*;
use crate::sampler::{self, Purpose};
use pattern::Point;
use placed::ToWorld;
pub use stream::Stream;

/// `Prepared` with the oracle's tree over it.
pub struct Replay {
    prepared: Arc<Prepared>,
    sampler: SamplerKind,
    tree: Tree,
    /// By primitive number: kind (HIT_*) and row of its table. A face of a placed mesh stands here once.
    rows: Vec<(u32, u32)>,
    placed: placed::Numbers,
    has_alpha: bool,
    /// By medium: rank of its material's priority.
    ranks: Vec<u32>,
}

/// The record of a primitive.
enum Part<'a> {
    Triangle(&'a TriangleRecord),
    Sphere(&'a SphereRecord),
    Disc(&'a DiscRecord),
}

/// One path of the replay: what it brought and where it went.
#[derive(Clone, Debug, PartialEq)]
pub struct PathTrace {
    pub sample: Sample,
    pub vertices: Vec<VertexTrace>,
}

/// Replays one sample of one pixel.
pub fn path(prepared: &Arc<Prepared>, settings: &Settings, pixel: [u32; 2], sample: u64) -> PathTrace {
    Replay::new(prepared.clone(), settings).path(settings, pixel, sample)
}

fn vec(v: [f32; 3]) -> DVec3 {
    DVec3::from(v.map(f64::from))
}

impl Replay {
    pub fn new(prepared: Arc<Prepared>, settings: &Settings) -> Self {
        let p = &prepared;
        let mut shapes = Vec::with_capacity(p.triangles.len() + p.spheres.len() + p.discs.len());
        let mut rows = Vec::new();
        // Dropped primitives leave gaps in the numbers.
        let mut number = |primitive: u32, kind: u32, row: usize| {
            if rows.len() <= primitive as usize {
                rows.resize(primitive as usize + 1, (NONE, NONE));
            }
            rows[primitive as usize] = (kind, row as u32);
        };
        for (row, t) in p.triangles.iter().enumerate() {
            number(t.face, HIT_TRIANGLE, row);
        }
        let flat = p.flat_triangles().iter();
        shapes.extend(flat.map(|t| (t.face, Shape::Triangle([t.v0, t.v1, t.v2].map(vec)))));
        for (row, s) in p.spheres.iter().enumerate() {
            number(s.primitive, HIT_SPHERE, row);
            shapes.push((s.primitive, Shape::Sphere { center: vec(s.center), radius: s.radius.into() }));
        }
        for (row, d) in p.discs.iter().enumerate() {
            let (center, normal) = (vec(d.center), vec(d.normal).normalize());
            number(d.primitive, HIT_DISC, row);
            shapes.push((d.primitive, Shape::Disc { center, normal, radius: d.radius.into() }));
        }
        let has_alpha = p.materials.iter().any(|m| m.flags & (MATERIAL_MASK | MATERIAL_BLEND) != 0);
        let (placed, trees) = placed::trees(p);
        let tree = Tree::build(shapes).with_placed(trees);
        let mut ranks = vec![0; p.media.len()];
        for material in p.materials.iter().filter(|m| m.interior != NONE) {
            ranks[material.interior as usize] = material.priority;
        }
        Self { prepared, sampler: settings.sampler, tree, rows, placed, has_alpha, ranks }
    }

    pub fn path(&self, settings: &Settings, pixel: [u32; 2], sample: u64) -> PathTrace {
        let mut vertices = Vec::new();
        let sample = trace(self, settings, pixel, sample, |v| vertices.push(v));
        PathTrace { sample, vertices }
    }

    /// The placement of a number, if it is one's.
    fn instance(&self, primitive: u32) -> Option<&InstanceRecord> {
        self.placed.find(primitive).map(|(row, _)| &self.prepared.instances[row as usize])
    }

    fn part(&self, primitive: u32) -> Part<'_> {
        let number = self.placed.find(primitive).map_or(primitive, |(_, face)| face);
        let (kind, row) = self.rows[number as usize];
        match kind {
            HIT_TRIANGLE => Part::Triangle(&self.prepared.triangles[row as usize]),
            HIT_SPHERE => Part::Sphere(&self.prepared.spheres[row as usize]),
            _ => Part::Disc(&self.prepared.discs[row as usize]),
        }
    }

    /// Row of `materials`, which is the scene's number.
    fn material_row(&self, primitive: u32) -> u32 {
        match self.part(primitive) {
            Part::Triangle(t) => self.instance(primitive).map_or(t.material, |placed| placed.material),
            Part::Sphere(s) => s.material,
            Part::Disc(d) => d.material,
        }
    }

    fn material(&self, primitive: u32) -> &MaterialRecord {
        &self.prepared.materials[self.material_row(primitive) as usize]
    }

    /// Row of `lights`, or NONE.
    fn light(&self, primitive: u32) -> u32 {
        match self.part(primitive) {
            Part::Triangle(t) => t.light,
            Part::Sphere(s) => s.light,
            Part::Disc(d) => d.light,
        }
    }

    /// What patterns read at barycentric weights of a face.
    fn face_point(&self, face: u32, b: [f64; 2]) -> Point {
        let p = &self.prepared;
        let corners = p.faces[face as usize].vertices.map(|v| v as usize);
        let weights = [1.0 - b[0] - b[1], b[0], b[1]];
        let mut point = Point::default();
        if !p.uvs.is_empty() {
            let uv = |read: fn(&UvRecord) -> [f32; 2]| -> DVec2 {
                (0..3).map(|k| weights[k] * DVec2::from(read(&p.uvs[corners[k]]).map(f64::from))).sum()
            };
            point.uvs = [uv(|r| r.uv0), uv(|r| r.uv1)];
        }
        if !p.colors.is_empty() {
            let channel = |c: usize| (0..3).map(|k| weights[k] * f64::from(p.colors[corners[k]].rgba[c])).sum();
            point.color = [0, 1, 2, 3].map(channel);
        }
        point
    }

    /// What patterns read where the sphere's outward normal is `normal`.
    fn sphere_point(&self, sphere: &SphereRecord, normal: DVec3) -> Point {
        let [x, y, z, w] = sphere.rotation.map(f64::from);
        let local = f64::from(sphere.handedness) * (glam::DQuat::from_xyzw(x, y, z, w).normalize() * normal);
        let u = 0.5 + local.x.atan2(-local.z) / std::f64::consts::TAU;
        let v = local.y.clamp(-1.0, 1.0).acos() / std::f64::consts::PI;
        Point { uvs: [DVec2::new(u, v); 2], ..Point::default() }
    }

    /// What patterns read at a point of a disc.
    fn disc_point(&self, disc: &DiscRecord, position: DVec3) -> Point {
        let (normal, tangent) = (vec(disc.normal), vec(disc.tangent));
        let local = (position - vec(disc.center)) / f64::from(disc.radius);
        let (x, y) = (local.dot(tangent), f64::from(disc.handedness) * local.dot(normal.cross(tangent)));
        Point { uvs: [DVec2::new(0.5 * (x + 1.0), 0.5 * (1.0 - y)); 2], ..Point::default() }
    }

    fn point(&self, ray: &Ray, hit: &Hit) -> Point {
        match self.part(hit.primitive) {
            Part::Triangle(t) => self.face_point(t.face, hit.barycentric),
            Part::Sphere(sphere) => self.sphere_point(sphere, (ray.at(hit.t) - vec(sphere.center)).normalize()),
            Part::Disc(disc) => self.disc_point(disc, ray.at(hit.t)),
        }
    }

    /// Areas of the cone's footprint in the units of both texture coordinates (texture/mip.rs).
    fn areas(&self, ray: &Ray, hit: &Hit, normal: DVec3) -> [f64; 2] {
        let p = &self.prepared;
        let Part::Triangle(t) = self.part(hit.primitive) else { return [0.0; 2] };
        if p.uvs.is_empty() || ray.cone == DVec2::ZERO {
            return [0.0; 2];
        }
        let flat = || [t.v0, t.v1, t.v2].map(vec);
        let v = self.instance(hit.primitive).map_or_else(flat, |placed| ToWorld::new(placed).corners(t));
        let width = ray.cone.x + ray.cone.y * hit.t;
        let covered = width * width / ray.direction.dot(normal).abs().max(1e-6);
        let part = covered / (v[1] - v[0]).cross(v[2] - v[0]).length();
        let corners = p.faces[t.face as usize].vertices.map(|v| &p.uvs[v as usize]);
        let area = |uv: [DVec2; 3]| part * (uv[1] - uv[0]).perp_dot(uv[2] - uv[0]).abs();
        [
            area(corners.map(|r| DVec2::from(r.uv0.map(f64::from)))),
            area(corners.map(|r| DVec2::from(r.uv1.map(f64::from)))),
        ]
    }

    /// Radiance of the material, shown to a direction (towards the surface) that sees its front or back.
    fn emission(&self, material: &MaterialRecord, point: &Point, is_front: bool) -> DVec3 {
        let shines =
            material.flags & MATERIAL_EMITS != 0 && (is_front || material.flags & MATERIAL_EMITS_TWO_SIDED != 0);
        if shines {
            rgb(self.evaluate(material.emission_pattern, material.emission_data, point, 0))
        } else {
            DVec3::ZERO
        }
    }

    /// Light group of a row of `lights`.
    fn group(&self, light: u32) -> u32 {
        let of = |l: &LightRecord| match self.prepared.materials.get(l.material as usize) {
            Some(material) => material.group,
            None => l.shape,
        };
        self.prepared.lights.get(light as usize).map_or(0, of)
    }

    fn pmf(&self, light: u32) -> f64 {
        self.prepared.lights.get(light as usize).map_or(0.0, |l| l.pmf.into())
    }
}

fn rgb(v: [f64; 4]) -> DVec3 {
    DVec3::new(v[0], v[1], v[2])
}

impl World for Replay {
    type Stream = Stream;

    fn size(&self) -> [u32; 2] {
        [self.prepared.width, self.prepared.height]
    }

    fn stream(&self, seed: u32, pixel: [u32; 2], sample: u64) -> Stream {
        Stream::new(self.sampler, seed, pixel[1] * self.prepared.width + pixel[0], sample as u32)
    }

    fn filter_offset(&self, u: f64) -> f64 {
        filter::offset_from_rows(&self.prepared.filter, u)
    }

    fn camera_start(&self, film: DVec2, random: &Stream) -> Start {
        let p = &self.prepared;
        let view = View { camera: &p.camera, elements: &p.sensor_elements, alias: &p.sensor_alias };
        camera::start(&view, film, &|purpose| random.bits(0, purpose))
    }

    fn camera_cone(&self) -> DVec2 {
        DVec2::from(self.prepared.camera.cone.map(f64::from))
    }

    fn camera_inside(&self) -> Inside {
        let camera = &self.prepared.camera;
        if !self.prepared.nests {
            return Inside::only(camera.medium);
        }
        let mut inside = Inside::default();
        for entry in camera.media.into_iter().filter(|e| *e != 0) {
            inside.enter((entry & 0xffff) - 1);
        }
        inside
    }

    fn nests(&self) -> bool {
        self.prepared.nests
    }

    fn boundary_medium(&self, primitive: u32) -> Option<u32> {
        let material = self.material(primitive);
        let bounds = material.flags & MATERIAL_TRANSMITS != 0 && material.flags & MATERIAL_THIN == 0;
        (bounds && material.interior != NONE).then_some(material.interior)
    }

    fn tree(&self) -> &Tree {
        &self.tree
    }

    fn has_alpha(&self) -> bool {
        self.has_alpha
    }

    fn presence(&self, ray: &Ray, hit: &Hit) -> f64 {
        let material = self.material(hit.primitive);
        if material.flags & (MATERIAL_MASK | MATERIAL_BLEND) == 0 {
            return 1.0;
        }
        self.alpha(material, &self.point(ray, hit))
    }

    fn surface(&self, ray: &Ray, hit: &Hit, outside: f64) -> Surface {
        let p = &self.prepared;
        let material = self.material(hit.primitive);
        let point = self.point(ray, hit);
        let follows_tangent = material.flags & MATERIAL_TANGENT != 0;
        let (position, geometric_normal, normal, tangent) = match self.part(hit.primitive) {
            Part::Triangle(t) => {
                let placed = self.instance(hit.primitive).map(ToWorld::new);
                let placed = placed.as_ref();
                let v = placed.map_or_else(|| [t.v0, t.v1, t.v2].map(vec), |m| m.corners(t));
                let mirror = placed.map_or(1.0, ToWorld::handedness);
                let ng = mirror * (v[1] - v[0]).cross(v[2] - v[0]).normalize_or_zero();
                let weights = [1.0 - hit.barycentric[0] - hit.barycentric[1], hit.barycentric[0], hit.barycentric[1]];
                let face = &p.faces[t.face as usize];
                let corners = face.vertices.map(|v| v as usize);
                let mean =
                    |read: &dyn Fn(usize) -> DVec3| -> DVec3 { (0..3).map(|k| weights[k] * read(corners[k])).sum() };
                let normal_of = |i: usize| {
                    let n = vec(p.normals[i].normal);
                    placed.map_or(n, |m| m.normal(n))
                };
                let tangent_of = |i: usize| {
                    let t = vec(p.tangents[i].tangent);
                    placed.map_or(t, |m| m.tangent(t))
                };
                // 1e-6: opposite vertex normals may cancel down to rounding.
                let is_smooth = face.flags & FACE_SMOOTH != 0 && !p.normals.is_empty();
                let smooth = if is_smooth { mean(&normal_of) } else { DVec3::ZERO };
                let normal = if smooth.length() > 1e-6 { smooth.normalize() } else { ng };
                let has_tangent = follows_tangent && face.flags & FACE_TANGENTS != 0;
                let tangent = has_tangent.then(|| {
                    let handedness = p.normals.get(corners[0]).map_or(1.0, |n| f64::from(n.handedness));
                    (mean(&tangent_of), mirror * handedness)
                });
                (weights[0] * v[0] + weights[1] * v[1] + weights[2] * v[2], ng, normal, tangent)
            }
            Part::Disc(disc) => {
                let ng = vec(disc.normal).normalize();
                let tangent = follows_tangent.then(|| (vec(disc.tangent), f64::from(disc.handedness)));
                (ray.at(hit.t), ng, ng, tangent)
            }
            Part::Sphere(sphere) => {
                let position = ray.at(hit.t);
                let ng = (position - vec(sphere.center)).normalize();
                let [x, y, z, w] = sphere.rotation.map(f64::from);
                let axis = glam::DQuat::from_xyzw(x, y, z, w).normalize().conjugate() * DVec3::Y;
                // Towards growing u, which is to the left seen from outside; the bitangent points to the pole v = 0.
                let tangent = follows_tangent.then(|| (ng.cross(axis), -f64::from(sphere.handedness)));
                (position, ng, ng, tangent)
            }
        };
        // Emission and presence are looked up at a point.
        let shaded = Point { areas: self.areas(ray, hit, geometric_normal), ..point };
        let surfaces = p.structures[material.pattern as usize].lobes();
        let is_mixture = matches!(p.structures[material.pattern as usize].role, Role::Mix(_));
        let mut output = 0;
        let mut next = || {
            output += 1;
            self.evaluate(material.pattern, material.data, &shaded, output - 1)
        };
        let mut params_of = |model: usize| {
            let mut inputs = [DVec3::ZERO; 32];
            for (slot, input) in inputs.iter_mut().zip(MODELS[model].inputs) {
                let v = next();
                *slot = if input.kind == InputKind::Scalar { DVec3::splat(v[0]) } else { rgb(v) };
                if is_index(input.name) {
                    *slot /= outside;
                }
            }
            let params = Params::from_inputs(model, &inputs[..MODELS[model].inputs.len()]);
            (params, if is_mixture { next()[0] } else { 1.0 })
        };
        let params = if is_mixture {
            let part = |lobe: (usize, usize)| {
                let (params, share) = params_of(lobe.0);
                (lobe, mixture::Part { share, params, is_one_sided: !MODELS[lobe.0].transmits })
            };
            // The pattern fills the parts in the author's order; one is picked in the order of the kernel's slots.
            let mut parts: Vec<_> = surfaces.into_iter().map(part).collect();
            parts.sort_by_key(|p| p.0);
            Mixture::Many(parts.into_iter().map(|p| p.1).collect())
        } else {
            Mixture::One(params_of(material.bsdf as usize).0)
        };
        let normal_map = (material.flags & MATERIAL_NORMAL_MAP != 0).then(|| {
            let n = 2.0 * rgb(self.evaluate(material.normal_pattern, material.normal_data, &shaded, 0)) - 1.0;
            let scale = f64::from(material.normal_scale);
            DVec3::new(scale * n.x, scale * n.y, n.z)
        });
        let transmits = material.flags & MATERIAL_TRANSMITS != 0;
        Surface {
            point: position,
            geometric_normal,
            normal,
            uv: point.uvs[0],
            object: p.object_of(hit.primitive),
            material: self.material_row(hit.primitive),
            tangent,
            normal_map,
            params,
            transmits,
            emission: self.emission(material, &point, ray.direction.dot(geometric_normal) < 0.0),
            group: material.group,
            boundary: (transmits && material.flags & MATERIAL_THIN == 0).then_some(material.interior),
        }
    }

    fn medium(&self, medium: u32) -> Medium {
        let record = &self.prepared.media[medium as usize];
        Medium { absorption: vec(record.absorption), index: record.eta.into(), priority: self.ranks[medium as usize] }
    }

    fn background(&self, direction: DVec3, visit: &mut dyn FnMut(DVec3, f64, u32)) {
        for kind in light::KINDS {
            if let Reach::Infinity(arriving) = kind.reach {
                arriving(&self.prepared, direction, &mut |radiance, row, density| {
                    visit(radiance, self.pmf(row) * density, self.group(row));
                });
            }
        }
    }

    fn emitter_density(&self, ray: &Ray, hit: &Hit) -> f64 {
        let row = self.light(hit.primitive);
        let Some(record) = self.prepared.lights.get(row as usize) else { return 0.0 };
        let Some(Reach::Surface(density)) = light::kind(record).map(|k| k.reach) else { return 0.0 };
        let normal = match self.part(hit.primitive) {
            Part::Triangle(t) => (vec(t.v1) - vec(t.v0)).cross(vec(t.v2) - vec(t.v0)),
            Part::Sphere(s) => ray.at(hit.t) - vec(s.center),
            Part::Disc(d) => vec(d.normal),
        };
        let is_front = ray.direction.dot(normal) < 0.0;
        self.pmf(row) * density(record, ray.origin, ray.direction, hit.t, is_front)
    }

    fn sample_light(&self, point: DVec3, random: &Stream, vertex: u32, _: Estimator) -> Option<LightSample> {
        let p = &self.prepared;
        let word = |purpose| random.bits(vertex, purpose);
        let count = p.lights.len() as u32;
        if count == 0 {
            return None;
        }
        let index =
            alias::choose_record(&p.light_alias, count, word(sampler::LIGHT_INDEX), word(sampler::LIGHT_FRACTION));
        let record = &p.lights[index as usize];
        let u = [random.unit(vertex, sampler::LIGHT_U), random.unit(vertex, sampler::LIGHT_V)];
        let kind = light::kind(record)?;
        let c = (kind.connect)(&Vertex { world: self, random, vertex }, record, point, u);
        let density = self.pmf(index) * c.pdf;
        let sample = LightSample {
            direction: c.wi,
            distance: c.distance,
            radiance: c.radiance,
            density,
            is_delta: kind.is_delta(),
            primitive: c.primitive,
            group: self.group(index),
        };
        (density > 0.0).then_some(sample)
    }
}

/// Where a light is sampled from.
struct Vertex<'a> {
    world: &'a Replay,
    random: &'a Stream,
    vertex: u32,
}

impl light::Surroundings for Vertex<'_> {
    fn prepared(&self) -> &Prepared {
        &self.world.prepared
    }

    fn word(&self, purpose: Purpose) -> u32 {
        self.random.bits(self.vertex, purpose)
    }

    fn emission(&self, material: u32, place: Place, is_front: bool) -> DVec3 {
        let world = self.world;
        let material = &world.prepared.materials[material as usize];
        let point = match place {
            Place::Face(face, b) => world.face_point(face, b),
            Place::Sphere(row, normal) => world.sphere_point(&world.prepared.spheres[row as usize], normal),
            Place::Disc(row, position) => world.disc_point(&world.prepared.discs[row as usize], position),
        };
        world.emission(material, &point, is_front) * world.alpha(material, &point)
    }
}
