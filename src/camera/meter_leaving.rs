//! The exitance meter: what leaves one side of shapes, emitted and reflected, the mean over their area, W/m2. Times the area it is
//! the flux that leaves, W.
//!
//! A point and a direction as for `meter_surface`, but the ray runs against the direction and looks at the surface from just above
//! that point: pi times the radiance that it meets estimates M = integral of L cos over the hemisphere.

use std::f64::consts::PI;

use glam::DVec2;

use super::{Model, Start, View, meter_point, meter_surface};
use crate::sampler::Purpose;
use crate::scene::Projection;

pub const MODEL: Model = Model {
    keyword: "meter_leaving",
    is_meter: true,
    receives: false,
    has_elements: true,
    claims: |p| matches!(p, Projection::MeterLeaving(_)),
    record: meter_surface::record,
    start,
};

fn start(view: &View, _: DVec2, word: &dyn Fn(Purpose) -> u32) -> Start {
    let (origin, normal, weight) = meter_surface::place(view, word);
    Start { origin, direction: -meter_point::hemisphere(normal, word), weight: PI * weight, receiver: None }
}
