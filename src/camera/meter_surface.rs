//! The irradiance meter over a surface: what arrives at one side of shapes, the mean over their area, W/m2. Times the area it is the
//! flux that arrives, W.
//!
//! An element (triangle or sphere) is chosen by area, a point on it uniformly, a direction with density cos/pi about its normal.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};

use super::{Model, Start, View, meter_point, plane, vec};
use crate::math::warp;
use crate::prepare::records::{CameraRecord, HIT_DISC, HIT_SPHERE};
use crate::sampler::{self, Purpose};
use crate::scene::{Camera, Film, Projection};

pub const MODEL: Model = Model {
    keyword: "meter_surface",
    is_meter: true,
    receives: true,
    has_elements: true,
    claims: |p| matches!(p, Projection::MeterSurface(_)),
    record,
    start,
};

/// How far from the surface rays start, in parts of the largest coordinate and extent: above the error of points that instances
/// or other f32 arithmetic place, below anything measured.
const LIFT: f64 = 4e-6;

/// `meter_leaving` has the same: everything it reads is in the elements.
pub(super) fn record(_: &Camera, film: &Film) -> Result<CameraRecord, String> {
    Ok(plane(DVec3::NEG_Z, DVec3::X, DVec3::Y, film))
}

fn start(view: &View, _: DVec2, word: &dyn Fn(Purpose) -> u32) -> Start {
    let (origin, normal, weight) = place(view, word);
    Start { origin, direction: meter_point::hemisphere(normal, word), weight: PI * weight, receiver: Some(normal) }
}

/// A point beside the surface, the normal of the measured side, and the share by which the choice of the element missed its area.
pub(super) fn place(view: &View, word: &dyn Fn(Purpose) -> u32) -> (DVec3, DVec3, f64) {
    let element = &view.elements[view.choose(word(sampler::SENSOR_INDEX), word(sampler::SENSOR_FRACTION))];
    let u = [sampler::u01(word(sampler::LENS_U)), sampler::u01(word(sampler::LENS_V))];
    let (a, b, c) = (vec(element.a), vec(element.b), vec(element.c));
    let (point, normal, size) = if element.kind == HIT_SPHERE {
        let normal = warp::uniform_sphere(u);
        (a + b.x * normal, normal, b.x)
    } else if element.kind == HIT_DISC {
        let d = warp::concentric_disk(u);
        (a + d.x * b + d.y * c, b.cross(c).normalize(), b.abs().max(c.abs()).max_element())
    } else {
        let [b1, b2] = warp::uniform_triangle(u);
        let (e1, e2) = (b - a, c - a);
        (a + b1 * e1 + b2 * e2, e1.cross(e2).normalize(), e1.abs().max_element().max(e2.abs().max_element()))
    };
    let normal = normal * f64::from(element.side);
    let lift = LIFT * (point.abs().max_element() + size);
    (point + lift * normal, normal, element.weight.into())
}
