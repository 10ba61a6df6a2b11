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
pub mod lamp;
pub mod sky_table;

use glam::DVec3;

use crate::prepare::Prepared;
use crate::prepare::records::{LightRecord, NONE};
use crate::sampler::Purpose;
use lamp::LampModel;

/// A light as one point sees it; GLSL has the same struct (shaders/light/common.glsl).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Connection {
    /// Unit, towards the light.
    pub wi: DVec3,
    /// Infinite for what is infinitely far away.
    pub distance: f64,
    /// W/(m2 sr); of a light without size the irradiance perpendicular to `wi`, W/m2.
    pub radiance: DVec3,
    /// 1/sr, the choice of the light not included; 1 for a light without size; 0 means no sample.
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
    /// Row of `Prepared::discs` and the point.
    Disc(u32, DVec3),
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

/// Gets radiance, row of `lights`, and the density of `connect` in 1/sr.
pub type Arriving<'a> = dyn FnMut(DVec3, u32, f64) + 'a;

/// How a path can run into a light by itself.
#[derive(Clone, Copy, Debug)]
pub enum Reach {
    /// On a surface of the scene; with the density of `connect` for a hit at this distance, on the front or back.
    Surface(Density),
    /// Along a ray that leaves the scene, in this direction.
    Infinity(fn(&Prepared, DVec3, &mut Arriving)),
    /// Not at all: it has no size. Only light sampling finds it, and its samples count whole.
    Nowhere,
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
    /// GLSL files that stand before its own, each once in a text.
    pub shared: &'static [&'static str],
    /// Samples the light of this record from a point, by two numbers in [0, 1).
    pub connect: fn(&dyn Surroundings, &LightRecord, DVec3, [f64; 2]) -> Connection,
}

impl Kind {
    pub fn is_delta(&self) -> bool {
        matches!(self.reach, Reach::Nowhere)
    }
}

/// Declares the modules, `KINDS`, each kind's number (its place in the list), and `Lamp`, the sum of the lights that no surface
/// carries: those with a type of parameters.
macro_rules! light_list {
    ($($stem:ident $constant:ident),*; $($lamp:ident $lamp_constant:ident $type:ident),* $(,)?) => {
        $(pub mod $stem;)*
        $(pub mod $lamp;)*

        /// Every kind, in list order.
        pub const KINDS: &[Kind] = &[
            $(light_list!(@kind $stem $constant, $stem::connect),)*
            $(light_list!(@kind $lamp $lamp_constant, |_, light, p, u| $lamp::$type::from_record(light).connect(p, u)),)*
        ];

        #[allow(non_camel_case_types, reason = "an enum only to count the stems")]
        enum Number { $($stem,)* $($lamp),* }
        $(pub const $constant: u32 = Number::$stem as u32;)*
        $(pub const $lamp_constant: u32 = Number::$lamp as u32;)*

        #[derive(Clone, Copy, Debug, PartialEq)]
        pub enum Lamp { $($type($lamp::$type)),* }

        impl Lamp {
            pub fn model(&self) -> &dyn LampModel {
                match self { $(Self::$type(l) => l),* }
            }
            pub fn model_mut(&mut self) -> &mut dyn LampModel {
                match self { $(Self::$type(l) => l),* }
            }
            pub fn kind(&self) -> &'static Kind {
                &KINDS[match self { $(Self::$type(_) => $lamp_constant),* } as usize]
            }
            /// Its row in coordinates rebased to `origin`, and its power for the choice among lights.
            pub fn emitter(&self, origin: DVec3, scene_radius: f64) -> Emitter {
                let kind = match self { $(Self::$type(_) => $lamp_constant),* };
                let model = self.model();
                let power = emitted_luminance(model.power(scene_radius));
                let record = LightRecord { kind, material: NONE, shape: NONE, ..model.record(origin) };
                Emitter { record, power, is_distant: model.is_distant() }
            }
        }
    };
    (@kind $stem:ident $constant:ident, $connect:expr) => {
        Kind {
            keyword: stringify!($stem),
            constant: stringify!($constant),
            has_macro: concat!("HAS_", stringify!($constant)),
            reach: $stem::REACH,
            shared: $stem::SHARED,
            connect: $connect,
        }
    };
}

light_list! {
    triangle LIGHT_TRIANGLE,
    sphere LIGHT_SPHERE,
    disc LIGHT_DISC,
    sky LIGHT_SKY;
    point LIGHT_POINT Point,
    spot LIGHT_SPOT Spot,
    directional LIGHT_DIRECTIONAL Directional,
    sun LIGHT_SUN Sun,
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
    /// Infinitely far away.
    pub is_distant: bool,
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
