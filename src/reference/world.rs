//! What the path loop asks of a scene, and of the numbers that drive a sample: `replay` and `independent` answer.

use glam::{DVec2, DVec3};

use super::nested::{Inside, Medium};
use super::surface::Surface;
use super::tree::{Hit, Ray, Tree};
use crate::camera::Start;
use crate::integrator::Estimator;
use crate::sampler::Purpose;

/// Where the numbers of one sample come from.
pub trait Random {
    fn bits(&self, vertex: u32, purpose: Purpose) -> u32;
    /// In [0, 1).
    fn unit(&self, vertex: u32, purpose: Purpose) -> f64;
    /// True with probability `p`.
    fn accepts(&self, vertex: u32, purpose: Purpose, p: f64) -> bool;
    /// True with probability `p`, by a hash of the hit and not of the order of visits.
    fn is_present(&self, vertex: u32, kind: RayKind, hit: &Hit, p: f64) -> bool;
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RayKind {
    Closest = 0,
    Shadow = 1,
}

/// What a light sample says.
#[derive(Clone, Copy, Debug)]
pub struct LightSample {
    /// Unit, from the shaded point.
    pub direction: DVec3,
    /// Infinite for the sky.
    pub distance: f64,
    pub radiance: DVec3,
    /// Probability of the light times the solid-angle density of the direction, 1/sr.
    pub density: f64,
    /// The light has no size: `density` is the probability of the light, `radiance` the irradiance perpendicular to `direction`.
    pub is_delta: bool,
    /// The light's own primitive, which its shadow ray ignores; NONE for the sky.
    pub primitive: u32,
    /// Number of its light group.
    pub group: u32,
}

/// What the scene is, to the loop.
pub trait World: Sync {
    type Stream: Random;
    /// Width and height of the image in pixels.
    fn size(&self) -> [u32; 2];
    /// The numbers of one sample of a pixel.
    fn stream(&self, seed: u32, pixel: [u32; 2], sample: u64) -> Self::Stream;
    /// Offset from a pixel's centre, in pixels, of the pixel filter's share `u`.
    fn filter_offset(&self, u: f64) -> f64;
    /// The start of a sample through a film position in pixels, row 0 on top.
    fn camera_start(&self, film: DVec2, random: &Self::Stream) -> Start;
    /// Diameter of a pixel's ray cone where rays start, m, and its growth a metre.
    fn camera_cone(&self) -> DVec2;
    /// The media the camera stands in.
    fn camera_inside(&self) -> Inside;
    /// Bodies of media may overlap.
    fn nests(&self) -> bool;
    /// The medium behind a primitive's surface, where it bounds one that may nest.
    fn boundary_medium(&self, primitive: u32) -> Option<u32>;
    fn tree(&self) -> &Tree;
    /// Some hit may be passed through.
    fn has_alpha(&self) -> bool;
    /// Probability that the surface is there.
    fn presence(&self, ray: &Ray, hit: &Hit) -> f64;
    /// `outside`: index of refraction in front of the surface, by which its own indices are divided.
    fn surface(&self, ray: &Ray, hit: &Hit, outside: f64) -> Surface;
    fn medium(&self, medium: u32) -> Medium;
    /// Gives each light that a ray leaving the scene sees: its radiance, the density with which `sample_light` finds it in this
    /// direction, 1/sr, and its light group.
    fn background(&self, direction: DVec3, visit: &mut dyn FnMut(DVec3, f64, u32));
    /// Density with which `sample_light` from `ray.origin` finds the emission at `hit`, 1/sr.
    fn emitter_density(&self, ray: &Ray, hit: &Hit) -> f64;
    fn sample_light(
        &self,
        point: DVec3,
        random: &Self::Stream,
        vertex: u32,
        estimator: Estimator,
    ) -> Option<LightSample>;
}
