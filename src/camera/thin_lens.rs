//! The thin lens: the perspective camera with an opening, in focus at one distance (Kolb, Mitchell, Hanrahan 1995, section 2.1,
//! after Potmesil and Chakravarty 1981).
//!
//! Every ray through one film position meets the same point of the plane of focus, at `focus_distance` along the view, and starts
//! at a point of the lens, uniform over its disc. A pixel is the mean radiance over pixel and lens; a lens' fall-off to the
//! edge (cos^4) and its vignetting are left out, as in the pinhole.

use glam::{DVec2, DVec3};

use super::{Model, Start, View, on_plane, perspective, vec};
use crate::math::warp;
use crate::prepare::records::CameraRecord;
use crate::sampler::{self, Purpose};
use crate::scene::{Camera, Film, Projection};

/// `type = "thin_lens"`: `lens_radius` [m] >= 0, default 0, or `f_number` and `focal_length_mm`; `focus_distance` [m] > 0, default the
/// distance to the target. Radius 0 is the perspective camera and compiles as it.
pub const MODEL: Model = Model {
    keyword: "thin_lens",
    is_meter: false,
    receives: false,
    has_elements: false,
    // A radius that is no number is this camera's to refuse.
    claims: |p| matches!(p, Projection::ThinLens { lens_radius, .. } if *lens_radius != 0.0),
    record,
    start,
};

fn record(camera: &Camera, film: &Film) -> Result<CameraRecord, String> {
    let Projection::ThinLens { lens_radius, focus_distance, .. } = camera.projection else {
        return Err("the camera has no lens".into());
    };
    if !(lens_radius > 0.0 && lens_radius.is_finite()) {
        return Err("the camera's lens radius must be 0 or above, and finite".into());
    }
    let focus_distance = focus_distance.unwrap_or(1.0);
    if !(focus_distance > 0.0 && focus_distance.is_finite()) {
        return Err("the camera's focus distance must be above 0, and finite".into());
    }
    let pinhole = perspective::record(camera, film)?;
    let (width, height) = (vec(pinhole.right).length(), vec(pinhole.up).length());
    // In units of the plane's axes, which the record holds already.
    let lens = [lens_radius / width, lens_radius / height].map(|x| x as f32);
    if !lens.iter().all(|x| x.is_finite()) {
        return Err("the camera's field of view is too small for its lens; make it larger".into());
    }
    Ok(CameraRecord { lens, focus_distance: focus_distance as f32, ..pinhole })
}

fn start(view: &View, film: DVec2, word: &dyn Fn(Purpose) -> u32) -> Start {
    let camera = view.camera;
    let (right, up) = (vec(camera.right), vec(camera.up));
    let disk = warp::concentric_disk([sampler::u01(word(sampler::LENS_U)), sampler::u01(word(sampler::LENS_V))]);
    let lens: DVec3 = disk.x * f64::from(camera.lens[0]) * right + disk.y * f64::from(camera.lens[1]) * up;
    let at = on_plane(camera, film);
    let focus = f64::from(camera.focus_distance) * (vec(camera.forward) + at.x * right + at.y * up);
    Start::ray(lens, (focus - lens).normalize())
}
