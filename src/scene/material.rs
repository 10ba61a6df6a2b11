//! Surfaces as an author says them: materials, the values their inputs take, and the textures those look up.

use std::ops::Range;
use std::sync::Arc;

use glam::{DAffine2, DVec3};

use super::{Pixels, Scene};
use crate::bsdf::MODELS;

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

    /// 0 everywhere (textures are not looked into).
    pub fn is_zero(&self) -> bool {
        match self {
            Self::Constant(c) => c[..3] == [0.0; 3],
            Self::Multiply(a, b) => a.is_zero() || b.is_zero(),
            _ => false,
        }
    }
}

/// Largest radiance, W/(m2 sr), and largest strength of a light in its own unit: the square of the sum of a block's 16 samples stays
/// below f32's 3.4e38, which the layer of variances needs.
pub const MAX_RADIANCE: f64 = 1e18;

/// Largest absorption, 1/m: exp(-1e20 t) is 0 for every t a ray can have.
pub const MAX_ABSORPTION: f64 = 1e20;

impl Scene {
    /// Numbers between which `value` lies in red, green and blue (in one channel where it names one), and whether both are surely met.
    pub fn bounds_of(&self, value: &Value) -> Bounds {
        self.bounds_in(value, 0..3)
    }

    fn bounds_in(&self, value: &Value, channels: Range<usize>) -> Bounds {
        let around = |numbers: &mut dyn Iterator<Item = f64>, is_met| {
            let (least, most) = numbers.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, m), x| (l.min(x), m.max(x)));
            Bounds { least, most, is_met }
        };
        let unit = Bounds { least: 0.0, most: 1.0, is_met: false };
        match value {
            Value::Constant(c) => around(&mut c[channels].iter().copied(), true),
            Value::Curve(curve) => around(&mut curve.value.iter().copied(), false),
            Value::VertexColor | Value::Share(_) | Value::Rest(_) => unit,
            Value::Channel(a, c) => self.bounds_in(a, usize::from(*c)..usize::from(*c) + 1),
            Value::Multiply(a, b) => {
                let (a, b) = (self.bounds_in(a, channels.clone()), self.bounds_in(b, channels));
                let products = [a.least * b.least, a.least * b.most, a.most * b.least, a.most * b.most];
                around(&mut products.into_iter(), a.is_met && b.is_met)
            }
            Value::Texture { texture, .. } => match &self.textures[*texture] {
                Texture::Constant(c) => around(&mut c[channels].iter().copied(), true),
                Texture::Checker { a, b, .. } => {
                    around(&mut a[channels.clone()].iter().chain(&b[channels]).copied(), true)
                }
                Texture::Image { image, .. } => match &self.images[*image].pixels {
                    Pixels::RgbF32(p) => around(&mut p.iter().map(|x| f64::from(*x)), false),
                    _ => unit,
                },
            },
        }
    }
}

/// See `Scene::bounds_of`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    pub least: f64,
    pub most: f64,
    pub is_met: bool,
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
    /// Light group of what it emits; see `groups`.
    pub group: Option<String>,
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
        let place = MODELS[self.bsdf].inputs.iter().position(|i| i.name == name)?;
        self.inputs.get(place)
    }

    /// Light may pass it, refracted or straight.
    pub fn lets_through(&self) -> bool {
        MODELS[self.bsdf].transmits_when(|input| self.input(input).is_some_and(|v| !v.is_zero()))
    }
}

impl Material {
    /// Some surface of the material lets light through.
    pub fn transmits(&self) -> bool {
        self.surfaces().iter().any(Surface::lets_through)
    }

    /// Light goes straight through, into the same medium.
    pub fn is_thin(&self) -> bool {
        let is_wall =
            |s: &Surface| MODELS[s.bsdf].keyword.starts_with("thin_") || s.input("thin").is_some_and(|v| !v.is_zero());
        self.surfaces().iter().filter(|s| s.lets_through()).all(is_wall)
    }

    /// Emission that is not 0 everywhere.
    pub fn emits(&self) -> bool {
        self.emission.as_ref().is_some_and(|v| !v.is_zero())
    }

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
