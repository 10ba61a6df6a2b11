//! Lights that no surface carries: what each of them answers. The f64 maths take a plain struct of parameters; replay decodes it
//! from the record, the independent oracle takes it from the scene.

use glam::{DAffine3, DVec3};

use super::Connection;
use crate::prepare::records::LightRecord;

/// A light with its parameters, in world coordinates or in those of the records.
pub trait LampModel {
    /// Emitted flux, W. Of a light infinitely far away: what falls on the disc of a scene with this radius.
    fn power(&self, scene_radius: f64) -> DVec3;
    /// Infinitely far away: then its power grows with the scene.
    fn is_distant(&self) -> bool;
    /// The row of `lights` without its kind, in coordinates rebased to `origin`.
    fn record(&self, origin: DVec3) -> LightRecord;
    fn from_record(light: &LightRecord) -> Self
    where
        Self: Sized;
    /// How `p` sees it, with two numbers in [0, 1).
    fn connect(&self, p: DVec3, u: [f64; 2]) -> Connection;
    /// Moves it; a scale changes no light.
    fn place(&mut self, to_world: &DAffine3);
    fn brighten(&mut self, factor: f64);
    /// Radiance along a ray that leaves the scene in this direction, and the density of `connect` there; 0 without a size.
    fn arriving(&self, _direction: DVec3) -> (DVec3, f64) {
        (DVec3::ZERO, 0.0)
    }
}
