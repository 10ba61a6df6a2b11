//! Lights: how one is chosen, how a direction towards it is sampled, and with which density.
//!
//! Here the maths are f64. `alias`, `triangle`, `sphere` and `sky` are the models that kernels have too (shaders/light, same
//! stems), with the same map from random numbers to directions, for the replay oracle. `integrals` holds known answers. The
//! tables are made in `prepare::lights` and `sky_table`. Every density is per solid angle, in 1/sr; 0 means no sample.

pub mod alias;
#[cfg(test)]
mod independent;
pub mod integrals;
pub mod sky;
pub mod sky_table;
pub mod sphere;
pub mod triangle;

#[cfg(test)]
mod tests {
    use crate::prepare::records::{LightRecord, SkyRecord, SkyTexelRecord};
    use crate::shader::record::GpuRecord;

    /// The family's text with its records, for a table body that reads nothing.
    fn glsl(sky_image: u32) -> String {
        let mut text = format!("#version 450\n#define SKY_IMAGE {sky_image}\nconst uint LIGHT_COUNT = 3u;\n");
        for table in ["lights", "light_alias", "sky", "sky_texels", "sky_alias"] {
            text += &format!("uvec4 {table}_row(uint i) {{ return uvec4(i); }}\n");
        }
        text += include_str!("../../shaders/core/math.glsl");
        text += include_str!("../../shaders/core/trig.glsl");
        text += include_str!("../../shaders/core/frame.glsl");
        text += include_str!("../../shaders/core/warp.glsl");
        text += &LightRecord::glsl_struct();
        text += &LightRecord::glsl_loader("lights");
        text += &SkyRecord::glsl_struct();
        text += &SkyRecord::glsl_loader("sky");
        text += &SkyTexelRecord::glsl_struct();
        text += &SkyTexelRecord::glsl_loader("sky_texels");
        text += include_str!("../../shaders/light/choose.glsl");
        text += include_str!("../../shaders/light/triangle.glsl");
        text += include_str!("../../shaders/light/sphere.glsl");
        text += include_str!("../../shaders/light/sky.glsl");
        text + "void main() {}\n"
    }

    #[test]
    fn the_kernels_text_compiles_with_and_without_an_image() {
        let compiler = shaderc::Compiler::new().unwrap();
        for sky_image in [0, 1] {
            let kind = shaderc::ShaderKind::Compute;
            let result = compiler.compile_into_spirv(&glsl(sky_image), kind, "light", "main", None);
            assert!(result.is_ok(), "{}", result.err().unwrap());
        }
    }
}
