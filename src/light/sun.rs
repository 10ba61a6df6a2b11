//! A directional light with a size: a disc infinitely far away of half angle a and uniform radiance L, given by its perpendicular
//! irradiance E = pi L sin^2(a) (the cosine-weighted solid angle of a cone). Sampled uniformly in solid angle, 2 pi (1 - cos a);
//! rays that leave the scene see it. The Sun: 0.533 degrees across. GLSL: shaders/light/sun.glsl.

use std::f64::consts::PI;

use glam::{DAffine3, DVec3};

use super::lamp::LampModel;
use super::spot::one_minus_cos;
use super::{Arriving, Connection, LIGHT_SUN, Reach, vector};
use crate::math::frame::Frame;
use crate::math::warp;
use crate::prepare::Prepared;
use crate::prepare::records::{LightRecord, NONE};

pub const REACH: Reach = Reach::Infinity(arriving);
pub const SHARED: &[&str] = &[];

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sun {
    /// Unit, towards its middle.
    pub to_light: DVec3,
    /// Perpendicular to it, W/m2.
    pub irradiance: DVec3,
    /// In (0, pi/2].
    pub half_angle_rad: f64,
}

impl Sun {
    /// W/(m2 sr).
    pub fn radiance(&self) -> DVec3 {
        self.irradiance / (PI * self.half_angle_rad.sin().powi(2))
    }

    fn density(&self) -> f64 {
        warp::uniform_cone_pdf(one_minus_cos(self.half_angle_rad))
    }
}

impl LampModel for Sun {
    fn power(&self, scene_radius: f64) -> DVec3 {
        PI * scene_radius * scene_radius * self.irradiance
    }

    fn is_distant(&self) -> bool {
        true
    }

    fn record(&self, _origin: DVec3) -> LightRecord {
        LightRecord {
            a: [one_minus_cos(self.half_angle_rad) as f32, 0.0, 0.0],
            b: self.to_light.as_vec3().to_array(),
            c: self.radiance().as_vec3().to_array(),
            ..LightRecord::default()
        }
    }

    fn from_record(light: &LightRecord) -> Self {
        let half_angle_rad = 2.0 * (0.5 * f64::from(light.a[0])).sqrt().asin();
        let irradiance = PI * half_angle_rad.sin().powi(2) * vector(light.c);
        Self { to_light: vector(light.b).normalize_or(DVec3::Y), irradiance, half_angle_rad }
    }

    fn place(&mut self, to_world: &DAffine3) {
        self.to_light = to_world.transform_vector3(self.to_light).normalize_or(self.to_light);
    }

    fn brighten(&mut self, factor: f64) {
        self.irradiance *= factor;
    }

    fn connect(&self, _p: DVec3, u: [f64; 2]) -> Connection {
        let local = warp::uniform_cone(u, one_minus_cos(self.half_angle_rad));
        let wi = Frame::from_normal(self.to_light).to_world(local);
        let radiance = self.radiance();
        Connection { wi, distance: f64::INFINITY, radiance, pdf: self.density(), primitive: NONE }
    }

    fn arriving(&self, direction: DVec3) -> (DVec3, f64) {
        let angle = direction.cross(self.to_light).length().atan2(direction.dot(self.to_light));
        if angle <= self.half_angle_rad { (self.radiance(), self.density()) } else { (DVec3::ZERO, 0.0) }
    }
}

fn arriving(p: &Prepared, direction: DVec3, visit: &mut Arriving) {
    for (row, light) in (0..).zip(&p.lights).filter(|(_, l)| l.kind == LIGHT_SUN) {
        let (radiance, density) = Sun::from_record(light).arriving(direction);
        if radiance != DVec3::ZERO {
            visit(radiance, row, density);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn its_irradiance_is_what_was_given() {
        for half_angle_rad in [1e-4, 0.2665f64.to_radians(), 0.5, 0.5 * PI] {
            let sun = Sun { to_light: DVec3::Z, irradiance: DVec3::splat(7.0), half_angle_rad };
            // Mean of L cos/pdf over a grid; cos is linear in u0, so that midpoints are exact.
            let n = 64;
            let mut sum = 0.0;
            for i in 0..n * n {
                let u = [(f64::from(i / n) + 0.5) / f64::from(n), (f64::from(i % n) + 0.5) / f64::from(n)];
                let c = sun.connect(DVec3::ZERO, u);
                assert_eq!(sun.arriving(c.wi), (c.radiance, c.pdf));
                sum += c.radiance.x * c.wi.z / c.pdf / f64::from(n * n);
            }
            assert!((sum / 7.0 - 1.0).abs() < 1e-9, "{half_angle_rad} {sum}");
            let back = Sun::from_record(&sun.record(DVec3::ZERO));
            assert!((back.irradiance.x / 7.0 - 1.0).abs() < 1e-6);
        }
    }
}
