//! Surface scattering models. One model is one Rust file here, one GLSL file of the same stem, and one line in `bsdf_list!`.
//!
//! Conventions: `wo` toward the viewer, `wi` toward the light, both leave the surface, local frame z = shading normal.
//! `eval` = f |cos wi| in 1/sr; `pdf` per solid angle; `sample` gives direction, weight = eval/pdf, pdf, flags.
//! The agreement of shading and geometric sides is checked by the caller, in one place, not by the models.
//! Here the maths are f64 and written from the papers; GLSL is written on its own and gate 3 compares the two.

use glam::DVec3;

/// The direction came from a delta lobe: `pdf` is then a probability, and `eval`, `pdf()` do not see it.
pub const SAMPLE_DELTA: u32 = 1;
/// The direction left on the other side of the surface.
pub const SAMPLE_TRANSMISSION: u32 = 2;

/// What `sample` returns; GLSL has the same struct (shaders/bsdf/common.glsl).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BsdfSample {
    pub wi: DVec3,
    /// eval / pdf, or for a delta lobe its reflectance over its probability.
    pub weight: DVec3,
    /// 1/sr, or a probability for a delta lobe.
    pub pdf: f64,
    pub flags: u32,
    /// (eta_i/eta_t)^2 taken into `weight` by refraction, 1 otherwise: roulette divides it out.
    pub eta_scale: f64,
}

/// A model with its parameters at one surface point.
pub trait Bsdf {
    /// f |cos wi| in 1/sr; 0 for delta lobes.
    fn eval(&self, wo: DVec3, wi: DVec3) -> DVec3;
    /// Solid-angle density of `sample`, 1/sr, without its delta lobes.
    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64;
    /// `choice` picks the lobe (thresholds over 2^32), `u` in [0,1)^2 the direction. None: absorbed.
    fn sample(&self, wo: DVec3, choice: u32, u: [f64; 2]) -> Option<BsdfSample>;
    /// Approximate reflectance for the albedo AOV.
    fn albedo(&self) -> DVec3;
    /// True when every lobe is a delta lobe at these parameters: then light sampling cannot contribute.
    fn is_delta(&self) -> bool;
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InputKind {
    Scalar,
    Color,
}

/// One parameter a scene can set, and feed from a texture.
#[derive(Clone, Copy, Debug)]
pub struct Input {
    pub name: &'static str,
    pub kind: InputKind,
    pub default: [f64; 3],
    pub range: (f64, f64),
    /// Unit and meaning, for docs/scene.md.
    pub doc: &'static str,
}

/// What the assembler, the scene reader and the documentation need to know of a model.
#[derive(Clone, Copy, Debug)]
pub struct Model {
    /// Keyword in scenes, stem of both files, prefix of the GLSL functions.
    pub keyword: &'static str,
    /// GLSL struct name; `<keyword>_params(inputs...)` returns it.
    pub glsl_type: &'static str,
    pub inputs: &'static [Input],
    /// Lets light through: the surface is not flipped towards the viewer, and the shading frame keeps the outside.
    pub transmits: bool,
    /// Names of the constant tables it reads ("ggx_albedo", ...).
    pub tables: &'static [&'static str],
    /// (GLSL macro, input): the macro is 1 when some material of the scene may have this input different from 0.
    pub macros: &'static [(&'static str, &'static str)],
    pub doc: &'static str,
}

/// Declares the modules, `MODELS` (a model's number is its place here), and `Params`, the f64 sum of all models.
macro_rules! bsdf_list {
    ($($stem:ident $type:ident),* $(,)?) => {
        $(pub mod $stem;)*

        /// Every model, in list order.
        pub const MODELS: &[Model] = &[$($stem::MODEL),*];

        /// Any model with its f64 parameters.
        #[derive(Clone, Copy, Debug)]
        pub enum Params { $($type($stem::$type)),* }

        impl Params {
            /// `inputs` in the order of `MODELS[model].inputs`; a scalar is splatted.
            pub fn from_inputs(model: usize, inputs: &[DVec3]) -> Self {
                let constructors: &[fn(&[DVec3]) -> Params] = &[$(|i| Params::$type($stem::$type::from_inputs(i))),*];
                constructors[model](inputs)
            }
            /// The model behind it.
            pub fn bsdf(&self) -> &dyn Bsdf {
                match self { $(Params::$type(b) => b),* }
            }
        }
    };
}

bsdf_list! {
    lambert Lambert,
}
