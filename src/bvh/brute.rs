//! The judge of gate 5: every primitive tried, in f64, without a tree and without the watertight test's transform.
//!
//! Triangles by Möller and Trumbore 1997 on the f32 vertices taken as exact; spheres by the quadratic; discs by plane and radius. Beside the nearest hit
//! it can say how near a given primitive comes to being hit, so that a difference can be told apart from rounding.

use super::traverse::{Geometry, NONE, Ray};
use crate::prepare::records::{DiscRecord, SphereRecord, TriangleRecord};
use glam::DVec3;

/// Nearest hit of all; `margin` is the least barycentric weight (triangle) or the distance from the silhouette over the
/// radius (sphere, disc): below a few ulp, f32 may rightly see it otherwise.
#[derive(Clone, Copy, Debug)]
pub struct Nearest {
    pub t: f64,
    pub primitive: u32,
    pub margin: f64,
}

fn vector(v: [f32; 3]) -> DVec3 {
    DVec3::from(v.map(f64::from))
}

/// (t, least barycentric weight) with the triangle's plane; weights below 0 lie outside. None when edge-on.
pub fn plane_of_triangle(ray: &Ray, r: &TriangleRecord) -> Option<(f64, f64)> {
    plane_of_corners(ray, [r.v0, r.v1, r.v2].map(vector))
}

/// The same for corners in f64.
pub fn plane_of_corners(ray: &Ray, [a, b, c]: [DVec3; 3]) -> Option<(f64, f64)> {
    let (o, d) = (vector(ray.o), vector(ray.d));
    let (e1, e2) = (b - a, c - a);
    let p = d.cross(e2);
    let determinant = e1.dot(p);
    if determinant == 0.0 {
        return None;
    }
    let s = o - a;
    let q = s.cross(e1);
    let (b1, b2) = (s.dot(p) / determinant, d.dot(q) / determinant);
    Some((e2.dot(q) / determinant, b1.min(b2).min(1.0 - b1 - b2)))
}

/// Both distances and the margin; None when the ray's line passes by.
pub fn line_of_sphere(ray: &Ray, r: &SphereRecord) -> Option<([f64; 2], f64)> {
    let (f, d, radius) = (vector(ray.o) - vector(r.center), vector(ray.d), f64::from(r.radius));
    let a = d.length_squared();
    let s = -f.dot(d) / a;
    let perpendicular = (f + s * d).length();
    if perpendicular > radius {
        return None;
    }
    let half = ((radius - perpendicular) * (radius + perpendicular) / a).sqrt();
    Some(([s - half, s + half], 1.0 - perpendicular / radius))
}

/// Distance of the disc's plane, and how far inside the rim over the radius (below 0: outside). None when edge-on.
pub fn plane_of_disc(ray: &Ray, r: &DiscRecord) -> Option<(f64, f64)> {
    let (f, d, n) = (vector(r.center) - vector(ray.o), vector(ray.d), vector(r.normal));
    let along = d.dot(n);
    if along == 0.0 {
        return None;
    }
    let t = f.dot(n) / along;
    Some((t, 1.0 - (t * d - f).length() / f64::from(r.radius)))
}

/// Nearest hit with 0 < t < t_max, ties to the smaller primitive number; None when all are missed.
pub fn nearest(g: &Geometry, ray: &Ray) -> Option<Nearest> {
    let mut best = Nearest { t: f64::from(ray.t_max), primitive: NONE, margin: 0.0 };
    let mut offer = |t: f64, primitive: u32, margin: f64| {
        if t > 0.0 && (t < best.t || (t == best.t && primitive < best.primitive)) {
            best = Nearest { t, primitive, margin };
        }
    };
    for r in g.triangles {
        if let Some((t, margin)) = plane_of_triangle(ray, r)
            && margin >= 0.0
        {
            offer(t, r.face, margin);
        }
    }
    for r in g.spheres {
        if let Some((t, margin)) = line_of_sphere(ray, r) {
            t.iter().for_each(|&t| offer(t, r.primitive, margin));
        }
    }
    for r in g.discs {
        if let Some((t, margin)) = plane_of_disc(ray, r)
            && margin >= 0.0
        {
            offer(t, r.primitive, margin);
        }
    }
    (best.primitive != NONE).then_some(best)
}
