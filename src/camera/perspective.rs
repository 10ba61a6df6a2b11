//! The perspective camera: a pinhole that looks along -z of its own frame, y up, with a vertical field of view.
//!
//! Through film position (x, y) in pixels, row 0 on top: d = forward + (2x/W - 1) right + (1 - 2y/H) up, normalised, where
//! |up| = tan(fov_y/2) and |right| = tan(fov_y/2) W/H.

use glam::DVec2;

use super::{Model, Start, View, axes, on_plane, plane, vec};
use crate::prepare::records::CameraRecord;
use crate::sampler::Purpose;
use crate::scene::{Camera, Film, Projection};

/// `type = "perspective"`: `fov_y_deg`, in (0, 180), default 40. A lens without a radius is one.
pub const MODEL: Model = Model {
    keyword: "perspective",
    is_meter: false,
    receives: false,
    has_elements: false,
    claims: |p| matches!(p, Projection::Perspective { .. } | Projection::ThinLens { lens_radius: 0.0, .. }),
    record,
    start,
};

/// tan(fov/2) and its product with the aspect stay below: squared lengths of directions are then finite in f32.
const LARGEST_TANGENT: f64 = 1e9;

/// `thin_lens` has the same.
pub(super) fn record(camera: &Camera, film: &Film) -> Result<CameraRecord, String> {
    let (Projection::Perspective { fov_y_rad } | Projection::ThinLens { fov_y_rad, .. }) = camera.projection else {
        return Err("the camera has no field of view".into());
    };
    if !(fov_y_rad > 0.0 && fov_y_rad < std::f64::consts::PI) {
        return Err("the camera's field of view is out of range; give it one between 0 and 180 degrees".into());
    }
    let [forward, right, up] = axes(camera)?;
    let half_height = (fov_y_rad * 0.5).tan();
    let half_width = half_height * f64::from(film.width) / f64::from(film.height);
    if half_height.max(half_width) > LARGEST_TANGENT {
        return Err("the camera's field of view is too near 180 degrees for this film; make it smaller".into());
    }
    Ok(plane(forward, right * half_width, up * half_height, film))
}

fn start(view: &View, film: DVec2, _: &dyn Fn(Purpose) -> u32) -> Start {
    let camera = view.camera;
    let at = on_plane(camera, film);
    let direction = vec(camera.forward) + at.x * vec(camera.right) + at.y * vec(camera.up);
    Start::ray(glam::DVec3::ZERO, direction.normalize())
}
