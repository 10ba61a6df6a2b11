//! The irradiance meter at a point: the light that arrives through the hemisphere about -z of its frame, weighed by the cosine, W/m2.
//!
//! Directions have the density cos/pi, so that pi times the radiance that arrives estimates E = integral of L cos over the
//! hemisphere.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};

use super::{Model, Start, View, meter_ray, vec};
use crate::math::frame::Frame;
use crate::math::warp;
use crate::sampler::{self, Purpose};
use crate::scene::Projection;

pub const MODEL: Model = Model {
    keyword: "meter_point",
    is_meter: true,
    receives: true,
    has_elements: false,
    claims: |p| matches!(p, Projection::MeterPoint),
    record: meter_ray::record,
    start,
};

fn start(view: &View, _: DVec2, word: &dyn Fn(Purpose) -> u32) -> Start {
    let normal = vec(view.camera.forward).normalize();
    let direction = hemisphere(normal, word);
    Start { origin: DVec3::ZERO, direction, weight: PI, receiver: Some(normal) }
}

/// About `normal` with density cos/pi.
pub(super) fn hemisphere(normal: DVec3, word: &dyn Fn(Purpose) -> u32) -> DVec3 {
    let u = [sampler::u01(word(sampler::BSDF_U)), sampler::u01(word(sampler::BSDF_V))];
    Frame::from_normal(normal).to_world(warp::cosine_hemisphere(u))
}
