//! The replay world: `Prepared`'s own f32 records, decoded to f64, and the device's own integer stream.
//!
//! Every table is read as the kernel reads it (same alias words, same thresholds, same sampling maps), but intersection, path
//! loop and arithmetic are the oracle's. So `path` of a (pixel, sample) follows the device's path until rounding parts them.
//! This is also `--device cpu`. Faults in `Prepared` are invisible here: `independent` is for those.

mod lookup;
mod pattern;
mod placed;
mod stream;
mod surface;
mod vertex;

use std::sync::Arc;

use glam::{DVec2, DVec3};

use super::nested::{Inside, Medium};
use super::path::{LightSample, Random, Sample, VertexTrace, World, trace};
use super::surface::Surface;
use super::tree::{Hit, Ray, Shape, Tree};
use crate::camera::{self, Start, View};
use crate::film::filter;
use crate::integrator::{Estimator, SamplerKind, Settings};
use crate::light::{self, Reach, alias};
use crate::prepare::Prepared;
use crate::prepare::records::*;
use crate::sampler;
use pattern::Point;
pub use stream::Stream;
use vertex::Vertex;

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
        self.surface_at(ray, hit, outside)
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
