//! Triangle lights. Conditioning of the density: the volume a . (e1 x e2) carries an error of eps |a| |e1| |e2|, which near the
//! triangle's plane is all of it; Van Oosterom and Strackee's quotient passes it on.

use glam::DVec3;

use super::super::inputs::Inputs;
use super::super::probe::{EPS, Probe};
use super::{direction, ratio, vector};
use crate::light::triangle::{self, SOLID_ANGLE_MAX, SOLID_ANGLE_MIN};

pub(super) const FILES: [&str; 1] = ["light/triangle.glsl"];
const SAMPLE: &str = "TriangleLightSample s = triangle_light_sample(vec3(x0, x1, x2), vec3(x3, x4, x5), \
    vec3(x6, x7, x8), vec3(x9, x10, x11), vec2(x12, x13)); ";

/// Point, vertices and u: every size and distance, slivers, points in the plane, on an edge and on a vertex, no area.
fn case(r: &mut Inputs) -> [f32; 14] {
    let size = f64::from(r.log(1e-4, 1e4));
    let distance = size * f64::from(if r.once_in(2) { r.log(1e-3, 1e6) } else { r.log(0.05, 20.0) });
    let thin = if r.once_in(2) { 1.0 } else { f64::from(r.log(1e-4, 1.0)) };
    let (e1, e2) = (direction(r) * size, direction(r) * size);
    let e2 = e1 * (1.0 - thin) + e2 * thin;
    // Half of them with the light at the origin, so that a far one keeps its shape in f32.
    let p = direction(r) * distance;
    let shift = if r.once_in(2) { DVec3::ZERO } else { direction(r) * f64::from(r.log(0.1, 10.0)) * size };
    let f = |v: DVec3| (v + shift).to_array().map(|x| x as f32);
    let (mut p, v0, mut v1, mut v2) = (f(p), f(DVec3::ZERO), f(e1), f(e2));
    match r.below(32) {
        // In the plane: all share z, inside or outside.
        0 => {
            (v1[2], v2[2]) = (v0[2], v0[2]);
            let (s, t) = (r.range(-2.0, 2.0), r.range(-2.0, 2.0));
            p = std::array::from_fn(|i| v0[i] + s * (v1[i] - v0[i]) + t * (v2[i] - v0[i]));
            p[2] = v0[2];
        }
        1 => p = v0,
        2 => p = std::array::from_fn(|i| 0.5 * (v0[i] + v1[i])),
        3 => v2 = v1,
        4 => (v1, v2) = (v0, v0),
        _ => (),
    }
    let u = [r.unit(), r.unit()];
    let mut x = [0.0; 14];
    for (k, v) in [p, v0, v1, v2].into_iter().enumerate() {
        x[3 * k..3 * k + 3].copy_from_slice(&v);
    }
    x[12..].copy_from_slice(&u);
    x
}

struct Case {
    p: DVec3,
    v: [DVec3; 3],
    u: [f64; 2],
    is_solid_angle: bool,
    /// |a| |e1| |e2| / volume: 1/cos, times the sliver's length over its width.
    flatness: f64,
    /// Relative error of the density for a relative error of 1 in its inputs.
    conditioning: f64,
    /// f32 may find the other branch.
    is_at_branch: bool,
    /// The longest distance to a vertex.
    size: f64,
}

impl Case {
    fn new(x: &[f32]) -> Self {
        let p = vector(x);
        let v = [vector(&x[3..]), vector(&x[6..]), vector(&x[9..])];
        let [a, b, c] = v.map(|w| w - p);
        let (e1, e2) = (v[1] - v[0], v[2] - v[0]);
        let (la, lb, lc) = (a.length(), b.length(), c.length());
        let volume = a.dot(e1.cross(e2)).abs();
        let volume_scale = la * e1.length() * e2.length();
        let parallel = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
        let omega = triangle::solid_angle(p, v);
        let is_solid_angle = (SOLID_ANGLE_MIN..=SOLID_ANGLE_MAX).contains(&omega);
        let flatness = volume_scale / volume;
        // d omega = 2 (parallel d volume - volume d parallel) / (volume^2 + parallel^2).
        let moved = parallel.abs() * volume_scale + volume * 4.0 * la * lb * lc;
        let omega_conditioning = 2.0 * moved / (volume * volume + parallel * parallel) / omega;
        let conditioning = 1.0 + if is_solid_angle { omega_conditioning } else { flatness };
        let margin = 64.0 * EPS * (1.0 + omega_conditioning);
        let is_near = |limit: f64| (omega / limit - 1.0).abs() < margin;
        // NaN (no area, or on a vertex) counts as at the branch: then only finiteness is asked.
        let is_at_branch =
            is_near(SOLID_ANGLE_MIN) || is_near(SOLID_ANGLE_MAX) || !(margin < 0.1 && conditioning * EPS < 0.01);
        let size = la.max(lb).max(lc);
        let u = [x[12].into(), x[13].into()];
        Self { p, v, u, is_solid_angle, flatness, conditioning, is_at_branch, size }
    }
}

/// Infinite for a result that no caller could use.
fn unusable(y: &[f32]) -> Option<f64> {
    y.iter().any(|v| !v.is_finite()).then_some(f64::INFINITY)
}

/// Both densities against f64, and each other.
fn judge_density(x: &[f32], y: &[f32]) -> f64 {
    if let Some(e) = unusable(y) {
        return e;
    }
    let [sample_pdf, pdf, distance] = [y[0], y[1], y[2]].map(f64::from);
    let case = Case::new(x);
    let same = ratio((pdf - sample_pdf).abs(), 16.0 * EPS * pdf);
    if sample_pdf < 0.0 || distance < 0.0 {
        return f64::INFINITY;
    }
    if case.is_at_branch {
        return same;
    }
    let expected = triangle::pdf(case.p, case.v, DVec3::Z, distance);
    same.max(ratio((pdf - expected).abs(), 16.0 * EPS * case.conditioning * expected))
}

/// Direction, distance and weights name one point of the triangle.
fn judge_point(x: &[f32], y: &[f32]) -> f64 {
    if let Some(e) = unusable(y) {
        return e;
    }
    let case = Case::new(x);
    let (wi, distance, [b1, b2]) = (vector(y), f64::from(y[3]), [y[4], y[5]].map(f64::from));
    let length = ratio((wi.length() - 1.0).abs(), 8.0 * EPS);
    if b1 < 0.0 || b2 < 0.0 || b1 + b2 > 1.0 + 4.0 * EPS {
        return f64::INFINITY;
    }
    if case.is_at_branch {
        return length;
    }
    let point = case.v[0] + b1 * (case.v[1] - case.v[0]) + b2 * (case.v[2] - case.v[0]) - case.p;
    // The ray meets the plane at an angle, which stretches what rounding leaves; by area there is no such step.
    let stretch = if case.is_solid_angle { 1.0 + case.flatness } else { 1.0 };
    length.max(ratio((point - distance * wi).length(), 32.0 * EPS * stretch * case.size))
}

/// The direction for u, against Arvo's in f64.
fn judge_direction(x: &[f32], y: &[f32]) -> f64 {
    if let Some(e) = unusable(y) {
        return e;
    }
    let case = Case::new(x);
    let expected = triangle::sample(case.p, case.v, case.u);
    // Without a sample there is no direction.
    if case.is_at_branch || expected.pdf == 0.0 {
        return 0.0;
    }
    let error = (vector(y) - expected.wi).length();
    let bound = 32.0 * EPS;
    if error <= bound { error / bound } else { error / (bound + 8.0 * moved(&case, expected.wi)) }
}

/// How far the direction moves, summed, when each vertex's coordinate does by 4 eps of its distance, and u0 by what 4 eps do to
/// the volume.
fn moved(case: &Case, wi: DVec3) -> f64 {
    let step = 4.0 * EPS;
    let shift = |v: [DVec3; 3], u: [f64; 2]| (triangle::sample(case.p, v, u).wi - wi).length();
    // The area to cut off is u0 times a solid angle with an error of its own.
    let step_u = step * (1.0 + case.u[0] * (case.conditioning + case.flatness));
    let at_u = |sign: f64| shift(case.v, [case.u[0] + sign * step_u, case.u[1]]);
    let mut sum = at_u(1.0).max(at_u(-1.0));
    for k in 0..3 {
        for axis in DVec3::AXES {
            let at = |sign: f64| {
                let mut v = case.v;
                v[k] += axis * (sign * step * (case.v[k] - case.p).length());
                shift(v, case.u)
            };
            sum += at(1.0).max(at(-1.0));
        }
    }
    sum
}

pub fn probes() -> Vec<Probe> {
    let density = format!(
        "{SAMPLE}y0 = s.pdf; y1 = triangle_light_pdf(vec3(x0, x1, x2), vec3(x3, x4, x5), vec3(x6, x7, x8), \
         vec3(x9, x10, x11), s.wi, s.distance); y2 = s.distance;"
    );
    let point = format!("{SAMPLE}y0 = s.wi.x; y1 = s.wi.y; y2 = s.wi.z; y3 = s.distance; y4 = s.b1; y5 = s.b2;");
    let direction = format!("{SAMPLE}y0 = s.wi.x; y1 = s.wi.y; y2 = s.wi.z;");
    vec![
        Probe::judged("triangle_light density", &density, 3, case, judge_density)
            .files(&FILES)
            .because("16 eps x (1 + conditioning of the solid angle, or 1/cos by area); sample and pdf within 16 eps")
            .covers(&["triangle_view", "triangle_view_pdf", "triangle_denominator"]),
        Probe::judged("triangle_light point", &point, 6, case, judge_point)
            .files(&FILES)
            .because("|p + d wi - point| within 32 eps x farthest vertex x (1 + |a||e1||e2|/volume); weights inside")
            .covers(&["triangle_weights"]),
        Probe::judged("triangle_light direction", &direction, 3, case, judge_direction)
            .files(&FILES)
            .because("32 eps + 8 x what moving each vertex coordinate by 4 eps of its distance, and u0 by 4 eps of the conditioning, does to Arvo's direction")
            .covers(&["triangle_direction", "triangle_across"]),
    ]
}
