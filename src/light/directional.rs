//! A directional light: parallel light from infinitely far away, given by its perpendicular irradiance E [W/m2]; radiance would be
//! a delta distribution. A Lambert surface of albedo rho under the angle theta shows rho E cos(theta)/pi. Its power is what falls on
//! the disc of the scene, pi R^2 E. With a size it is a `sun`. GLSL: shaders/light/directional.glsl.

use std::f64::consts::PI;

use glam::{DAffine3, DVec3};

use super::lamp::LampModel;
use super::{Connection, Reach, vector};
use crate::prepare::records::{LightRecord, NONE};

pub const REACH: Reach = Reach::Nowhere;
pub const SHARED: &[&str] = &[];

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Directional {
    /// Unit.
    pub to_light: DVec3,
    /// Perpendicular to it, W/m2.
    pub irradiance: DVec3,
}

impl LampModel for Directional {
    fn power(&self, scene_radius: f64) -> DVec3 {
        PI * scene_radius * scene_radius * self.irradiance
    }

    fn is_distant(&self) -> bool {
        true
    }

    fn record(&self, _origin: DVec3) -> LightRecord {
        let (b, c) = (self.to_light.as_vec3().to_array(), self.irradiance.as_vec3().to_array());
        LightRecord { b, c, ..LightRecord::default() }
    }

    fn from_record(light: &LightRecord) -> Self {
        Self { to_light: vector(light.b).normalize_or(DVec3::Y), irradiance: vector(light.c) }
    }

    fn place(&mut self, to_world: &DAffine3) {
        self.to_light = to_world.transform_vector3(self.to_light).normalize_or(self.to_light);
    }

    fn brighten(&mut self, factor: f64) {
        self.irradiance *= factor;
    }

    fn connect(&self, _p: DVec3, _u: [f64; 2]) -> Connection {
        Connection {
            wi: self.to_light,
            distance: f64::INFINITY,
            radiance: self.irradiance,
            pdf: 1.0,
            primitive: NONE,
        }
    }
}
