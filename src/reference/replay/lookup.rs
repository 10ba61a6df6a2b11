//! What patterns read at a hit: texture coordinates and vertex colours, and how much of a texture a ray's cone covers there.

use glam::{DVec2, DVec3};

use super::pattern::Point;
use super::placed::ToWorld;
use super::{Part, Replay, vec};
use crate::prepare::records::{DiscRecord, SphereRecord, UvRecord};
use crate::reference::tree::{Hit, Ray};

impl Replay {
    /// What patterns read at barycentric weights of a face.
    pub(super) fn face_point(&self, face: u32, b: [f64; 2]) -> Point {
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
    pub(super) fn sphere_point(&self, sphere: &SphereRecord, normal: DVec3) -> Point {
        let [x, y, z, w] = sphere.rotation.map(f64::from);
        let local = f64::from(sphere.handedness) * (glam::DQuat::from_xyzw(x, y, z, w).normalize() * normal);
        let u = 0.5 + local.x.atan2(-local.z) / std::f64::consts::TAU;
        let v = local.y.clamp(-1.0, 1.0).acos() / std::f64::consts::PI;
        Point { uvs: [DVec2::new(u, v); 2], ..Point::default() }
    }

    /// What patterns read at a point of a disc.
    pub(super) fn disc_point(&self, disc: &DiscRecord, position: DVec3) -> Point {
        let (normal, tangent) = (vec(disc.normal), vec(disc.tangent));
        let local = (position - vec(disc.center)) / f64::from(disc.radius);
        let (x, y) = (local.dot(tangent), f64::from(disc.handedness) * local.dot(normal.cross(tangent)));
        Point { uvs: [DVec2::new(0.5 * (x + 1.0), 0.5 * (1.0 - y)); 2], ..Point::default() }
    }

    pub(super) fn point(&self, ray: &Ray, hit: &Hit) -> Point {
        match self.part(hit.primitive) {
            Part::Triangle(t) => self.face_point(t.face, hit.barycentric),
            Part::Sphere(sphere) => self.sphere_point(sphere, (ray.at(hit.t) - vec(sphere.center)).normalize()),
            Part::Disc(disc) => self.disc_point(disc, ray.at(hit.t)),
        }
    }

    /// Areas of the cone's footprint in the units of both texture coordinates (texture/mip.rs).
    pub(super) fn areas(&self, ray: &Ray, hit: &Hit, normal: DVec3) -> [f64; 2] {
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
}
