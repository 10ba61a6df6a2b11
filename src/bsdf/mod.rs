//! Surface scattering models. One model is one Rust file here, one GLSL file of the same stem, and one line in `bsdf_list!`.
//!
//! Conventions: `wo` toward the viewer, `wi` toward the light, both leave the surface, local frame z = shading normal.
//! `eval` = f |cos wi| in 1/sr; `pdf` per solid angle; `sample` gives direction, weight = eval/pdf, pdf, flags.
//! The agreement of shading and geometric sides is checked by the caller, in one place, not by the models.
//! Here the maths are f64 and written from the papers; GLSL is written on its own and gate 3 compares the two.

pub(crate) mod coat;
pub mod dielectric_albedo;
pub(crate) mod fresnel;
pub(crate) mod ggx;
pub mod ggx_albedo;
pub mod mixture;

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
    /// An index of refraction, real or imaginary part: relative to vacuum in a scene, divided by that of the medium in front in a kernel. The first
    /// of a model that lets light through is that of the medium behind its surfaces.
    pub is_index: bool,
}

impl Input {
    /// The same, and an index of refraction.
    pub const fn index(self) -> Self {
        Self { is_index: true, ..self }
    }

    pub const fn scalar(name: &'static str, default: f64, range: (f64, f64), doc: &'static str) -> Self {
        Self { name, kind: InputKind::Scalar, default: [default; 3], range, doc, is_index: false }
    }

    pub const fn color(name: &'static str, default: [f64; 3], range: (f64, f64), doc: &'static str) -> Self {
        Self { name, kind: InputKind::Color, default, range, doc, is_index: false }
    }
}

/// What the assembler, the scene reader and the documentation need to know of a model.
#[derive(Clone, Copy, Debug)]
pub struct Model {
    /// Keyword in scenes, stem of both files, prefix of the GLSL functions.
    pub keyword: &'static str,
    /// GLSL struct name; `<keyword>_params(inputs...)` returns it.
    pub glsl_type: &'static str,
    pub inputs: &'static [Input],
    /// Can let light through: the surface is not flipped towards the viewer, and the shading frame keeps the outside.
    pub transmits: bool,
    /// Lets light through only where this input is not 0; ask `transmits_when`.
    pub transmission_input: Option<&'static str>,
    /// Names of the constant tables it may read ("ggx_albedo", ...; `table_rows` makes them).
    pub tables: &'static [&'static str],
    /// (GLSL macro, when it is 1): what some material of the scene may need of the model's text.
    pub macros: &'static [(&'static str, When)],
    /// GLSL files that stand before the model's own, each once in a text.
    pub shared: &'static [Shared],
    pub doc: &'static str,
}

/// When a part of a model's text is needed. Inputs that are fed by textures may have any value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum When {
    /// Every one of these inputs may be other than 0.
    NotZero(&'static [&'static str]),
    /// Some of these inputs may differ from its default.
    NotDefault(&'static [&'static str]),
}

/// A GLSL file of functions that several models call.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shared {
    /// Path under shaders/.
    pub file: &'static str,
    /// Constant table it reads.
    pub table: Option<&'static str>,
    /// Needed only where this macro is 1.
    pub only_with: Option<&'static str>,
}

const fn shared(file: &'static str) -> Shared {
    Shared { file, table: None, only_with: None }
}

impl Model {
    /// Whether a material lets light through; `can_be_nonzero(input)` is false for inputs that are the constant 0.
    pub fn transmits_when(&self, can_be_nonzero: impl Fn(&str) -> bool) -> bool {
        self.transmits && self.transmission_input.is_none_or(can_be_nonzero)
    }

    /// The shared files a text needs whose macros are `is_on`, and through them the tables.
    pub fn shared_with(&self, is_on: impl Fn(&str) -> bool) -> impl Iterator<Item = &'static Shared> {
        self.shared.iter().filter(move |s| s.only_with.is_none_or(&is_on))
    }
}

/// Rows of a table named in `Model::tables`.
pub fn table_rows(name: &str) -> Option<Vec<[f32; 4]>> {
    match name {
        "ggx_albedo" => Some(ggx_albedo::rows()),
        "dielectric_deficit" => Some(dielectric_albedo::rows()),
        _ => None,
    }
}

/// Whether a choice of probability `p` is taken by 32 random bits: the same integer threshold as in GLSL.
pub(crate) fn is_chosen(bits: u32, p: f64) -> bool {
    p >= 1.0 || u64::from(bits) < (p * 4294967296.0) as u64
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
            /// For a frame whose y points against the bitangent; only directions along the surface notice.
            pub fn mirror(&mut self) {
                if let Params::Gltf(b) = self {
                    b.mirror();
                }
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
    conductor Conductor,
    dielectric Dielectric,
    thin_dielectric ThinDielectric,
    gltf Gltf,
    rough_diffuse RoughDiffuse,
    plastic Plastic,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(path: &str) -> String {
        std::fs::read_to_string(format!("{}/shaders/{path}", env!("CARGO_MANIFEST_DIR"))).unwrap()
    }

    /// One kernel that calls all functions of a model, for every combination of its macros.
    #[test]
    fn every_model_compiles_with_every_combination_of_its_macros() {
        let compiler = shaderc::Compiler::new().unwrap();
        for model in MODELS {
            for bits in 0..1 << model.macros.len() {
                let is_on =
                    |name: &str| model.macros.iter().position(|m| m.0 == name).is_some_and(|i| bits >> i & 1 == 1);
                let mut source = String::from("#version 450\nlayout(local_size_x = 1) in;\n");
                for (name, _) in model.macros {
                    source += &format!("#define {name} {}\n", u32::from(is_on(name)));
                }
                source += "layout(binding = 0) uniform usamplerBuffer table;\n";
                source += "layout(binding = 1) buffer Io { vec4 io[]; };\n";
                for table in ["ggx_albedo", "dielectric_deficit"] {
                    source += &format!("uvec4 {table}_row(uint i) {{ return texelFetch(table, int(i)); }}\n");
                }
                for file in [
                    "core/math.glsl",
                    "core/exp.glsl",
                    "core/trig.glsl",
                    "core/frame.glsl",
                    "core/warp.glsl",
                    "bsdf/common.glsl",
                ] {
                    source += &text(file);
                }
                for shared in model.shared_with(is_on) {
                    source += &text(shared.file);
                }
                let (k, t) = (model.keyword, model.glsl_type);
                source += &text(&format!("bsdf/{k}.glsl"));
                let inputs = model.inputs.iter().enumerate().map(|(i, input)| match input.kind {
                    InputKind::Color => format!("io[{i}].rgb"),
                    InputKind::Scalar => format!("io[{i}].x"),
                });
                let inputs = inputs.collect::<Vec<_>>().join(", ");
                source += &format!(
                    "void main() {{ {t} b = {k}_params({inputs}); vec3 wo = io[40].xyz; \
                     BsdfSample s = {k}_sample(b, wo, uint(io[40].w), io[41].xy); \
                     io[42] = vec4(s.wi, s.pdf); io[43] = vec4(s.weight, s.eta_scale); \
                     io[44] = vec4({k}_eval(b, wo, s.wi), {k}_pdf(b, wo, s.wi)); \
                     io[45] = vec4({k}_albedo(b), {k}_is_delta(b) ? s.flags : 0u); }}"
                );
                let kind = shaderc::ShaderKind::Compute;
                let spirv = compiler.compile_into_spirv(&source, kind, k, "main", None);
                assert!(spirv.is_ok(), "{k} with macros {bits:b}: {}", spirv.err().unwrap());
            }
        }
    }
}
