//! Cameras and meters: where a sample starts, which way it looks, and what the radiance it meets counts.
//!
//! One camera is one file here, one GLSL file of the same stem, one line in `camera_list!` and one row of gates 6 and 7
//! (conform/camera.rs). All share one record, `CameraRecord`; the kernel holds the scene's camera only. All records are rebased
//! so that the camera's position is the origin (`prepare`).
//!
//! A meter (`meter_*`) is a camera whose film is a row of independent repetitions of one measurement (`measure`). One that collects
//! from a hemisphere has a normal, its `receiver`: its rays leave with density cos/pi and weight pi, so that a sample is an estimate
//! of irradiance, and light sampling serves it as it serves a surface.

mod elements;

use glam::{DVec2, DVec3};

use crate::light::alias;
use crate::prepare::records::{AliasRecord, CameraRecord, NONE, SensorElementRecord};
use crate::sampler::Purpose;
use crate::scene::{Camera, Film, Projection, Scene};
pub use elements::{Elements, elements, surface_anchor, surface_area};

/// The start of a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Start {
    pub origin: DVec3,
    /// Unit.
    pub direction: DVec3,
    /// Factor on the radiance that arrives.
    pub weight: f64,
    /// Unit normal of a meter that collects from a hemisphere; `direction` then has the density cos/pi.
    pub receiver: Option<DVec3>,
}

impl Start {
    /// A camera's: nothing but a ray.
    fn ray(origin: DVec3, direction: DVec3) -> Self {
        Self { origin, direction, weight: 1.0, receiver: None }
    }
}

/// What a camera reads: its record, and a surface meter's triangles and spheres.
#[derive(Clone, Copy, Debug)]
pub struct View<'a> {
    pub camera: &'a CameraRecord,
    pub elements: &'a [SensorElementRecord],
    pub alias: &'a [AliasRecord],
}

impl View<'_> {
    /// Place of the record's element that two words choose.
    fn choose(&self, index_word: u32, fraction_word: u32) -> usize {
        alias::choose_record(self.alias, self.elements.len() as u32, index_word, fraction_word) as usize
    }
}

/// A kind of camera.
pub struct Model {
    /// Stem of the Rust and the GLSL file.
    pub keyword: &'static str,
    /// A meter: `measure` makes it, no scene file names it as its camera.
    pub is_meter: bool,
    /// It collects from a hemisphere: light sampling serves it.
    pub receives: bool,
    /// It reads the tables of elements.
    pub has_elements: bool,
    /// It is the camera of this projection.
    pub claims: fn(&Projection) -> bool,
    /// Its record, without kind and medium; else a sentence on what is wrong.
    pub record: fn(&Camera, &Film) -> Result<CameraRecord, String>,
    /// The start through `film`, in pixels, in f64; `word` gives the random words of vertex 0.
    pub start: fn(&View, DVec2, &dyn Fn(Purpose) -> u32) -> Start,
}

macro_rules! camera_list {
    ($($stem:ident),* $(,)?) => {
        $(pub mod $stem;)*
        pub const MODELS: &[Model] = &[$($stem::MODEL),*];
    };
}

camera_list! {
    perspective,
    thin_lens,
    orthographic,
    panorama,
    meter_ray,
    meter_point,
    meter_surface,
    meter_leaving,
}

/// Number of the model in `MODELS`.
pub fn kind(projection: &Projection) -> usize {
    MODELS.iter().position(|m| (m.claims)(projection)).expect("every projection has a camera, which a test checks")
}

/// The record of the scene's camera, its medium left NONE.
pub fn record(scene: &Scene) -> Result<CameraRecord, String> {
    let kind = kind(&scene.camera.projection);
    let record = (MODELS[kind].record)(&scene.camera, &scene.film)?;
    let cone = cone(&scene.camera.projection, &record);
    Ok(CameraRecord { kind: kind as u32, medium: NONE, cone, ..record })
}

/// Diameter of a pixel's ray cone where it starts, and its growth a metre (Akenine-Moller et al. 2021, section 3). Meters have none.
fn cone(projection: &Projection, record: &CameraRecord) -> [f32; 2] {
    let pixel = vec(record.up).length() as f32 * record.inv_height;
    match projection {
        Projection::Perspective { .. } | Projection::ThinLens { .. } => [0.0, pixel],
        Projection::Orthographic { .. } => [pixel, 0.0],
        Projection::Panorama => [0.0, std::f32::consts::FRAC_PI_2 * record.inv_height],
        _ => [0.0; 2],
    }
}

/// Through `film`, in pixels, by the camera that the record names.
pub fn start(view: &View, film: DVec2, word: &dyn Fn(Purpose) -> u32) -> Start {
    (MODELS[view.camera.kind as usize].start)(view, film, word)
}

/// Unit vectors forward, right, up. Scale and shear of the author's transform are no part of the view.
fn axes(camera: &Camera) -> Result<[DVec3; 3], String> {
    if !camera.to_world.is_finite() {
        return Err("the camera's transform is not finite; give it a finite position and direction".into());
    }
    let axes = camera.to_world.matrix3;
    let (forward, up) = ((-axes.z_axis).normalize_or_zero(), axes.y_axis.normalize_or_zero());
    let right = forward.cross(up).normalize_or_zero();
    if forward == DVec3::ZERO || right == DVec3::ZERO {
        return Err("the camera's axes are degenerate; give it a direction, and an up that is not along it".into());
    }
    Ok([forward, right, right.cross(forward)])
}

/// A record whose plane one unit ahead reaches from -right to right and from -up to up. Nothing else is set.
fn plane(forward: DVec3, right: DVec3, up: DVec3, film: &Film) -> CameraRecord {
    CameraRecord {
        forward: forward.as_vec3().to_array(),
        inv_width: (2.0 / f64::from(film.width)) as f32,
        right: right.as_vec3().to_array(),
        inv_height: (2.0 / f64::from(film.height)) as f32,
        up: up.as_vec3().to_array(),
        ..CameraRecord::default()
    }
}

/// Film position in pixels to (x, y) in [-1, 1]^2, y up.
fn on_plane(camera: &CameraRecord, film: DVec2) -> DVec2 {
    DVec2::new(film.x * f64::from(camera.inv_width) - 1.0, 1.0 - film.y * f64::from(camera.inv_height))
}

fn vec(v: [f32; 3]) -> DVec3 {
    DVec3::from(v.map(f64::from))
}

#[cfg(test)]
mod tests;
