//! Rows of the cameras in gates 6 and 7: one scene a camera, replayed path by path and compared with the independent oracle.
//!
//! `perspective` is the camera of every other scene. The meters' rows are their closed forms (reference/meters.rs).

use glam::DVec3;

use crate::reference::known::camera;
use crate::reference::scenes;
use crate::scene::{Camera, Projection, Scene};

/// Keyword of the camera, and how it looks at the Cornell box.
const ROWS: &[(&str, fn() -> Camera)] = &[
    ("thin_lens", || Camera {
        // A wide opening, focused on the blocks: lamp and back are blurred.
        projection: Projection::ThinLens { fov_y_rad: 0.66, lens_radius: 0.3, focus_distance: Some(3.6) },
        ..camera(DVec3::new(0.0, 1.0, 3.9), DVec3::Y, 0.66)
    }),
    ("orthographic", || Camera {
        projection: Projection::Orthographic { half_width: 0.0, half_height: 1.1 },
        ..camera(DVec3::new(0.9, 1.6, 2.0), DVec3::new(0.0, 1.0, 0.0), 0.66)
    }),
    ("panorama", || Camera {
        projection: Projection::Panorama,
        ..camera(DVec3::new(0.2, 1.3, 0.6), DVec3::new(0.5, 1.0, -1.0), 0.66)
    }),
];

/// The scene of the thin lens.
pub fn thin_lens(size: u32) -> Scene {
    scenes(size).swap_remove(0)
}

/// The scenes of the rows, `size` pixels square.
pub fn scenes(size: u32) -> Vec<Scene> {
    let scene = |(keyword, camera): &(&str, fn() -> Camera)| Scene {
        name: format!("camera {keyword}"),
        camera: camera(),
        ..scenes::cornell(size)
    };
    ROWS.iter().map(scene).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::{MODELS, kind};

    #[test]
    fn every_camera_has_a_row() {
        let rows: Vec<usize> = scenes(8).iter().map(|s| kind(&s.camera.projection)).collect();
        for (number, model) in MODELS.iter().enumerate() {
            let is_covered = model.is_meter || model.keyword == "perspective" || rows.contains(&number);
            assert!(is_covered, "{}: add a row to conform/camera.rs", model.keyword);
        }
    }
}
