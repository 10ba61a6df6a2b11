//! Lamps: the view of a point, the falloff of spots, the sun's disc. A step (a cone's rim, the sun's) may fall to either side where
//! rounding of the angle reaches it.

use glam::DVec3;

use super::super::inputs::Inputs;
use super::super::probe::{EPS, Probe};
use super::{direction, ratio, vector};
use crate::light::lamp::LampModel;
use crate::light::spot::{Falloff, Spot, one_minus_cos};
use crate::light::sun::Sun;
use crate::prepare::records::LightRecord;

fn points(r: &mut Inputs) -> [f32; 6] {
    let p = direction(r) * f64::from(r.log(1e-3, 1e6));
    let d = direction(r) * f64::from(r.log(1e-4, 1e8));
    let q = if r.once_in(32) { p } else { p + d };
    let (p, q) = (p.as_vec3(), q.as_vec3());
    [p.x, p.y, p.z, q.x, q.y, q.z]
}

fn judge_point(x: &[f32], y: &[f32]) -> f64 {
    if y.iter().any(|v| !v.is_finite()) {
        return f64::INFINITY;
    }
    let to_light = vector(&x[3..]) - vector(x);
    let d = to_light.length();
    if d == 0.0 {
        return if y[5] == 0.0 { 0.0 } else { f64::INFINITY };
    }
    let [distance, inverse] = [y[3], y[4]].map(f64::from);
    ratio((vector(y) - to_light / d).length(), 6.0 * EPS)
        .max(ratio((distance / d - 1.0).abs(), 4.0 * EPS))
        .max(ratio((inverse * d * d - 1.0).abs(), 6.0 * EPS))
        .max(if y[5] == 1.0 { 0.0 } else { f64::INFINITY })
}

/// Two directions an angle apart, and a falloff's three numbers as the record holds them.
fn spots(r: &mut Inputs) -> [f32; 9] {
    let axis = direction(r);
    let angle = if r.once_in(2) { r.range(0.0, std::f32::consts::PI) } else { r.log(1e-5, 1.0) };
    let (sin, cos) = f64::from(angle).sin_cos();
    let w = (axis * cos + axis.any_orthonormal_vector() * sin).as_vec3();
    let cone = f64::from(r.log(1e-3, 3.1));
    let falloff = match r.below(3) {
        0 => Falloff::Hard { cone_h: one_minus_cos(cone) },
        1 => Falloff::Cosine { exponent: f64::from(if r.once_in(4) { 1.0 } else { r.log(1e-2, 300.0) }) },
        _ => {
            let inner = cone * f64::from(r.range(0.0, 0.99));
            Falloff::Smooth { inner_h: one_minus_cos(inner), outer_h: one_minus_cos(cone) }
        }
    };
    let lamp = Spot { position: DVec3::ZERO, axis, intensity: DVec3::ONE, falloff };
    let LightRecord { b, falloff, .. } = lamp.record(DVec3::ZERO);
    [b[0], b[1], b[2], w.x, w.y, w.z, falloff[0], falloff[1], falloff[2]]
}

/// The share in f64 for an angle with this h, written on x.
fn share(h: f64, [scale, offset, exponent]: [f64; 3]) -> f64 {
    let x = offset - scale * h;
    if x <= 0.0 { 0.0 } else { x.min(1.0).powf(exponent) }
}

fn judge_spot(x: &[f32], y: &[f32]) -> f64 {
    let (axis, w) = (vector(x), vector(&x[3..]));
    let falloff = [x[6], x[7], x[8]].map(f64::from);
    let (h, got) = (f64::from(y[0]), f64::from(y[1]));
    // Of the given vectors: each difference is off by eps, so its square by 2 and one for the product, and two sums add one each.
    let exact = 0.5 * (w - axis).length_squared();
    let h_error = ratio((h - exact).abs(), 5.0 * EPS * exact);
    // From the device's own h: products and difference are off by eps of the larger.
    let slack = 2.0 * EPS * (falloff[1].abs() + falloff[0] * h);
    let steps = slack / falloff[0];
    let (high, low) = (share(h - steps, falloff), share(h + steps, falloff));
    // exp and log: eps of the exponent times the logarithm, and 4 eps of their own.
    let inner = (falloff[1] - falloff[0] * h).clamp(1e-37, 1.0);
    let own = (4.0 + 4.0 * falloff[2] * inner.ln().abs()) * EPS;
    let is_inside = got >= low * (1.0 - own) - 1e-37 && got <= high * (1.0 + own) + 1e-37;
    h_error.max(if is_inside { 0.5 } else { f64::INFINITY })
}

fn suns(r: &mut Inputs) -> [f32; 9] {
    let axis = direction(r).as_vec3();
    let half_angle = f64::from(r.log(1e-4, 1.57));
    let (sin, cos) = (half_angle * f64::from(r.range(0.0, 2.0))).sin_cos();
    let axis64 = axis.as_dvec3().normalize();
    let d = (axis64 * cos + axis64.any_orthonormal_vector() * sin).as_vec3();
    [axis.x, axis.y, axis.z, one_minus_cos(half_angle) as f32, d.x, d.y, d.z, r.unit(), r.unit()]
}

fn judge_sun(x: &[f32], y: &[f32]) -> f64 {
    if y.iter().any(|v| !v.is_finite()) {
        return f64::INFINITY;
    }
    let record = LightRecord { a: [x[3], 0.0, 0.0], b: [x[0], x[1], x[2]], c: [1.0; 3], ..LightRecord::default() };
    let sun = Sun::from_record(&record);
    let wi = vector(y);
    let expected = sun.connect(DVec3::ZERO, [x[7], x[8]].map(f64::from));
    let direction = ratio((wi - expected.wi).length(), 12.0 * EPS);
    // The rim: the angle is off by 4 eps of a unit vector.
    let d = vector(&x[4..]).normalize();
    let angle = d.cross(sun.to_light).length().atan2(d.dot(sun.to_light));
    let is_at_rim = (angle - sun.half_angle_rad).abs() < 4.0 * EPS * (1.0 + sun.half_angle_rad.tan().abs().min(4.0));
    let is_right = is_at_rim || (y[3] == 1.0) == (angle <= sun.half_angle_rad);
    direction.max(if is_right { 0.0 } else { f64::INFINITY })
}

pub fn probes() -> Vec<Probe> {
    let point = "PointView v = point_view(vec3(x0, x1, x2), vec3(x3, x4, x5)); y0 = v.wi.x; y1 = v.wi.y; y2 = v.wi.z; \
        y3 = v.distance; y4 = v.inverse_square; y5 = v.is_apart ? 1.0 : 0.0;";
    let spot = "y0 = spot_one_minus_cos(vec3(x0, x1, x2), vec3(x3, x4, x5)); y1 = spot_falloff(y0, vec3(x6, x7, x8));";
    let sun = "vec3 wi = sun_direction(vec3(x0, x1, x2), x3, vec2(x7, x8)); y0 = wi.x; y1 = wi.y; y2 = wi.z; \
        y3 = sun_holds(vec3(x0, x1, x2), x3, vec3(x4, x5, x6)) ? 1.0 : 0.0;";
    vec![
        Probe::judged("point_view", point, 6, points, judge_point)
            .files(&["light/inverse_square.glsl"])
            .because("direction 6 eps, distance 4 eps, 1/d^2 6 eps; no direction at the light itself"),
        Probe::judged("spot_falloff", spot, 2, spots, judge_spot)
            .files(&["light/spot.glsl"])
            .because("h 5 eps; the share between those of h -+ 2 eps of the record's numbers, and 4 + 4 n |log x| eps"),
        Probe::judged("sun_direction and sun_holds", sun, 4, suns, judge_sun)
            .files(&["light/sun.glsl"])
            .define("HAS_LIGHT_SUN", 0)
            .because("direction 12 eps; inside or outside as in f64 except within 4 eps of the rim"),
    ]
}
