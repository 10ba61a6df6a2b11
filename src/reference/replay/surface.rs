//! From a hit to a surface: position, normals and tangent of its record, and the parameters that its pattern yields.

use glam::DVec3;

use super::pattern::Point;
use super::placed::ToWorld;
use super::{Part, Replay, rgb, vec};
use crate::bsdf::mixture::{self, Mixture};
use crate::bsdf::{InputKind, MODELS, Params};
use crate::prepare::pattern::Role;
use crate::prepare::records::*;
use crate::reference::surface::Surface;
use crate::reference::tree::{Hit, Ray};

impl Replay {
    /// The surface at a hit, its normals, frame and BSDF; `outside` is the index of refraction in front.
    pub(super) fn surface_at(&self, ray: &Ray, hit: &Hit, outside: f64) -> Surface {
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
                if input.is_index {
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
}
