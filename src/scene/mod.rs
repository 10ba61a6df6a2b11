//! The author's view of a scene: names, SI units, f64 parameters; mesh arrays and pixels as they were stored.
//!
//! Nothing here knows about a GPU. `format` fills it from files, `prepare` resolves it to f32 records, and the
//! independent oracle (`reference::independent`) reads it directly. Right-handed, y up, metres, radians.

mod complete;
mod error;
pub mod format;
pub mod groups;
mod material;
mod sensor;

pub use complete::{bounds, ensure_light, frame_camera, frame_camera_from};
pub use error::Error;
pub use format::{Choice, load, load_choice};
pub use material::{
    Alpha, Curve, Encoding, Filter, MAX_ABSORPTION, MAX_RADIANCE, Material, Medium, Minify, Part, Surface, Texture,
    TextureFilter, Value, Wrap,
};
pub use sensor::{Place, Quantity, Sensor};

use std::path::PathBuf;
use std::sync::Arc;

use glam::{DAffine3, DVec3};

use crate::film::Tile;
use crate::film::exposure::Shutter;
use crate::film::filter::PixelFilter;

/// A whole scene. Indices (`mesh`, `material`, `texture`, `image`) point into the vectors here.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    pub name: String,
    /// The file it came from; empty for scenes built in code.
    pub source: PathBuf,
    pub camera: Camera,
    pub film: Film,
    pub images: Vec<Image>,
    pub textures: Vec<Texture>,
    pub materials: Vec<Material>,
    pub meshes: Vec<Mesh>,
    pub instances: Vec<Instance>,
    pub sky: Option<Sky>,
    /// Light group of the sky; see `groups`.
    pub sky_group: Option<String>,
    /// What `measure` measures.
    pub sensors: Vec<Sensor>,
    pub texture_filter: TextureFilter,
    /// Names of the material variants its file offers.
    pub variants: Vec<String>,
    /// Lights that no surface carries.
    pub lights: Vec<Light>,
    /// What was reported and left out while reading (unsupported optional extensions, skipped primitives, degenerate input).
    pub notes: Vec<String>,
}

impl Scene {
    /// Some light has no size: the estimator `bsdf` cannot find it.
    pub fn has_delta_lights(&self) -> bool {
        self.lights.iter().any(|l| l.lamp.kind().is_delta())
    }
}

/// `to_world` maps camera space (x right, y up, looking along -z) to world.
#[derive(Clone, Debug)]
pub struct Camera {
    pub to_world: DAffine3,
    pub projection: Projection,
    /// False until a file or flag places it: then `frame_camera` frames the bounds.
    pub is_placed: bool,
}

impl Default for Camera {
    fn default() -> Self {
        let projection = Projection::Perspective { fov_y_rad: 40f64.to_radians() };
        Self { to_world: DAffine3::IDENTITY, projection, is_placed: false }
    }
}

/// Which rays the film collects. The meters are made by `measure` from the scene's sensors; no file names them as its camera.
#[derive(Clone, Debug, PartialEq)]
pub enum Projection {
    /// Vertical field of view, radians, in (0, pi).
    Perspective { fov_y_rad: f64 },
    /// Radius of the lens, m; distance of the plane of focus along the view, m, None until something is focused on.
    ThinLens { fov_y_rad: f64, lens_radius: f64, focus_distance: Option<f64> },
    /// Half of what must be seen, m; the film's shape may make one of them more.
    Orthographic { half_width: f64, half_height: f64 },
    /// All directions, laid out as a lat-long sky.
    Panorama,
    /// Radiance along -z.
    MeterRay,
    /// Irradiance on a small patch whose normal is -z.
    MeterPoint,
    /// Irradiance over shapes.
    MeterSurface(SurfaceMeter),
    /// Exitance of shapes.
    MeterLeaving(SurfaceMeter),
}

/// One side of some shapes.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceMeter {
    /// Indices into `Scene::instances`.
    pub shapes: Vec<usize>,
    pub is_back: bool,
}

/// Image size in pixels, what of it is rendered and how pixels are made of samples.
#[derive(Clone, Debug)]
pub struct Film {
    pub width: u32,
    pub height: u32,
    /// The part of the image that is rendered; the whole when None.
    pub crop: Option<Tile>,
    pub filter: PixelFilter,
    /// What exposes 8-bit pictures; at a radiance of 1 they are white without.
    pub shutter: Option<Shutter>,
    /// Samples a pixel to take when no stop is given.
    pub spp: Option<u32>,
    /// Path edges: 1 = emission seen directly, 2 = one bounce.
    pub max_depth: Option<u32>,
}

impl Film {
    pub const fn sized(width: u32, height: u32) -> Self {
        Self { width, height, crop: None, filter: PixelFilter::BOX, shutter: None, spp: None, max_depth: None }
    }

    /// Renders only columns x0..x1 and rows y0..y1; the error says why the image has no such window.
    pub fn set_crop(&mut self, [x0, y0, x1, y1]: [u32; 4]) -> Result<(), String> {
        if x0 >= x1 || y0 >= y1 {
            return Err(format!("{x0},{y0},{x1},{y1} holds no pixel: x1 must be above x0, and y1 above y0"));
        }
        let crop = Tile { x: x0, y: y0, width: x1 - x0, height: y1 - y0 };
        if !crop.is_inside(self.width, self.height) {
            return Err(format!("{x0},{y0},{x1},{y1} reaches out of the image of {}x{}", self.width, self.height));
        }
        self.crop = Some(crop);
        Ok(())
    }

    /// The part of the image that is rendered.
    pub fn window(&self) -> Tile {
        self.crop.unwrap_or(Tile::image(self.width, self.height))
    }
}

impl Default for Film {
    fn default() -> Self {
        Self::sized(640, 480)
    }
}

/// Pixels as stored in the file, row 0 on top.
#[derive(Clone, Debug)]
pub struct Image {
    pub name: String,
    pub width: u32,
    pub height: u32,
    pub pixels: Pixels,
}

#[derive(Clone, Debug)]
pub enum Pixels {
    /// 4 bytes a pixel; whether they are sRGB-encoded is said by the texture that uses them.
    Rgba8(Arc<Vec<u8>>),
    /// 4 numbers of 16 bits a pixel, encoded as those of `Rgba8`.
    Rgba16(Arc<Vec<u16>>),
    /// Linear RGB, 3 floats a pixel.
    RgbF32(Arc<Vec<f32>>),
}

/// Vertex arrays as stored, decoded to f32. Optional arrays have one entry a position.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    pub name: String,
    pub positions: Vec<[f32; 3]>,
    pub normals: Option<Vec<[f32; 3]>>,
    /// xyz and handedness (+1 or -1) in w.
    pub tangents: Option<Vec<[f32; 4]>>,
    pub uvs: [Option<Vec<[f32; 2]>>; 2],
    /// Linear RGBA.
    pub colors: Option<Vec<[f32; 4]>>,
    pub triangles: Vec<[u32; 3]>,
}

/// One shape placed in the world.
#[derive(Clone, Debug)]
pub struct Instance {
    pub name: String,
    pub shape: Shape,
    pub to_world: DAffine3,
    pub material: usize,
}

#[derive(Clone, Copy, Debug)]
pub enum Shape {
    Mesh(usize),
    /// Analytic unit sphere about the origin (the transform scales it uniformly); front = outside. u = atan2(x,-z)/(2 pi)+0.5, v = acos(y)/pi.
    Sphere,
    /// Analytic unit disc in the plane z = 0 (the transform keeps it round), front = +z; (u, v) = ((x+1)/2, (1-y)/2).
    Disc,
    /// [-1,1]^2 in the plane z = 0, front = +z; (u, v) = ((x+1)/2, (1-y)/2). Becomes two triangles.
    Rectangle,
}

impl Shape {
    /// Analytic spheres and discs need lengths that are equal and at right angles: along all axes, or along the disc's plane.
    pub fn stays_round(self, to_world: &DAffine3) -> Result<(), &'static str> {
        let m = to_world.matrix3;
        let size = m.x_axis.length();
        // 1e-6: far above the rounding of composed transforms, far below what an author could mean.
        let differ = |v: DVec3| (v.length() - size).abs() > 1e-6 * size;
        let is_skew = |a: DVec3, b: DVec3| a.dot(b).abs() > 1e-6 * size * size;
        let is_flat_round = !differ(m.y_axis) && !is_skew(m.x_axis, m.y_axis);
        match self {
            Self::Sphere
                if !is_flat_round || differ(m.z_axis) || is_skew(m.y_axis, m.z_axis) || is_skew(m.z_axis, m.x_axis) =>
            {
                Err("would make the sphere an ellipsoid; scale it the same along all axes, or use a mesh")
            }
            Self::Disc if !is_flat_round => {
                Err("would make the disc an ellipse; scale it the same along its plane, or use a mesh")
            }
            _ => Ok(()),
        }
    }
}

/// A light without a surface.
#[derive(Clone, Debug)]
pub struct Light {
    /// For messages.
    pub name: String,
    pub lamp: crate::light::Lamp,
    /// Light group; see `groups`.
    pub group: Option<String>,
}

/// Light from infinitely far away, all around.
#[derive(Clone, Debug)]
pub struct Sky {
    pub radiance: SkyRadiance,
    /// Turned about +y by this angle.
    pub rotation_rad: f64,
    pub scale: f64,
}

#[derive(Clone, Debug)]
pub enum SkyRadiance {
    /// The same linear RGB radiance from everywhere, W/(m2 sr).
    Uniform(DVec3),
    /// Lat-long image (index into `images`, `Pixels::RgbF32`); see DESIGN conventions in the crate page.
    Image(usize),
}
