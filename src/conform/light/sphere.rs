//! Sphere lights. Conditioning: with cos_max = sqrt(1 - (r/d)^2) the cone's height moves by 1/cos_max for a change in r/d, and so do
//! direction and distance; from inside, the far root of a grazing chord moves by r over its half length.

use glam::DVec3;

use super::super::inputs::Inputs;
use super::super::probe::{EPS, Probe};
use super::{direction, ratio, vector};
use crate::light::sphere;

pub(super) const FILES: [&str; 1] = ["light/sphere.glsl"];

/// Point, centre, radius and u; d/r from 0 through 1 to 1e6.
fn case(r: &mut Inputs) -> [f32; 9] {
    let radius = r.log(1e-4, 1e4);
    let ratio = match r.below(6) {
        0 => r.pick(&[0.0, 0.5, 1.0, 1.0 + 1e-6, 1e6, 2.0]),
        1 => r.range(0.0, 1.0),
        2 => 1.0 + r.log(1e-6, 1.0),
        3 => 1.0 - r.log(1e-6, 1.0),
        4 => r.log(1.0, 1e6),
        _ => r.range(1.0, 4.0),
    };
    let away = direction(r) * f64::from(ratio) * f64::from(radius);
    let shift = direction(r) * f64::from(radius) * f64::from(if r.once_in(2) { 0.0 } else { r.log(0.1, 10.0) });
    let (p, c) = ((shift + away).to_array().map(|x| x as f32), shift.to_array().map(|x| x as f32));
    [p[0], p[1], p[2], c[0], c[1], c[2], radius, r.unit(), r.unit()]
}

fn judge(x: &[f32], y: &[f32]) -> f64 {
    if y.iter().any(|v| !v.is_finite()) {
        return f64::INFINITY;
    }
    let (p, center, radius, u) = (vector(x), vector(&x[3..]), f64::from(x[6]), [x[7], x[8]].map(f64::from));
    let (wi, [distance, sample_pdf, pdf]) = (vector(y), [y[3], y[4], y[5]].map(f64::from));
    if sample_pdf != pdf || pdf <= 0.0 || distance < 0.0 {
        return f64::INFINITY;
    }
    let d = (center - p).length();
    let length = ratio((wi.length() - 1.0).abs(), 8.0 * EPS);
    // The surface itself: either side is right.
    if (d / radius - 1.0).abs() < 8.0 * EPS {
        return length;
    }
    let expected = sphere::sample(p, center, radius, u);
    let is_outside = d > radius;
    if (y[6] == 1.0) != is_outside {
        return f64::INFINITY;
    }
    let sin = radius / d;
    let cos_max = if is_outside { ((1.0 - sin) * (1.0 + sin)).sqrt() } else { 1.0 };
    let moved = 1.0 + 1.0 / cos_max;
    let distance_bound = if is_outside {
        16.0 * EPS * d * moved
    } else {
        let half_chord = (expected.distance - expected.wi.dot(center - p)).abs();
        16.0 * EPS * radius * (1.0 + radius / half_chord.max(EPS.sqrt() * radius))
    };
    length
        .max(ratio((pdf / expected.pdf - 1.0).abs(), 8.0 * EPS * moved))
        .max(ratio((wi - expected.wi).length(), 12.0 * EPS * moved))
        .max(ratio((distance - expected.distance).abs(), distance_bound))
}

pub fn probes() -> Vec<Probe> {
    let glsl = "vec3 p = vec3(x0, x1, x2); vec3 c = vec3(x3, x4, x5); \
        SphereLightSample s = sphere_light_sample(p, c, x6, vec2(x7, x8)); \
        y0 = s.wi.x; y1 = s.wi.y; y2 = s.wi.z; y3 = s.distance; y4 = s.pdf; y5 = sphere_light_pdf(p, c, x6); \
        y6 = sphere_light_is_outside(p, c, x6) ? 1.0 : 0.0;";
    let bound = "m = 1 + 1/sqrt(1 - (r/d)^2): pdf 8 eps m, direction 12 eps m, distance 16 eps d m; inside r over the half chord";
    vec![
        Probe::judged("sphere_light_sample", glsl, 7, case, judge)
            .files(&FILES)
            .because(bound)
            .covers(&["sphere_light_cone", "sphere_light_cone_pdf"]),
        Probe::judged(
            "sphere_light_cone",
            "y0 = sphere_light_cone(x0); y1 = sphere_light_cone_pdf(y0);",
            2,
            |r| [r.log(1e-6, 1.0)],
            |x, y| {
                // The half angle's own sine gives 1 - cos = 2 sin^2(theta/2) another way.
                let s = f64::from(x[0]);
                let h = 2.0 * (0.5 * s.min(1.0).asin()).sin().powi(2);
                let moved = 1.0 + 1.0 / (1.0 - s * s).sqrt().max(EPS.sqrt());
                let pdf = 1.0 / (std::f64::consts::TAU * f64::from(y[0]));
                ratio((f64::from(y[0]) / h - 1.0).abs(), 4.0 * EPS * moved)
                    .max(ratio((f64::from(y[1]) / pdf - 1.0).abs(), 4.0 * EPS))
            },
        )
        .files(&FILES)
        .because("4 eps (1 + 1/sqrt(1 - s^2)) against 2 sin^2(theta/2)"),
    ]
}

/// Spheres seen from the origin, for the chi-square rows: centre and radius.
pub(super) const SEEN: [(&str, DVec3, f64); 4] = [
    ("far", DVec3::new(3.0, -2.0, 5.0), 0.01),
    ("near", DVec3::new(0.0, 0.0, 1.1), 1.0),
    ("tangent", DVec3::new(0.0, 1.000001, 0.0), 1.0),
    ("inside", DVec3::new(0.2, 0.1, -0.3), 1.0),
];
