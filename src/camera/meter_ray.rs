//! The radiance meter: the radiance that arrives along one ray, W/(m2 sr). It looks along -z of its frame.

use glam::{DVec2, DVec3};

use super::{Model, Start, View, axes, plane, vec};
use crate::prepare::records::CameraRecord;
use crate::sampler::Purpose;
use crate::scene::{Camera, Film, Projection};

pub const MODEL: Model = Model {
    keyword: "meter_ray",
    is_meter: true,
    receives: false,
    has_elements: false,
    claims: |p| matches!(p, Projection::MeterRay),
    record,
    start,
};

/// `meter_point` has the same: `forward` is all that is read.
pub(super) fn record(camera: &Camera, film: &Film) -> Result<CameraRecord, String> {
    let [forward, right, up] = axes(camera)?;
    Ok(plane(forward, right, up, film))
}

fn start(view: &View, _: DVec2, _: &dyn Fn(Purpose) -> u32) -> Start {
    Start::ray(DVec3::ZERO, vec(view.camera.forward).normalize())
}
