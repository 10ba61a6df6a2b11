//! The independent world: straight from `scene::Scene`, sharing no table and no decoding with `prepare`.
//!
//! Instances are transformed in f64 here (normals by the inverse transpose), attributes are interpolated and textures looked
//! up here, lights are listed and sampled by area here, and numbers come from a generator of its own. What it shares with the
//! device is the description of the scene and the f64 BSDF models. The camera must have been placed.

mod camera;
mod light;
mod media;
mod mip;
mod primitives;
mod random;
mod value;

use glam::{DVec2, DVec3};

use super::nested::{Inside, Medium};
use super::path::{LightSample, World};
use super::surface::Surface;
use super::tree::{Hit, Ray, Shape, Tree};
use crate::bsdf::mixture::{self, Mixture};
use crate::bsdf::{InputKind, MODELS, Params};
use crate::camera::Start;
use crate::integrator::Estimator;
use crate::prepare::records::NONE;
use crate::scene::{self, Alpha, Material, Scene, Value};
use light::Lights;
use media::{is_thin, medium_of, transmits};
use primitives::{Primitives, RECTANGLE, RECTANGLE_PARTS};
pub use random::Stream;
pub use value::Point;

/// A scene with what the oracle adds: world-space geometry, a tree and its own light tables.
pub struct Independent<'a> {
    scene: &'a Scene,
    tree: Tree,
    primitives: Primitives<'a>,
    /// By material and surface: the model's inputs, with metals' curves resolved to RGB.
    inputs: Vec<Vec<Vec<Value>>>,
    /// By texture.
    pyramids: Vec<mip::Pyramid>,
    lights: Lights,
    /// By material: number of its light group.
    groups: Vec<u32>,
    /// Of the camera, when it is a surface meter.
    elements: camera::Elements,
    nests: bool,
    camera_inside: Inside,
}

impl<'a> Independent<'a> {
    pub fn new(scene: &'a Scene) -> Self {
        let primitives = Primitives::new(scene);
        let tree = primitives.tree(primitives.count() > primitives::FLAT_LIMIT);
        let inputs = scene.materials.iter().map(|m| m.surfaces().iter().map(resolved).collect()).collect();
        let mut world = Self {
            scene,
            tree,
            primitives,
            inputs,
            pyramids: mip::pyramids(scene),
            lights: Lights::default(),
            groups: Vec::new(),
            elements: camera::Elements::new(),
            nests: false,
            camera_inside: Inside::default(),
        };
        world.lights = Lights::of(&world);
        world.groups = world.lights.material_groups(&world);
        world.elements = camera::elements(&world);
        world.nests = world.bodies_overlap();
        let place = scene.camera.to_world.translation;
        world.camera_inside = if world.nests { world.media_at(place) } else { Inside::only(world.medium_at(place)) };
        world
    }

    fn material(&self, primitive: u32) -> &'a Material {
        &self.scene.materials[self.scene.instances[self.primitives.instance_of(primitive)].material]
    }

    /// Geometry and attributes at barycentric weights `b` of a triangle, or at `position` of a sphere or disc.
    fn point(&self, primitive: u32, b: [f64; 2], position: DVec3) -> Point {
        let p = self.primitives.get(primitive);
        let instance = &self.scene.instances[p.instance as usize];
        match p.shape {
            Shape::Sphere { center, .. } => {
                let normal = (position - center).normalize();
                let local = instance.to_world.matrix3.transpose().mul_vec3(normal).normalize();
                let uv = DVec2::new(
                    local.x.atan2(-local.z) / std::f64::consts::TAU + 0.5,
                    local.y.clamp(-1.0, 1.0).acos() / std::f64::consts::PI,
                );
                // Towards growing u: the matrix applied to the local derivative (-z, 0, x) of (sin u, ., -cos u).
                // A normal map's y points up the picture, to the pole v = 0; u grows to the left seen from outside.
                let tangent = instance.to_world.matrix3 * DVec3::new(-local.z, 0.0, local.x);
                let tangent = Some((tangent, if p.is_mirrored { 1.0 } else { -1.0 }));
                Point { tangent, uvs: [uv; 2], ..Point::on(position, normal) }
            }
            Shape::Disc { normal, .. } => {
                let local = instance.to_world.inverse().transform_point3(position);
                let uv = DVec2::new(0.5 * (local.x + 1.0), 0.5 * (1.0 - local.y));
                let mirror = if p.is_mirrored { -1.0 } else { 1.0 };
                let tangent = Some((instance.to_world.matrix3.x_axis, mirror));
                Point { tangent, uvs: [uv; 2], ..Point::on(position, normal) }
            }
            Shape::Triangle(v) => {
                let weights = [1.0 - b[0] - b[1], b[0], b[1]];
                let winding = (v[1] - v[0]).cross(v[2] - v[0]).normalize_or_zero();
                let geometric_normal = if p.is_mirrored { -winding } else { winding };
                let position = weights[0] * v[0] + weights[1] * v[1] + weights[2] * v[2];
                let mut point = Point::on(position, geometric_normal);
                match instance.shape {
                    scene::Shape::Mesh(mesh) => {
                        let mesh = &self.scene.meshes[mesh];
                        value::interpolate(mesh, p.part as usize, weights, &instance.to_world, &mut point);
                    }
                    _ => {
                        let corners = RECTANGLE_PARTS[p.part as usize].map(|i| RECTANGLE[i]);
                        let local = weights[0] * corners[0] + weights[1] * corners[1] + weights[2] * corners[2];
                        point.uvs = [DVec2::new(0.5 * (local.x + 1.0), 0.5 * (1.0 - local.y)); 2];
                    }
                }
                point
            }
        }
    }

    /// Radiance that leaves `point` of a material into the hemisphere that sees it from `direction` (towards the point).
    fn emission(&self, material: &Material, point: &Point, direction: DVec3) -> DVec3 {
        match &material.emission {
            Some(value) if material.emission_two_sided || direction.dot(point.geometric_normal) < 0.0 => {
                rgb(self.evaluate(value, point))
            }
            _ => DVec3::ZERO,
        }
    }

    fn alpha(&self, material: &Material, point: &Point) -> f64 {
        match &material.alpha {
            Alpha::Opaque => 1.0,
            Alpha::Mask { value, cutoff } => f64::from(u8::from(self.evaluate(value, point)[0] >= *cutoff)),
            Alpha::Blend { value } => self.evaluate(value, point)[0],
        }
    }
}

/// The inputs of a surface; a metal's spectral index becomes the RGB index that reflects the same colour.
fn resolved(surface: &scene::Surface) -> Vec<Value> {
    let mut inputs = surface.inputs.to_vec();
    let place = |name: &str| MODELS[surface.bsdf].inputs.iter().position(|i| i.name == name);
    if let (Some(eta), Some(k)) = (place("eta"), place("k"))
        && let (Value::Curve(eta_curve), Value::Curve(k_curve)) = (&surface.inputs[eta], &surface.inputs[k])
    {
        let (rgb_eta, rgb_k) = crate::math::spectrum::fit_conductor_rgb(eta_curve, k_curve);
        inputs[eta] = Value::rgb(rgb_eta.x, rgb_eta.y, rgb_eta.z);
        inputs[k] = Value::rgb(rgb_k.x, rgb_k.y, rgb_k.z);
    }
    inputs
}

/// True unless the value is the constant 0.
fn may_be_positive(value: &Value) -> bool {
    !matches!(value, Value::Constant([x, ..]) if *x == 0.0)
}

fn rgb(v: [f64; 4]) -> DVec3 {
    DVec3::new(v[0], v[1], v[2])
}

impl World for Independent<'_> {
    type Stream = Stream;

    fn size(&self) -> [u32; 2] {
        [self.scene.film.width, self.scene.film.height]
    }

    fn stream(&self, seed: u32, pixel: [u32; 2], sample: u64) -> Stream {
        Stream::new(u64::from(seed), pixel, sample)
    }

    fn filter_offset(&self, u: f64) -> f64 {
        self.scene.film.filter.offset(u)
    }

    fn camera_start(&self, film: DVec2, random: &Stream) -> Start {
        camera::start(self, film, random)
    }

    fn camera_cone(&self) -> DVec2 {
        camera::cone(self)
    }

    fn camera_inside(&self) -> Inside {
        self.camera_inside
    }

    fn nests(&self) -> bool {
        self.nests
    }

    fn boundary_medium(&self, primitive: u32) -> Option<u32> {
        let material = self.scene.instances[self.primitives.instance_of(primitive)].material;
        self.bounds_medium(&self.scene.materials[material]).then_some(material as u32)
    }

    fn tree(&self) -> &Tree {
        &self.tree
    }

    fn has_alpha(&self) -> bool {
        self.scene.materials.iter().any(|m| !matches!(m.alpha, Alpha::Opaque))
    }

    fn presence(&self, ray: &Ray, hit: &Hit) -> f64 {
        let material = self.material(hit.primitive);
        if matches!(material.alpha, Alpha::Opaque) {
            return 1.0;
        }
        self.alpha(material, &self.point(hit.primitive, hit.barycentric, ray.at(hit.t)))
    }

    fn surface(&self, ray: &Ray, hit: &Hit, outside: f64) -> Surface {
        let material = self.material(hit.primitive);
        let point = self.point(hit.primitive, hit.barycentric, ray.at(hit.t));
        let instance = self.primitives.instance_of(hit.primitive);
        // Emission and presence are looked up at a point.
        let mut shaded = point;
        if self.scene.texture_filter == scene::TextureFilter::Mipmap {
            shaded.areas = self.areas(ray, hit, &point);
        }
        let params_of = |bsdf: usize, values: &[Value]| {
            let mut inputs = [DVec3::ZERO; 32];
            for ((slot, value), input) in inputs.iter_mut().zip(values).zip(MODELS[bsdf].inputs) {
                let v = self.evaluate(value, &shaded);
                *slot = if input.kind == InputKind::Scalar { DVec3::splat(v[0]) } else { rgb(v) };
                // Fresnel's equations know only the ratio of the two indices (Born and Wolf 1999, 1.5).
                if ["ior", "eta", "k"].contains(&input.name) {
                    *slot /= outside;
                }
            }
            Params::from_inputs(bsdf, &inputs[..values.len()])
        };
        let values = &self.inputs[self.scene.instances[instance].material];
        let params = if material.parts.is_empty() {
            Mixture::One(params_of(material.bsdf, &values[0]))
        } else {
            let part = |(part, values): (&scene::Part, &Vec<Value>)| mixture::Part {
                share: self.evaluate(&part.share, &shaded)[0],
                params: params_of(part.bsdf, values),
                is_one_sided: !MODELS[part.bsdf].transmits,
            };
            Mixture::Many(material.parts.iter().zip(values).map(part).collect())
        };
        let normal_map = material.normal_map.as_ref().map(|(value, scale)| {
            let n = 2.0 * rgb(self.evaluate(value, &shaded)) - 1.0;
            DVec3::new(scale * n.x, scale * n.y, n.z)
        });
        let transmits = transmits(material);
        Surface {
            point: point.position,
            geometric_normal: point.geometric_normal,
            normal: point.normal,
            uv: point.uvs[0],
            object: instance as u32,
            material: self.scene.instances[instance].material as u32,
            tangent: point.tangent,
            normal_map,
            params,
            transmits,
            emission: self.emission(material, &point, ray.direction),
            group: self.groups[self.scene.instances[instance].material],
            boundary: (transmits && !is_thin(material)).then(|| match material.interior {
                Some(_) => self.scene.instances[instance].material as u32,
                None => NONE,
            }),
        }
    }

    /// Media are named by the material that holds them.
    fn medium(&self, medium: u32) -> Medium {
        medium_of(&self.scene.materials[medium as usize])
    }

    fn background(&self, direction: DVec3, visit: &mut dyn FnMut(DVec3, f64, u32)) {
        let radiance = self.lights.sky.radiance(direction);
        if radiance != DVec3::ZERO {
            visit(radiance, self.lights.sky_density(direction), self.lights.sky_group);
        }
        self.lights.suns(direction, visit);
    }

    fn emitter_density(&self, ray: &Ray, hit: &Hit) -> f64 {
        self.lights.emitter_density(self, ray, hit)
    }

    fn sample_light(&self, point: DVec3, random: &Stream, vertex: u32, _: Estimator) -> Option<LightSample> {
        self.lights.sample(self, point, random, vertex)
    }
}
