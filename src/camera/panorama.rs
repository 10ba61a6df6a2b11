//! The panorama: all directions about the camera as a lat-long picture, laid out as the sky's is.
//!
//! u = x/W runs from left to right, its middle along the view and its right half to the right: longitude 2 pi (u - 1/2); v = y/H is
//! the angle from up over pi. With the view along -z and up +y a panorama is a sky that `--env` takes as it is.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};

use super::{Model, Start, View, axes, on_plane, plane, vec};
use crate::prepare::records::CameraRecord;
use crate::sampler::Purpose;
use crate::scene::{Camera, Film, Projection};

/// `type = "panorama"`: no parameters but its place and direction.
pub const MODEL: Model = Model {
    keyword: "panorama",
    is_meter: false,
    receives: false,
    has_elements: false,
    claims: |p| matches!(p, Projection::Panorama),
    record,
    start,
};

fn record(camera: &Camera, film: &Film) -> Result<CameraRecord, String> {
    let [forward, right, up] = axes(camera)?;
    Ok(plane(forward, right, up, film))
}

fn start(view: &View, film: DVec2, _: &dyn Fn(Purpose) -> u32) -> Start {
    let camera = view.camera;
    let at = on_plane(camera, film);
    let (sin_longitude, cos_longitude) = (PI * at.x).sin_cos();
    // Latitude from -pi/2 at the lower edge to pi/2 at the upper.
    let (sin_latitude, cos_latitude) = (0.5 * PI * at.y).sin_cos();
    let level: DVec3 = sin_longitude * vec(camera.right) + cos_longitude * vec(camera.forward);
    Start::ray(DVec3::ZERO, (cos_latitude * level + sin_latitude * vec(camera.up)).normalize())
}
