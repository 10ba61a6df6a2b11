//! Lights. One kind is one Rust file here, one GLSL file of the same stem, one line in `light_list!`, one row in `conform::light`.
//!
//! From the list follow the kinds' numbers in records, the macros `HAS_<CONSTANT>`, the files of a kernel and the functions that
//! choose among kinds (`shader::dispatch::lights`). The maths here are f64, with the same map from random numbers to directions as
//! the kernels, for the replay oracle; `alias` chooses a light, `integrals` holds known answers, `sky_table` makes the sky's cells.
//! Every density is per solid angle, in 1/sr; 0 means no sample.

pub mod alias;
#[cfg(test)]
mod independent;
pub mod integrals;
pub mod sky_table;

use glam::DVec3;

use crate::prepare::Prepared;
use crate::prepare::records::LightRecord;
use crate::sampler::Purpose;

/// A light as one point sees it; GLSL has the same struct (shaders/light/common.glsl).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Connection {
    /// Unit, towards the light.
    pub wi: DVec3,
    /// Infinite for what is infinitely far away.
    pub distance: f64,
    /// W/(m2 sr).
    pub radiance: DVec3,
    /// 1/sr, the choice of the light not included; 0 means no sample.
    pub pdf: f64,
    /// The light's own primitive, which its shadow ray ignores, or NONE.
    pub primitive: u32,
}

/// Where on a surface emission is asked for.
#[derive(Clone, Copy, Debug)]
pub enum Place {
    /// Weights of vertices 1 and 2 of a face.
    Face(u32, [f64; 2]),
    /// Row of `Prepared::spheres` and the outward normal.
    Sphere(u32, DVec3),
}

/// The records around a light, and the random words of the path that samples it.
pub trait Surroundings {
    fn prepared(&self) -> &Prepared;
    fn word(&self, purpose: Purpose) -> u32;
    /// Radiance of `material` there towards who sees its front or back, times its presence.
    fn emission(&self, material: u32, place: Place, is_front: bool) -> DVec3;
}

/// `(light, p, wi, distance, is_front)` to 1/sr.
pub type Density = fn(&LightRecord, DVec3, DVec3, f64, bool) -> f64;

/// How a path can run into a light by itself.
#[derive(Clone, Copy, Debug)]
pub enum Reach {
    /// On a surface of the scene; with the density of `connect` for a hit at this distance, on the front or back.
    Surface(Density),
    /// Along a ray that leaves the scene.
    Infinity,
}

/// What the program knows of a kind.
#[derive(Clone, Copy, Debug)]
pub struct Kind {
    /// Stem of its files and prefix of its GLSL functions.
    pub keyword: &'static str,
    /// Name of its number in GLSL.
    pub constant: &'static str,
    /// 1 in kernels that sample such a light.
    pub has_macro: &'static str,
    pub reach: Reach,
    /// Samples the light of this record from a point, by two numbers in [0, 1).
    pub connect: fn(&dyn Surroundings, &LightRecord, DVec3, [f64; 2]) -> Connection,
}

/// Declares the modules, `KINDS`, and each kind's number: its place in the list.
macro_rules! light_list {
    ($($stem:ident $constant:ident),* $(,)?) => {
        $(pub mod $stem;)*

        /// Every kind, in list order.
        pub const KINDS: &[Kind] = &[$(Kind {
            keyword: stringify!($stem),
            constant: stringify!($constant),
            has_macro: concat!("HAS_", stringify!($constant)),
            reach: $stem::REACH,
            connect: $stem::connect,
        }),*];

        #[allow(non_camel_case_types, reason = "an enum only to count the stems")]
        enum Number { $($stem),* }
        $(pub const $constant: u32 = Number::$stem as u32;)*
    };
}

light_list! {
    triangle LIGHT_TRIANGLE,
    sphere LIGHT_SPHERE,
    sky LIGHT_SKY,
}

/// Kind of a record; None for a number that no kind has.
pub fn kind(light: &LightRecord) -> Option<&'static Kind> {
    KINDS.get(light.kind as usize)
}

/// A light's weight in the choice among lights, and what is written about it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Emitter {
    pub record: LightRecord,
    /// Luminance of the emitted flux, W; 0 for what cannot light anything, which gets no row.
    pub power: f64,
}

/// A light that emits must not lose its probability to underflow.
pub(crate) fn kept_positive(power: f64, emits: bool) -> f64 {
    if emits && power == 0.0 { f64::MIN_POSITIVE } else { power }
}

/// Relative luminance of radiance; NaN and negative channels emit nothing.
pub(crate) fn emitted_luminance(radiance: DVec3) -> f64 {
    sky_table::luminance(radiance.to_array().map(|x| if x > 0.0 { x } else { 0.0 }))
}

pub(crate) fn vector(v: [f32; 3]) -> DVec3 {
    DVec3::from(v.map(f64::from))
}
