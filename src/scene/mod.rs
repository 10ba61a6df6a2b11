//! The author's view of a scene: names, SI units, f64 parameters; mesh arrays and pixels as they were stored.
//!
//! Nothing here knows about a GPU. `format` fills it from files, `prepare` resolves it to f32 records, and the
//! independent oracle (`reference::independent`) reads it directly. Right-handed, y up, metres, radians.

mod complete;
mod error;
pub mod format;
mod sensor;

pub use complete::{bounds, ensure_light, frame_camera, frame_camera_from};
pub use error::Error;
pub use format::{Choice, load, load_choice};
pub use sensor::{Place, Quantity, Sensor};

use std::path::PathBuf;
use std::sync::Arc;

use glam::{DAffine2, DAffine3, DVec3};

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

/// A texture node: what a `Value` can look up.
#[derive(Clone, Debug)]
pub enum Texture {
    Image {
        image: usize,
        wrap: [Wrap; 2],
        filter: Filter,
        minify: Minify,
        encoding: Encoding,
    },
    /// Squares of `a` and `b`, `scale` squares a unit of u and of v; `a` where floor(u s) + floor(v s) is even.
    Checker {
        a: [f64; 4],
        b: [f64; 4],
        scale: [f64; 2],
    },
    Constant([f64; 4]),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Wrap {
    Repeat,
    Mirror,
    Clamp,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Filter {
    Nearest,
    Linear,
}

/// How a texture wants to be read where several of its texels fall into a footprint; see `TextureFilter`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Minify {
    /// Among the texels of a level.
    pub filter: Filter,
    /// Among the levels; None reads level 0 always.
    pub levels: Option<Filter>,
}

impl Default for Minify {
    /// Trilinear.
    fn default() -> Self {
        Self { filter: Filter::Linear, levels: Some(Filter::Linear) }
    }
}

/// What a look-up of an image stands for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, clap::ValueEnum)]
pub enum TextureFilter {
    /// The picture at a point: pixels are averaged by their samples, without bias.
    #[default]
    Exact,
    /// A mean over the ray's footprint where a texture's sampler asks for it: less noise and a bias (texture/mip.rs).
    Mipmap,
}

/// How encoded colour channels (8 or 16 bits) become linear; alpha is always linear.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Encoding {
    Srgb,
    Linear,
}

/// A small expression that yields RGBA at a surface point. A scalar input reads its first channel.
#[derive(Clone, Debug)]
pub enum Value {
    Constant([f64; 4]),
    /// Tabulated against wavelength in nm (metals' eta and k); `prepare` resolves it to RGB or wavelengths.
    Curve(Arc<Curve>),
    /// `texture` looked up at `uv_transform * uv[uv_set]`.
    Texture {
        texture: usize,
        uv_set: u8,
        uv_transform: DAffine2,
    },
    /// The interpolated vertex colour; white where the mesh has none.
    VertexColor,
    Multiply(Box<Value>, Box<Value>),
    /// Channel 0..=3 of the argument, in all four channels.
    Channel(Box<Value>, u8),
    /// The first channel of the argument, cut to [0, 1], in all four channels.
    Share(Box<Value>),
    /// 1 less that.
    Rest(Box<Value>),
}

impl Value {
    pub fn scalar(x: f64) -> Self {
        Self::Constant([x; 4])
    }
    pub fn rgb(r: f64, g: f64, b: f64) -> Self {
        Self::Constant([r, g, b, 1.0])
    }
}

/// Samples of a quantity against wavelength, ascending.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    pub wavelength_nm: Vec<f64>,
    pub value: Vec<f64>,
}

/// A surface: one BSDF model and what surrounds it.
#[derive(Clone, Debug)]
pub struct Material {
    pub name: String,
    /// Position in `bsdf::MODELS`.
    pub bsdf: usize,
    /// One value for each of the model's inputs, in its order.
    pub inputs: Vec<Value>,
    /// Emitted radiance, W/(m2 sr).
    pub emission: Option<Value>,
    /// Emits on both sides; otherwise on the front (counter-clockwise) side only.
    pub emission_two_sided: bool,
    pub alpha: Alpha,
    /// Tangent-space normal as a texture in [0,1]^3, and the factor on its x and y.
    pub normal_map: Option<(Value, f64)>,
    /// The medium behind the surface, for models that transmit with refraction.
    pub interior: Option<Medium>,
    /// Where bodies that refract overlap, the higher fills the space; of equals the one entered last.
    pub priority: u32,
    /// The surfaces of a mixture, the first of which is `bsdf` with `inputs`; empty for a plain surface.
    pub parts: Vec<Part>,
}

/// One surface of a mixture. Shares are in [0, 1] and add to 1.
#[derive(Clone, Debug)]
pub struct Part {
    pub bsdf: usize,
    pub inputs: Vec<Value>,
    pub share: Value,
}

/// A model with its inputs.
#[derive(Clone, Copy, Debug)]
pub struct Surface<'a> {
    pub bsdf: usize,
    pub inputs: &'a [Value],
}

impl<'a> Surface<'a> {
    pub fn input(&self, name: &str) -> Option<&'a Value> {
        let place = crate::bsdf::MODELS[self.bsdf].inputs.iter().position(|i| i.name == name)?;
        self.inputs.get(place)
    }
}

impl Material {
    /// Its surface, or those of the mixture.
    pub fn surfaces(&self) -> Vec<Surface<'_>> {
        if self.parts.is_empty() {
            return vec![Surface { bsdf: self.bsdf, inputs: &self.inputs }];
        }
        self.parts.iter().map(|p| Surface { bsdf: p.bsdf, inputs: &p.inputs }).collect()
    }
}

#[derive(Clone, Debug)]
pub enum Alpha {
    Opaque,
    /// Present where the first channel of the value >= cutoff.
    Mask {
        value: Value,
        cutoff: f64,
    },
    /// Present with this probability.
    Blend {
        value: Value,
    },
}

/// Homogeneous absorbing medium: sigma_a in 1/m, linear RGB.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Medium {
    pub absorption: DVec3,
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

/// A light without a surface.
#[derive(Clone, Debug)]
pub struct Light {
    /// For messages.
    pub name: String,
    pub lamp: crate::light::Lamp,
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
