//! A disc light: points uniform in its area.
//!
//! With r^2 the product of the two radii x and y, and h the height of the shaded point over the plane, the density of a direction
//! that meets the disc at the distance d is d^2/(A cos) = d^3/(pi r^2 h). h is one number for all points of the disc, taken from
//! the centre. It is 0 for a point in the plane: no sample, and no light arrives there either. Far away nothing is lost: no
//! solid angle is computed. Near by, weights grow like A h/d^3; multiple importance sampling bounds them, and nothing is clamped.
//! Left out: sampling by solid angle (Guillen et al. 2017), which would need an elliptic integral inverted at each sample.

use std::f64::consts::PI;

use glam::DVec3;

use super::{Connection, Emitter, LIGHT_DISC, Place, Reach, Surroundings, emitted_luminance, kept_positive, vector};
use crate::math::warp;
use crate::prepare::records::{DiscRecord, LightRecord};

pub const REACH: Reach = Reach::Surface(density);
pub const SHARED: &[&str] = &[];

/// A disc: centre and two radii at a right angle, x cross y towards the front.
#[derive(Clone, Copy, Debug)]
pub struct Disc {
    pub center: DVec3,
    pub x: DVec3,
    pub y: DVec3,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiscLightSample {
    pub wi: DVec3,
    pub distance: f64,
    /// 1/sr; 0 means no sample.
    pub pdf: f64,
    pub position: DVec3,
}

/// Density of `sample` in a direction that meets the disc at `distance`, 1/sr.
pub fn pdf(p: DVec3, disc: &Disc, distance: f64) -> f64 {
    let volume = (disc.center - p).dot(disc.x.cross(disc.y)).abs();
    if volume > 0.0 { distance.powi(3) / (PI * volume) } else { 0.0 }
}

/// Concentric map (Shirley and Chiu 1997), as the kernels do.
pub fn sample(p: DVec3, disc: &Disc, u: [f64; 2]) -> DiscLightSample {
    let d = warp::concentric_disk(u);
    let position = disc.center + d.x * disc.x + d.y * disc.y;
    let distance = (position - p).length();
    let wi = if distance > 0.0 { (position - p) / distance } else { DVec3::Z };
    DiscLightSample { wi, distance, pdf: pdf(p, disc, distance), position }
}

/// Row `row` of `Prepared::discs`. Power: pi A L, twice that where both sides emit; `mean_radiance` as for triangles.
pub fn emitter(disc: &DiscRecord, row: u32, mean_radiance: DVec3, two_sided: bool) -> Emitter {
    let (normal, tangent, radius) = (vector(disc.normal), vector(disc.tangent), f64::from(disc.radius));
    let vec = |v: DVec3| v.as_vec3().to_array();
    let record = LightRecord {
        kind: LIGHT_DISC,
        a: disc.center,
        b: vec(radius * tangent),
        c: vec(radius * normal.cross(tangent)),
        material: disc.material,
        shape: row,
        ..LightRecord::default()
    };
    let luminance = emitted_luminance(mean_radiance);
    let emits = radius > 0.0 && radius.is_finite() && disc.center.iter().all(|x| x.is_finite()) && luminance > 0.0;
    let sides = if two_sided { 2.0 } else { 1.0 };
    let power = kept_positive(sides * PI * PI * radius * radius * luminance, true);
    Emitter { record, power: if emits { power } else { 0.0 }, is_distant: false }
}

fn of(light: &LightRecord) -> Disc {
    Disc { center: vector(light.a), x: vector(light.b), y: vector(light.c) }
}

pub fn connect(world: &dyn Surroundings, light: &LightRecord, p: DVec3, u: [f64; 2]) -> Connection {
    let disc = of(light);
    let s = sample(p, &disc, u);
    let is_front = s.wi.dot(disc.x.cross(disc.y)) < 0.0;
    let radiance = world.emission(light.material, Place::Disc(light.shape, s.position), is_front);
    let primitive = world.prepared().discs[light.shape as usize].primitive;
    Connection { wi: s.wi, distance: s.distance, radiance, pdf: s.pdf, primitive }
}

fn density(light: &LightRecord, p: DVec3, _wi: DVec3, distance: f64, _is_front: bool) -> f64 {
    pdf(p, &of(light), distance)
}

/// Solid angle from `p`, sr: midpoints of 2048 rings of equal width and 512 sectors.
pub fn solid_angle(p: DVec3, disc: &Disc) -> f64 {
    let (rings, sectors) = (2048, 512);
    let (mut sum, mut weights) = (0.0, 0.0);
    for ring in 0..rings {
        let r = (f64::from(ring) + 0.5) / f64::from(rings);
        for sector in 0..sectors {
            let (sin, cos) = (2.0 * PI * (f64::from(sector) + 0.5) / f64::from(sectors)).sin_cos();
            let q = disc.center + r * (cos * disc.x + sin * disc.y);
            sum += r / pdf(p, disc, (q - p).length());
            weights += r;
        }
    }
    sum / weights
}

#[cfg(test)]
mod tests {
    use super::*;

    fn level(center: DVec3, radius: f64) -> Disc {
        // Faces down.
        Disc { center, x: radius * DVec3::X, y: -radius * DVec3::Y }
    }

    /// E = pi L F of a parallel disc (Siegel and Howell), a off its axis and h above.
    fn form_factor(radius: f64, h: f64, a: f64) -> f64 {
        let (h2, a2, r2) = (h * h, a * a, radius * radius);
        0.5 * (1.0 - (h2 + a2 - r2) / ((h2 + a2 + r2).powi(2) - 4.0 * a2 * r2).sqrt())
    }

    #[test]
    fn irradiance_is_pi_l_times_the_form_factor() {
        for (radius, h, a) in [(0.5, 2.0, 0.0), (0.6, 0.9, 1.1), (1.0, 0.2, 0.7), (1e-3, 5.0, 2.0)] {
            let disc = level(DVec3::new(a, 0.0, h), radius);
            let n = 512;
            let mut sum = 0.0;
            for i in 0..n * n {
                let u = [(f64::from(i / n) + 0.5) / f64::from(n), (f64::from(i % n) + 0.5) / f64::from(n)];
                let s = sample(DVec3::ZERO, &disc, u);
                assert!((s.wi.length() - 1.0).abs() < 1e-12 && (s.position - s.distance * s.wi).length() < 1e-12);
                assert_eq!(s.pdf, pdf(DVec3::ZERO, &disc, s.distance));
                sum += s.wi.z / s.pdf / f64::from(n * n);
            }
            let exact = PI * form_factor(radius, h, a);
            assert!((sum / exact - 1.0).abs() < 2e-5, "{radius} {h} {a}: {sum} {exact}");
        }
    }

    #[test]
    fn the_solid_angle_on_the_axis_is_that_of_a_cone() {
        for (radius, h) in [(1.0, 0.1), (1.0, 1.0), (0.01, 3.0), (1e-9, 1.0)] {
            let cone: f64 = 2.0 * PI * radius * radius / (h * h + radius * radius + h * (h * h + radius * radius).sqrt());
            let found = solid_angle(DVec3::ZERO, &level(DVec3::Z * h, radius));
            assert!((found / cone - 1.0).abs() < 1e-5, "{radius} {h}: {found} {cone}");
        }
        assert_eq!(pdf(DVec3::ZERO, &level(DVec3::X, 0.5), 1.0), 0.0);
    }
}
