//! A triangle light: directions uniform in the solid angle it fills (Arvo 1995, "Stratified sampling of spherical triangles"),
//! and uniform points on it where that solid angle is too small or too near 2 pi for the formula.
//!
//! The solid angle is that of Van Oosterom and Strackee 1983. `sample` and `pdf` take the same branch, from the same number.
//! The kernels (shaders/light/triangle.glsl) solve for the same point by half-angle tangents, Arvo's text is followed here; the
//! two agree in gate 3. Which side emits is the caller's test. A pdf of 0 means that there is no sample: seen exactly edge-on.

use std::f64::consts::PI;

use glam::DVec3;

use super::{Connection, Emitter, LIGHT_TRIANGLE, Place, Reach, Surroundings, emitted_luminance, kept_positive, vector};
use crate::prepare::records::LightRecord;

pub const REACH: Reach = Reach::Surface(density);
pub const SHARED: &[&str] = &[];

/// Below, the vertices' directions differ in too few bits (the same limit as pbrt's).
pub const SOLID_ANGLE_MIN: f64 = 3e-4;
/// Above, the triangle is nearly a hemisphere and its sum of angles cancels.
pub const SOLID_ANGLE_MAX: f64 = 6.22;

/// A point on the light as seen from `p`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleLightSample {
    pub wi: DVec3,
    pub distance: f64,
    /// 1/sr; 0 means no sample.
    pub pdf: f64,
    /// Weights of vertices 1 and 2.
    pub b1: f64,
    pub b2: f64,
}

/// Solid angle of the triangle from `p`, sr, in [0, 2 pi]; 0 in its plane outside it.
pub fn solid_angle(p: DVec3, v: [DVec3; 3]) -> f64 {
    let [a, b, c] = v.map(|x| x - p);
    let (la, lb, lc) = (a.length(), b.length(), c.length());
    let volume = a.dot((v[1] - v[0]).cross(v[2] - v[0])).abs();
    2.0 * volume.atan2(la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb)
}

fn is_sampled_by_solid_angle(omega: f64) -> bool {
    (SOLID_ANGLE_MIN..=SOLID_ANGLE_MAX).contains(&omega)
}

/// Density of uniform points on the triangle, per solid angle: 2 d^3 / |(v0 - p) . (e1 x e2)|. 0 edge-on.
fn area_pdf(p: DVec3, v: [DVec3; 3], distance: f64) -> f64 {
    let volume = (v[0] - p).dot((v[1] - v[0]).cross(v[2] - v[0])).abs();
    let pdf = 2.0 * distance.powi(3) / volume;
    if pdf.is_finite() { pdf } else { 0.0 }
}

/// Density of `sample` in direction `wi`, which meets the triangle at `distance`; 1/sr.
pub fn pdf(p: DVec3, v: [DVec3; 3], _wi: DVec3, distance: f64) -> f64 {
    let omega = solid_angle(p, v);
    if is_sampled_by_solid_angle(omega) { 1.0 / omega } else { area_pdf(p, v, distance) }
}

pub fn sample(p: DVec3, v: [DVec3; 3], u: [f64; 2]) -> TriangleLightSample {
    let omega = solid_angle(p, v);
    if !is_sampled_by_solid_angle(omega) {
        return sample_area(p, v, u);
    }
    let wi = arvo(v.map(|x| (x - p).normalize()), omega, u);
    let (b1, b2) = barycentrics(p, v, wi);
    let point = v[0] + b1 * (v[1] - v[0]) + b2 * (v[2] - v[0]);
    TriangleLightSample { wi, distance: (point - p).length(), pdf: 1.0 / omega, b1, b2 }
}

/// Uniform points by the low-distortion map of Heitz 2019.
fn sample_area(p: DVec3, v: [DVec3; 3], u: [f64; 2]) -> TriangleLightSample {
    let [b1, b2] = if u[1] > u[0] { [0.5 * u[0], u[1] - 0.5 * u[0]] } else { [u[0] - 0.5 * u[1], 0.5 * u[1]] };
    let q = v[0] + b1 * (v[1] - v[0]) + b2 * (v[2] - v[0]) - p;
    let distance = q.length();
    let pdf = if distance > 0.0 { area_pdf(p, v, distance) } else { 0.0 };
    TriangleLightSample { wi: q.try_normalize().unwrap_or(DVec3::Z), distance, pdf, b1, b2 }
}

/// Arvo 1995, section 4: the sub-triangle A B C' of area u0 S, then a point on its arc from B to C'.
fn arvo([a, b, c]: [DVec3; 3], omega: f64, u: [f64; 2]) -> DVec3 {
    let orthogonal = |x: DVec3, y: DVec3| (x - x.dot(y) * y).normalize();
    // The angle at A between the planes of A B and A C.
    let (n_ab, n_ac) = (a.cross(b), a.cross(c));
    let alpha = n_ab.cross(n_ac).length().atan2(n_ab.dot(n_ac));
    let (sin_alpha, cos_alpha) = alpha.sin_cos();
    let (s, t) = (u[0] * omega - alpha).sin_cos();
    let (uu, vv) = (t - cos_alpha, s + sin_alpha * a.dot(b));
    let q = ((vv * t - uu * s) * cos_alpha - vv) / ((vv * s + uu * t) * sin_alpha);
    // u0 = 0 gives 0/0 when A B is a right angle; the limit is C' = A.
    let q = if u[0] == 0.0 || q.is_nan() { 1.0 } else { q.clamp(-1.0, 1.0) };
    let c_new = q * a + (1.0 - q * q).max(0.0).sqrt() * orthogonal(c, a);
    let z = 1.0 - u[1] * (1.0 - c_new.dot(b));
    if u[1] == 0.0 { b } else { z * b + (1.0 - z * z).max(0.0).sqrt() * orthogonal(c_new, b) }
}

/// Weights of vertices 1 and 2 where the ray p + t wi meets the plane, moved into the triangle.
fn barycentrics(p: DVec3, v: [DVec3; 3], wi: DVec3) -> (f64, f64) {
    let (e1, e2, a) = (v[1] - v[0], v[2] - v[0], v[0] - p);
    let inv = 1.0 / wi.dot(e1.cross(e2));
    let w = wi.cross(a);
    let b1 = (-w.dot(e2) * inv).clamp(0.0, 1.0);
    let b2 = (w.dot(e1) * inv).clamp(0.0, 1.0);
    let sum = (b1 + b2).max(1.0);
    (b1 / sum, b2 / sum)
}

/// A triangle of the scene, front counter-clockwise. Power: pi A L, twice that where both sides emit. `mean_radiance` is that over
/// the triangle, or over its texture: any channel > 0 where the emission is > 0 anywhere.
pub fn emitter(v: [[f32; 3]; 3], face: u32, material: u32, mean_radiance: DVec3, two_sided: bool) -> Emitter {
    let [v0, v1, v2] = v.map(vector);
    let area = 0.5 * (v1 - v0).cross(v2 - v0).length();
    let luminance = emitted_luminance(mean_radiance);
    // A triangle without area, or with a vertex that is no number, cannot be hit.
    let emits = area > 0.0 && area.is_finite() && luminance > 0.0;
    let sides = if two_sided { 2.0 } else { 1.0 };
    let record = LightRecord { kind: LIGHT_TRIANGLE, a: v[0], b: v[1], c: v[2], material, shape: face, ..LightRecord::default() };
    Emitter { record, power: if emits { kept_positive(sides * PI * area * luminance, true) } else { 0.0 }, is_distant: false }
}

fn vertices(light: &LightRecord) -> [DVec3; 3] {
    [light.a, light.b, light.c].map(vector)
}

pub fn connect(world: &dyn Surroundings, light: &LightRecord, p: DVec3, u: [f64; 2]) -> Connection {
    let v = vertices(light);
    let s = sample(p, v, u);
    let is_front = s.wi.dot((v[1] - v[0]).cross(v[2] - v[0])) < 0.0;
    let radiance = world.emission(light.material, Place::Face(light.shape, [s.b1, s.b2]), is_front);
    Connection { wi: s.wi, distance: s.distance, radiance, pdf: s.pdf, primitive: light.shape }
}

fn density(light: &LightRecord, p: DVec3, wi: DVec3, distance: f64, _is_front: bool) -> f64 {
    pdf(p, vertices(light), wi, distance)
}

#[cfg(test)]
#[path = "triangle_tests.rs"]
mod tests;
