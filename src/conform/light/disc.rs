//! Disc lights. Conditioning: the height over the plane is a difference, so that its relative error grows with |c - p| r^2 over the
//! volume (c - p).(x cross y); the place of a sample moves by an ulp of what it is the sum of.

use glam::DVec3;

use super::super::inputs::Inputs;
use super::super::probe::{EPS, Probe};
use super::{direction, ratio, vector};
use crate::light::disc::{self, Disc};

pub(super) const FILES: [&str; 1] = ["light/disc.glsl"];

/// Point, centre, radii and u: heights and distances from 1e-6 to 1e6 radii, in the plane, at the centre and on the rim too.
fn case(r: &mut Inputs) -> [f32; 14] {
    let radius = f64::from(r.log(1e-4, 1e4));
    let normal = direction(r);
    let x = normal.any_orthonormal_vector();
    let turn = f64::from(r.range(0.0, 6.3));
    let (x, y) = (turn.cos() * x + turn.sin() * normal.cross(x), turn.cos() * normal.cross(x) - turn.sin() * x);
    let height = f64::from(match r.below(4) {
        0 => r.pick(&[0.0, 1.0, -1.0, 1e-6, 1e6]),
        1 => r.log(1e-6, 1.0),
        2 => -r.log(1e-3, 1e3),
        _ => r.log(1.0, 1e6),
    });
    let aside = f64::from(if r.once_in(4) { r.pick(&[0.0, 1.0]) } else { r.log(1e-3, 1e3) });
    let shift = direction(r) * radius * f64::from(if r.once_in(2) { 0.0 } else { r.log(0.1, 10.0) });
    let p = shift + radius * (height * normal + aside * (x * 0.6 + y * 0.8));
    let f = |v: DVec3| v.to_array().map(|c| c as f32);
    let (p, c, x, y) = (f(p), f(shift), f(radius * x), f(radius * y));
    [p[0], p[1], p[2], c[0], c[1], c[2], x[0], x[1], x[2], y[0], y[1], y[2], r.unit(), r.unit()]
}

fn judge(x: &[f32], y: &[f32]) -> f64 {
    if y.iter().any(|v| !v.is_finite()) {
        return f64::INFINITY;
    }
    let (p, disc) = (vector(x), Disc { center: vector(&x[3..]), x: vector(&x[6..]), y: vector(&x[9..]) });
    let (wi, [distance, sample_pdf, pdf]) = (vector(y), [y[3], y[4], y[5]].map(f64::from));
    if sample_pdf != pdf || pdf < 0.0 || distance < 0.0 {
        return f64::INFINITY;
    }
    let expected = disc::sample(p, &disc, [x[12], x[13]].map(f64::from));
    let to_center = disc.center - p;
    let n = disc.x.cross(disc.y);
    // What the sum is made of: centre and point as they are stored, and the radius.
    let scale = to_center.length() + disc.x.length();
    let moved = 8.0 * EPS * scale;
    let length = if expected.distance > 4.0 * moved { ratio((wi.length() - 1.0).abs(), 8.0 * EPS) } else { 0.0 };
    let place = ratio((distance * wi - expected.distance * expected.wi).length(), moved);
    let flatness = to_center.length() * n.length() / to_center.dot(n).abs();
    // In the plane to rounding: any density is right, since no light arrives there.
    if flatness.is_nan() || flatness * EPS >= 0.01 {
        return length.max(place);
    }
    // With the device's own distance, so that the place is not judged twice.
    let density = disc::pdf(p, &disc, distance);
    length.max(place).max(ratio((pdf / density - 1.0).abs(), 16.0 * EPS * (1.0 + flatness)))
}

pub fn probes() -> Vec<Probe> {
    let glsl = "vec3 p = vec3(x0, x1, x2), c = vec3(x3, x4, x5), a = vec3(x6, x7, x8), b = vec3(x9, x10, x11); \
        DiscLightSample s = disc_light_sample(p, c, a, b, vec2(x12, x13)); \
        y0 = s.wi.x; y1 = s.wi.y; y2 = s.wi.z; y3 = s.distance; y4 = s.pdf; y5 = disc_light_pdf(p, c, a, b, s.distance);";
    let bound =
        "place 8 eps (|c - p| + r), pdf 16 eps (1 + |c - p| |x cross y| / volume), both densities equal to the bit";
    vec![Probe::judged("disc_light_sample", glsl, 6, case, judge).files(&FILES).because(bound)]
}

/// Discs seen from the origin, for the chi-square rows: centre, normal and radius.
pub(super) const SEEN: [(&str, DVec3, DVec3, f64); 4] = [
    ("far", DVec3::new(3.0, -2.0, 5.0), DVec3::new(0.6, 0.0, -0.8), 0.01),
    ("overhead", DVec3::new(0.0, 0.0, 1.0), DVec3::new(0.0, 0.0, -1.0), 1.0),
    ("near", DVec3::new(0.3, 0.2, 0.1), DVec3::new(0.0, 0.0, -1.0), 1.0),
    ("grazing", DVec3::new(2.0, 0.0, 0.05), DVec3::new(0.0, 0.0, 1.0), 0.7),
];
