//! The perspective camera: a pinhole that looks along -z of its own frame, y up, with a vertical field of view.
//!
//! Through film position (x, y) in pixels, row 0 on top: d = forward + (2x/W - 1) right + (1 - 2y/H) up, normalised, where
//! |up| = tan(fov_y/2) and |right| = tan(fov_y/2) W/H. Scale and shear of the author's transform are no part of the view.
//! GLSL twin: shaders/camera/perspective.glsl, held to `direction` by gate 6.

use glam::{DVec2, DVec3};

use crate::prepare::records::{CameraRecord, NONE};
use crate::scene::{Camera, Film};

/// The record of `camera` for an image of the film's size; its medium is left NONE. The error says what is wrong with the camera.
pub fn record(camera: &Camera, film: &Film) -> Result<CameraRecord, &'static str> {
    if !camera.to_world.is_finite() {
        return Err("transform is not finite");
    }
    if !(camera.fov_y_rad > 0.0 && camera.fov_y_rad < std::f64::consts::PI) {
        return Err("field of view is out of range");
    }
    let axes = camera.to_world.matrix3;
    let (forward, up) = ((-axes.z_axis).normalize_or_zero(), axes.y_axis.normalize_or_zero());
    let right = forward.cross(up).normalize_or_zero();
    if forward == DVec3::ZERO || right == DVec3::ZERO {
        return Err("axes are degenerate");
    }
    let up = right.cross(forward);
    let size = DVec2::new(film.width.into(), film.height.into());
    let half_height = (camera.fov_y_rad * 0.5).tan();
    Ok(CameraRecord {
        forward: forward.as_vec3().to_array(),
        inv_width: (2.0 / size.x) as f32,
        right: (right * half_height * size.x / size.y).as_vec3().to_array(),
        inv_height: (2.0 / size.y) as f32,
        up: (up * half_height).as_vec3().to_array(),
        medium: NONE,
    })
}

/// Unit direction through `film`, in pixels.
pub fn direction(camera: &CameraRecord, film: DVec2) -> DVec3 {
    let vec = |v: [f32; 3]| DVec3::from(v.map(f64::from));
    let x = film.x * f64::from(camera.inv_width) - 1.0;
    let y = 1.0 - film.y * f64::from(camera.inv_height);
    (vec(camera.forward) + x * vec(camera.right) + y * vec(camera.up)).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DAffine3, DMat3};

    const FILM: Film = Film { width: 400, height: 200, spp: None, max_depth: None };

    /// `axes`: right, up, back.
    fn camera(axes: DMat3, fov_y_deg: f64) -> Camera {
        let to_world = DAffine3 { matrix3: axes, translation: DVec3::new(5.0, 6.0, 7.0) };
        Camera { to_world, fov_y_rad: fov_y_deg.to_radians(), ..Camera::default() }
    }

    #[test]
    fn the_middle_looks_forward_and_the_edges_span_the_field_of_view() {
        // Scaled axes: only their directions count.
        let record = record(&camera(DMat3::from_diagonal(DVec3::new(3.0, 0.5, 2.0)), 60.0), &FILM).unwrap();
        let close = |a: DVec3, b: DVec3| assert!((a - b.normalize()).length() < 1e-7, "{a} {b}");
        let tan = 30f64.to_radians().tan();
        close(direction(&record, DVec2::new(200.0, 100.0)), DVec3::NEG_Z);
        close(direction(&record, DVec2::new(200.0, 0.0)), DVec3::new(0.0, tan, -1.0));
        close(direction(&record, DVec2::new(200.0, 200.0)), DVec3::new(0.0, -tan, -1.0));
        close(direction(&record, DVec2::new(400.0, 0.0)), DVec3::new(2.0 * tan, tan, -1.0));
    }

    #[test]
    fn cameras_that_show_nothing_are_refused() {
        let nan = camera(DMat3::from_diagonal(DVec3::new(1.0, f64::NAN, 1.0)), 60.0);
        let flat = camera(DMat3::from_cols(DVec3::X, DVec3::Z, DVec3::Z), 60.0);
        let none = camera(DMat3::IDENTITY, 0.0);
        let half_turn = camera(DMat3::IDENTITY, 180.0);
        for (camera, word) in [(nan, "finite"), (flat, "degenerate"), (none, "field"), (half_turn, "field")] {
            assert!(record(&camera, &FILM).unwrap_err().contains(word), "{camera:?}");
        }
    }
}
