//! What a scene gets when its file leaves it out: a camera that frames the model, and a light.
//! Called after flags have had their say, so that nothing given is overwritten.

use glam::{DAffine3, DMat3, DVec3};

use super::{Image, Instance, MAX_RADIANCE, Mesh, Pixels, Projection, Scene, Shape, Sky, SkyRadiance, Value};
use crate::math::special::luminance;

/// Vertices that `bounds` moves one by one; a scene of more has each mesh's box moved instead, which may be somewhat larger.
const MOVED_ONE_BY_ONE: usize = 1 << 23;

/// Axis-aligned bounds of all instances in world space, f64; None when the scene holds no finite point.
pub fn bounds(scene: &Scene) -> Option<(DVec3, DVec3)> {
    let mut low = DVec3::INFINITY;
    let mut high = DVec3::NEG_INFINITY;
    let mut take = |p: DVec3| {
        if p.is_finite() {
            low = low.min(p);
            high = high.max(p);
        }
    };
    let corner_count =
        |i: &Instance| if let Shape::Mesh(mesh) = i.shape { 3 * scene.meshes[mesh].triangles.len() } else { 0 };
    let by_boxes = scene.instances.iter().map(corner_count).sum::<usize>() > MOVED_ONE_BY_ONE;
    let boxes: Vec<Option<(DVec3, DVec3)>> =
        if by_boxes { scene.meshes.iter().map(mesh_bounds).collect() } else { Vec::new() };
    for instance in &scene.instances {
        let m = &instance.to_world;
        match instance.shape {
            Shape::Mesh(mesh) if by_boxes => {
                let Some((low, high)) = boxes[mesh] else { continue };
                for corner in 0..8 {
                    let pick = |axis: usize| if corner >> axis & 1 == 1 { high[axis] } else { low[axis] };
                    take(m.transform_point3(DVec3::new(pick(0), pick(1), pick(2))));
                }
            }
            Shape::Mesh(mesh) => {
                let mesh = &scene.meshes[mesh];
                for index in mesh.triangles.iter().flatten() {
                    let p = mesh.positions[*index as usize];
                    take(m.transform_point3(DVec3::new(p[0].into(), p[1].into(), p[2].into())));
                }
            }
            Shape::Sphere => {
                // Extent of a transformed unit sphere along an axis is the length of that row of the matrix.
                let rows = m.matrix3.transpose();
                let half = DVec3::new(rows.x_axis.length(), rows.y_axis.length(), rows.z_axis.length());
                take(m.translation - half);
                take(m.translation + half);
            }
            Shape::Disc => {
                // x and y turned once around: the extent along an axis is the length of that row's first two entries.
                let rows = m.matrix3.transpose();
                let half = [rows.x_axis, rows.y_axis, rows.z_axis].map(|r| r.truncate().length());
                take(m.translation - DVec3::from(half));
                take(m.translation + DVec3::from(half));
            }
            Shape::Rectangle => {
                for (x, y) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
                    take(m.transform_point3(DVec3::new(x, y, 0.0)));
                }
            }
        }
    }
    (low.x <= high.x).then_some((low, high))
}

/// Bounds of the finite corners of a mesh's triangles, in its own space.
fn mesh_bounds(mesh: &Mesh) -> Option<(DVec3, DVec3)> {
    let corners = mesh.triangles.iter().flatten().map(|&i| DVec3::from(mesh.positions[i as usize].map(f64::from)));
    let start = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let (low, high) = corners.filter(|p| p.is_finite()).fold(start, |(low, high), p| (low.min(p), high.max(p)));
    (low.x <= high.x).then_some((low, high))
}

/// Places the camera when nothing else did: a three-quarter view from the front right, slightly above, such that the
/// corners of the bounds stay inside 95 % of both fields of view. An empty scene is looked at from 5 m. A lens is focused on the
/// middle, an orthographic view made large enough.
pub fn frame_camera(scene: &mut Scene) {
    // 35 degrees to the right of the front (+z), 15 degrees up.
    frame_camera_from(scene, 35f64.to_radians(), 15f64.to_radians());
}

/// The same from another side: `azimuth` from the front (+z) to the right (+x), `elevation` up, radians.
pub fn frame_camera_from(scene: &mut Scene, azimuth: f64, elevation: f64) {
    if scene.camera.is_placed {
        return;
    }
    let (low, high) = bounds(scene).unwrap_or((DVec3::splat(-1.0), DVec3::splat(1.0)));
    let center = low * 0.5 + high * 0.5;
    let extent = (high - low).max_element();
    let half = (high - low).max(DVec3::splat(extent.max(1e-6) * 1e-3)) * 0.5;
    let back =
        DVec3::new(azimuth.sin() * elevation.cos(), elevation.sin(), azimuth.cos() * elevation.cos()).normalize();
    let right = DVec3::Y.cross(back).normalize();
    let up = back.cross(right);
    let aspect = f64::from(scene.film.width.max(1)) / f64::from(scene.film.height.max(1));
    let fov_y_rad = match scene.camera.projection {
        Projection::Perspective { fov_y_rad } | Projection::ThinLens { fov_y_rad, .. } => fov_y_rad,
        // From afar enough for the others too.
        _ => 40f64.to_radians(),
    };
    let tan_y = (fov_y_rad * 0.5).tan() * 0.95;
    let tan_x = tan_y * aspect;
    // A corner at offset c is inside when |c.right| <= tan_x (distance - c.back), and likewise for up.
    let mut distance: f64 = 0.0;
    let mut seen: f64 = 0.0;
    for corner in 0..8 {
        let sign = |bit: i32| if corner & (1 << bit) != 0 { 1.0 } else { -1.0 };
        let c = half * DVec3::new(sign(0), sign(1), sign(2));
        distance = distance.max(c.dot(back) + (c.dot(right).abs() / tan_x).max(c.dot(up).abs() / tan_y));
        seen = seen.max((c.dot(right).abs() / aspect).max(c.dot(up).abs()) / 0.95);
    }
    match &mut scene.camera.projection {
        Projection::ThinLens { focus_distance, .. } => *focus_distance = focus_distance.or(Some(distance)),
        Projection::Orthographic { half_width, half_height } if half_width.max(*half_height) == 0.0 => {
            *half_height = seen;
        }
        _ => {}
    }
    scene.camera.to_world =
        DAffine3 { matrix3: DMat3::from_cols(right, up, back), translation: center + back * distance };
    scene.camera.is_placed = true;
}

impl Sky {
    /// No radiance of it is beyond what can be rendered; else why.
    pub fn check(&self, images: &[Image]) -> Result<(), String> {
        let brightest = match self.radiance {
            SkyRadiance::Uniform(radiance) => radiance.max_element(),
            SkyRadiance::Image(image) => match images.get(image).map(|i| &i.pixels) {
                Some(Pixels::RgbF32(p)) => f64::from(p.iter().fold(0.0f32, |most, x| most.max(*x))),
                _ => 1.0,
            },
        };
        let most = self.scale * brightest;
        if most <= MAX_RADIANCE {
            return Ok(());
        }
        Err(format!("makes the sky's radiance {most:.3e} W/(m2 sr), and {MAX_RADIANCE:e} is the most; lower it"))
    }

    /// Irradiance of a horizontal plane facing up, as luminance: texel by texel, each with its exact cosine-weighted solid angle
    /// (1/2 (sin^2 below - sin^2 above) times its width), which is the integral of the bilinear picture up to its slope across the
    /// horizon's row.
    pub fn horizontal_irradiance(&self, images: &[Image]) -> f64 {
        let image = match self.radiance {
            SkyRadiance::Uniform(radiance) => return std::f64::consts::PI * self.scale * luminance(radiance),
            SkyRadiance::Image(image) => &images[image],
        };
        let Pixels::RgbF32(pixels) = &image.pixels else { return 0.0 };
        let (width, height) = (image.width as usize, f64::from(image.height));
        let usable = |x: f32| if x.is_finite() && x > 0.0 { f64::from(x) } else { 0.0 };
        let rows = pixels.chunks_exact(3 * width).enumerate().map(|(j, row)| {
            let sin2 = |edge: f64| (std::f64::consts::PI * edge.min(0.5 * height) / height).sin().powi(2);
            let weight = 0.5 * (sin2(j as f64 + 1.0) - sin2(j as f64)) * std::f64::consts::TAU / width as f64;
            let pixel = |p: &[f32]| luminance(DVec3::new(usable(p[0]), usable(p[1]), usable(p[2])));
            weight * row.chunks_exact(3).map(pixel).sum::<f64>()
        });
        self.scale * rows.sum::<f64>()
    }
}

/// Gives a scene without sky, lamp and emitting surface a uniform sky of radiance 1, and notes it.
pub fn ensure_light(scene: &mut Scene) {
    let shines = |light: &super::Light| light.lamp.model().power(1.0).max_element() > 0.0;
    if scene.sky.is_none()
        && !scene.lights.iter().any(shines)
        && !scene.instances.iter().any(|i| emits(&scene.materials[i.material].emission))
    {
        scene.sky = Some(Sky { radiance: SkyRadiance::Uniform(DVec3::ONE), rotation_rad: 0.0, scale: 1.0 });
        scene.notes.push("no light in the scene: a uniform sky of radiance 1 W/(m2 sr) was added".into());
    }
}

fn emits(emission: &Option<Value>) -> bool {
    match emission {
        None => false,
        Some(Value::Constant(c)) => c[..3].iter().any(|x| *x > 0.0),
        Some(_) => true,
    }
}
