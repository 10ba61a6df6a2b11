//! A sphere light: directions uniform in the cone it fills; from inside, uniform over all directions.
//!
//! With s = r/d, everything is written in h = 1 - cos(theta_max) = s^2 / (1 + sqrt(1 - s^2)), which keeps its digits for a far
//! sphere (Shirley, Wang and Zimmerman 1996 for the cone; the rearrangement is this project's). The near hit is the product
//! of the roots over the far one, so that a point next to the surface gets a true distance.
//! From outside every point of the sphere that is seen shows its front; from inside its back: `is_outside`.

use std::f64::consts::{FRAC_1_PI, PI, TAU};

use glam::DVec3;

use super::{Connection, Emitter, LIGHT_SPHERE, Place, Reach, Surroundings, emitted_luminance, kept_positive, vector};
use crate::prepare::records::LightRecord;

pub const REACH: Reach = Reach::Surface(density);
pub const SHARED: &[&str] = &[];

/// A point on the sphere as seen from `p`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SphereLightSample {
    pub wi: DVec3,
    /// To the first surface point along `wi`.
    pub distance: f64,
    /// 1/sr; 0 means no sample.
    pub pdf: f64,
}

pub fn is_outside(p: DVec3, center: DVec3, radius: f64) -> bool {
    (center - p).length() > radius
}

/// 1 - cos of the cone's half angle, for `sin2` = (r/d)^2.
fn cone_height(sin2: f64) -> f64 {
    sin2 / (1.0 + (1.0 - sin2).max(0.0).sqrt())
}

/// Density of `sample` in any direction that meets the sphere, 1/sr.
pub fn pdf(p: DVec3, center: DVec3, radius: f64) -> f64 {
    let d = (center - p).length();
    if d <= radius {
        return 0.25 * FRAC_1_PI;
    }
    let h = cone_height((radius / d) * (radius / d));
    if h > 0.0 { 1.0 / (TAU * h) } else { 0.0 }
}

pub fn sample(p: DVec3, center: DVec3, radius: f64, u: [f64; 2]) -> SphereLightSample {
    let to_center = center - p;
    let d = to_center.length();
    let (sin_phi, cos_phi) = (TAU * u[1]).sin_cos();
    if d <= radius {
        let z = 1.0 - 2.0 * u[0];
        let r = 2.0 * (u[0] * (1.0 - u[0])).sqrt();
        let wi = DVec3::new(r * cos_phi, r * sin_phi, z);
        let along = wi.dot(to_center);
        let distance = along + (along * along + (radius - d) * (radius + d)).max(0.0).sqrt();
        return SphereLightSample { wi, distance, pdf: 0.25 * FRAC_1_PI };
    }
    let h = cone_height((radius / d) * (radius / d));
    let cos_theta = 1.0 - u[0] * h;
    let sin_theta = (u[0] * h * (2.0 - u[0] * h)).sqrt();
    let w = to_center / d;
    let (t, b) = basis(w);
    let wi = sin_theta * cos_phi * t + sin_theta * sin_phi * b + cos_theta * w;
    // The half chord, r sqrt(1 - sin^2/sin_max^2), with the difference taken by hand.
    let half_chord = radius * ((1.0 - u[0]) * (2.0 - h * (1.0 + u[0])) / (2.0 - h)).max(0.0).sqrt();
    let distance = (d - radius) * (d + radius) / (d * cos_theta + half_chord);
    SphereLightSample { wi, distance, pdf: if h > 0.0 { 1.0 / (TAU * h) } else { 0.0 } }
}

/// Two unit vectors that complete `n` to a right-handed frame (Duff et al. 2017).
fn basis(n: DVec3) -> (DVec3, DVec3) {
    let sign = 1f64.copysign(n.z);
    let a = -1.0 / (sign + n.z);
    let b = n.x * n.y * a;
    (DVec3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x), DVec3::new(b, sign + n.y * n.y * a, -n.y))
}

/// Solid angle of the sphere from outside, sr.
pub fn solid_angle(p: DVec3, center: DVec3, radius: f64) -> f64 {
    let d = (center - p).length();
    if d <= radius { 4.0 * PI } else { TAU * cone_height((radius / d) * (radius / d)) }
}

/// Row `sphere` of `Prepared::spheres`. Power: 4 pi^2 r^2 L, twice that where both sides emit; see `triangle::emitter`.
pub fn emitter(
    center: [f32; 3],
    radius: f32,
    sphere: u32,
    material: u32,
    mean_radiance: DVec3,
    two_sided: bool,
) -> Emitter {
    let r = f64::from(radius);
    let luminance = emitted_luminance(mean_radiance);
    let emits = r > 0.0 && r.is_finite() && center.iter().all(|x| x.is_finite()) && luminance > 0.0;
    let sides = if two_sided { 2.0 } else { 1.0 };
    let b = [radius, 0.0, 0.0];
    let record = LightRecord { kind: LIGHT_SPHERE, a: center, b, material, shape: sphere, ..LightRecord::default() };
    Emitter { record, power: if emits { kept_positive(sides * 4.0 * PI * PI * r * r * luminance, true) } else { 0.0 }, is_distant: false }
}

pub fn connect(world: &dyn Surroundings, light: &LightRecord, p: DVec3, u: [f64; 2]) -> Connection {
    let (center, radius) = (vector(light.a), f64::from(light.b[0]));
    let s = sample(p, center, radius, u);
    let normal = (p + s.distance * s.wi - center).normalize();
    let is_front = is_outside(p, center, radius);
    let radiance = world.emission(light.material, Place::Sphere(light.shape, normal), is_front);
    let primitive = world.prepared().spheres[light.shape as usize].primitive;
    Connection { wi: s.wi, distance: s.distance, radiance, pdf: s.pdf, primitive }
}

fn density(light: &LightRecord, p: DVec3, _wi: DVec3, _distance: f64, is_front: bool) -> f64 {
    let (center, radius) = (vector(light.a), f64::from(light.b[0]));
    // The side that the point does not see: reached through the sphere itself, which light sampling does not try.
    if is_outside(p, center, radius) == is_front { pdf(p, center, radius) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn directions(n: u32) -> impl Iterator<Item = DVec3> {
        (0..n).map(move |i| {
            let z = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(n);
            let phi = f64::from(i) * 2.399963229728653;
            let r = (1.0 - z * z).sqrt();
            DVec3::new(r * phi.cos(), r * phi.sin(), z)
        })
    }

    #[test]
    fn samples_lie_on_the_sphere_and_in_the_density_from_near_to_far() {
        let center = DVec3::new(0.3, -2.0, 5.0);
        for ratio in [0.0, 0.5, 1.0, 1.0 + 1e-6, 1.001, 2.0, 100.0, 1e6] {
            for dir in directions(17) {
                let (radius, p) = (0.7, center + 0.7 * ratio * dir);
                for i in 0..64u32 {
                    let u = [f64::from(i) / 64.0, (f64::from(i) * 0.618034).fract()];
                    let s = sample(p, center, radius, u);
                    assert!((s.wi.length() - 1.0).abs() < 1e-12);
                    let q = p + s.distance * s.wi;
                    let bound = 1e-9 * radius * ratio.max(1.0);
                    assert!(((q - center).length() - radius).abs() < bound, "{ratio} {u:?} {}", (q - center).length());
                    assert!(s.distance >= 0.0 && s.distance <= (center - p).length() + radius);
                    assert_eq!(s.pdf, pdf(p, center, radius));
                    assert!((s.pdf * solid_angle(p, center, radius) - 1.0).abs() < 1e-12);
                }
            }
        }
    }

    #[test]
    fn the_cone_keeps_its_digits_far_away() {
        // 1 - sqrt(1 - s^2) = s^2/2 + s^4/8 + ...
        for s in [1e-3f64, 1e-6, 1e-9, 1e-30] {
            let series = s * s / 2.0 + s.powi(4) / 8.0 + s.powi(6) / 16.0;
            assert!((cone_height(s * s) / series - 1.0).abs() < 1e-15);
        }
        assert_eq!(pdf(DVec3::ZERO, DVec3::Z, 0.0), 0.0);
    }

    #[test]
    fn irradiance_is_pi_l_over_d_squared() {
        // E = pi L (R/d)^2 cos by the mean of cos/pdf; stratified, so the error is far below the bound.
        let (p, radius) = (DVec3::ZERO, 0.5);
        for center in [DVec3::new(0.0, 0.0, 2.0), DVec3::new(1.0, 0.4, 0.8)] {
            let n = 512;
            let mut sum = 0.0;
            for i in 0..n * n {
                let u = [(f64::from(i / n) + 0.5) / f64::from(n), (f64::from(i % n) + 0.5) / f64::from(n)];
                let s = sample(p, center, radius, u);
                sum += s.wi.z / s.pdf / f64::from(n * n);
            }
            let d = center.length();
            let exact = PI * (radius / d).powi(2) * center.z / d;
            assert!((sum / exact - 1.0).abs() < 1e-5, "{sum} {exact}");
        }
    }
}
