//! Rows of the cameras and meters in gates 6, 7 and 8: a scene each, replayed path by path, compared with the independent oracle, and
//! specialised against everything-on. `perspective` is the camera of every other scene; the meters have closed forms too
//! (reference/meters.rs).

use glam::DVec3;

use crate::reference::known::camera;
use crate::reference::scenes;
use crate::scene::{Camera, Place, Projection, Quantity, Scene, Sensor, SurfaceMeter};

/// Keyword of the camera, the scene of a size, and how it looks at it.
type Row = (&'static str, fn(u32) -> Scene, fn(&Scene) -> Camera);

const ROWS: &[Row] = &[
    ("thin_lens", scenes::cornell, |_| Camera {
        // A wide opening, focused on the blocks: lamp and back are blurred.
        projection: Projection::ThinLens { fov_y_rad: 0.66, lens_radius: 0.3, focus_distance: Some(3.6) },
        ..camera(DVec3::new(0.0, 1.0, 3.9), DVec3::Y, 0.66)
    }),
    ("orthographic", scenes::cornell, |_| Camera {
        projection: Projection::Orthographic { half_width: 0.0, half_height: 1.1 },
        ..camera(DVec3::new(0.9, 1.6, 2.0), DVec3::new(0.0, 1.0, 0.0), 0.66)
    }),
    ("panorama", scenes::cornell, |_| Camera {
        projection: Projection::Panorama,
        ..camera(DVec3::new(0.2, 1.3, 0.6), DVec3::new(0.5, 1.0, -1.0), 0.66)
    }),
    ("meter_ray", scenes::materials, |scene| {
        let position = DVec3::new(0.0, 1.6, 4.2);
        meter(scene, Place::Ray { position, direction: DVec3::new(0.3, -1.4, -4.0).normalize() })
    }),
    // Lights with and without size, and a sky.
    ("meter_point", scenes::lights::lamps, |scene| {
        meter(
            scene,
            Place::Point { position: DVec3::new(0.3, 0.4, 0.5), normal: DVec3::new(0.2, 0.9, 0.3).normalize() },
        )
    }),
    // Stretched and mirrored meshes with smooth normals and textures.
    ("meter_surface", scenes::textured, |scene| meter(scene, on("stretched", scene, false))),
    ("meter_leaving", scenes::textured, |scene| meter(scene, on("mirrored", scene, true))),
];

fn meter(scene: &Scene, place: Place) -> Camera {
    Sensor { name: "meter".to_owned(), quantity: Quantity::Irradiance, place }.camera(scene)
}

/// The front of the shapes of that name.
fn on(name: &str, scene: &Scene, is_leaving: bool) -> Place {
    let shapes = (0..scene.instances.len()).filter(|&i| scene.instances[i].name == name).collect();
    Place::Surface { meter: SurfaceMeter { shapes, is_back: false }, is_leaving }
}

/// The scene of the thin lens.
pub fn thin_lens(size: u32) -> Scene {
    scenes(size).swap_remove(0)
}

/// The scenes of the rows, `size` pixels square.
pub fn scenes(size: u32) -> Vec<Scene> {
    let scene = |(keyword, scene, camera): &Row| {
        let scene = scene(size);
        Scene { name: format!("camera {keyword}"), camera: camera(&scene), ..scene }
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
            let is_covered = model.keyword == "perspective" || rows.contains(&number);
            assert!(is_covered, "{}: add a row to conform/camera.rs", model.keyword);
        }
    }
}
