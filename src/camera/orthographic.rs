//! The orthographic camera: parallel rays along the view, from a rectangle about the camera's position.
//!
//! Through film position (x, y) in pixels a ray starts at (2x/W - 1) right + (1 - 2y/H) up. What is behind that plane is not seen.
//! Pixels are square: the rectangle is the smallest of the film's shape that holds what the author asked for.

use glam::DVec2;

use super::{Model, Start, View, axes, on_plane, plane, vec};
use crate::prepare::records::CameraRecord;
use crate::sampler::Purpose;
use crate::scene::{Camera, Film, Projection};

/// `type = "orthographic"`: `height` [m] > 0, of what is seen. glTF: `xmag` and `ymag`, half of width and height.
pub const MODEL: Model = Model {
    keyword: "orthographic",
    is_meter: false,
    receives: false,
    has_elements: false,
    claims: |p| matches!(p, Projection::Orthographic { .. }),
    record,
    start,
};

fn record(camera: &Camera, film: &Film) -> Result<CameraRecord, String> {
    let Projection::Orthographic { half_width, half_height } = camera.projection else {
        return Err("the camera has no extent".into());
    };
    let is_extent = |x: f64| (0.0..1e15).contains(&x);
    if !(is_extent(half_width) && is_extent(half_height) && half_width.max(half_height) > 1e-15) {
        return Err("the camera's extent must be above 0, and finite; give it the height that it should show".into());
    }
    let [forward, right, up] = axes(camera)?;
    let aspect = f64::from(film.width) / f64::from(film.height);
    let half_height = half_height.max(half_width / aspect);
    Ok(plane(forward, right * half_height * aspect, up * half_height, film))
}

fn start(view: &View, film: DVec2, _: &dyn Fn(Purpose) -> u32) -> Start {
    let camera = view.camera;
    let at = on_plane(camera, film);
    Start::ray(at.x * vec(camera.right) + at.y * vec(camera.up), vec(camera.forward).normalize())
}
