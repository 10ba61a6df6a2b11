//! A point light: intensity I [W/sr] the same in every direction, I = power / 4 pi; a surface at distance d under the angle theta
//! gets E = I cos(theta)/d^2. It has no size, so that a path never runs into it: light sampling alone finds it, and counts whole.
//! GLSL: shaders/light/point.glsl. Tests: gate 3, closed forms in reference::known.

use std::f64::consts::PI;

use glam::{DAffine3, DVec3};

use super::lamp::LampModel;
use super::{Connection, Reach, vector};
use crate::prepare::records::{LightRecord, NONE};

pub const REACH: Reach = Reach::Nowhere;
pub const SHARED: &[&str] = &["light/inverse_square"];

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    pub position: DVec3,
    /// W/sr.
    pub intensity: DVec3,
}

/// Solid angle of all directions: power over intensity, sr.
pub const SOLID_ANGLE: f64 = 4.0 * PI;

/// How `p` sees a source of this intensity towards it. No sample at the source itself.
pub(super) fn connect_point(position: DVec3, p: DVec3, intensity: impl Fn(DVec3) -> DVec3) -> Connection {
    let to_light = position - p;
    let distance = to_light.length();
    if distance == 0.0 {
        return Connection { wi: DVec3::Z, distance: 0.0, radiance: DVec3::ZERO, pdf: 0.0, primitive: NONE };
    }
    let wi = to_light / distance;
    Connection { wi, distance, radiance: intensity(-wi) / (distance * distance), pdf: 1.0, primitive: NONE }
}

impl LampModel for Point {
    fn power(&self, _scene_radius: f64) -> DVec3 {
        SOLID_ANGLE * self.intensity
    }

    fn is_distant(&self) -> bool {
        false
    }

    fn record(&self, origin: DVec3) -> LightRecord {
        let a = (self.position - origin).as_vec3().to_array();
        LightRecord { a, c: self.intensity.as_vec3().to_array(), ..LightRecord::default() }
    }

    fn from_record(light: &LightRecord) -> Self {
        Self { position: vector(light.a), intensity: vector(light.c) }
    }

    fn place(&mut self, to_world: &DAffine3) {
        self.position = to_world.transform_point3(self.position);
    }

    fn brighten(&mut self, factor: f64) {
        self.intensity *= factor;
    }

    fn connect(&self, p: DVec3, _u: [f64; 2]) -> Connection {
        connect_point(self.position, p, |_| self.intensity)
    }
}
