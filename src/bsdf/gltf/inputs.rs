//! What scenes can set of glTF's surface, in the order that `Gltf::from_inputs` and `gltf_params` take it, and which parts of the
//! shader's text each of it needs.

use crate::bsdf::{Input, Model, Shared, When, coat, ggx_albedo, shared};

pub const MODEL: Model = Model {
    keyword: "gltf",
    glsl_type: "Gltf",
    inputs: &[
        Input::color(
            "base_color",
            [1.0; 3],
            (0.0, 1.0),
            "albedo of the dielectric, reflectance of the metal at normal incidence, linear RGB",
        ),
        Input::scalar("metallic", 1.0, (0.0, 1.0), "0 dielectric, 1 metal"),
        Input::scalar("roughness", 1.0, (0.0, 1.0), "0 smooth, 1 rough; GGX alpha = roughness^2"),
        Input::scalar("ior", 1.5, (0.0, 10.0), "index of refraction of the dielectric; 0: reflects everything").index(),
        Input::scalar("transmission", 0.0, (0.0, 1.0), "share of the dielectric's base that lets light through"),
        Input::scalar("thin", 1.0, (0.0, 1.0), "1: thin wall, light is not refracted; 0: boundary of a volume"),
        Input::scalar("khronos_mix", 0.0, (0.0, 1.0), "1: the specification's formula, which can create energy"),
        Input::scalar("compensation", 1.0, (0.0, 1.0), "1: give back what the metal's facets scatter more than once"),
        Input::scalar("specular", 1.0, (0.0, 1.0), "strength of the dielectric's reflection"),
        Input::color(
            "specular_color",
            [1.0; 3],
            (0.0, 100.0),
            "factor on the dielectric's reflectance at normal incidence, linear RGB; their product is cut at 1",
        ),
        Input::scalar("anisotropy", 0.0, (0.0, 1.0), "widens alpha along a direction to mix(alpha, 1, anisotropy^2)"),
        Input::scalar(
            "anisotropy_rotation",
            0.0,
            (-100.0, 100.0),
            "turn of that direction from the tangent to the bitangent, radian",
        ),
        Input::color(
            "anisotropy_direction",
            [1.0, 0.5, 1.0],
            (0.0, 1.0),
            "r, g: the direction before its turn, (1 + x)/2 and (1 + y)/2; b: factor on anisotropy",
        ),
        Input::scalar("clearcoat", 0.0, (0.0, 1.0), "presence of a clear coat"),
        Input::scalar("clearcoat_roughness", 0.0, (0.0, 1.0), "roughness of the coat"),
    ],
    transmits: true,
    transmission_input: Some("transmission"),
    tables: &["ggx_albedo"],
    macros: &[
        ("GLTF_TRANSMISSION", When::NotZero(&["transmission"])),
        ("GLTF_KHRONOS_MIX", When::NotZero(&["khronos_mix"])),
        ("GLTF_COMPENSATION", When::NotZero(&["compensation"])),
        ("GLTF_SPECULAR", When::NotDefault(&["specular", "specular_color"])),
        ("GLTF_ANISOTROPY", When::NotZero(&["anisotropy"])),
        ("GLTF_CLEARCOAT", When::NotZero(&["clearcoat"])),
    ],
    shared: &[
        shared("bsdf/fresnel.glsl"),
        shared("bsdf/ggx.glsl"),
        ggx_albedo::SHARED,
        Shared { only_with: Some("GLTF_CLEARCOAT"), ..coat::SHARED },
        shared("bsdf/gltf_params.glsl"),
        shared("bsdf/gltf_layers.glsl"),
    ],
    doc: "glTF 2.0 metallic-roughness with ior, specular, anisotropy, clearcoat, transmission, volume",
};
