//! Generated GLSL: pattern functions and the choice among the kinds a scene has. A single kind is a direct call.

use crate::bsdf::{self, InputKind};
use crate::camera;
use crate::light::{KINDS, Kind, Reach};
use crate::prepare::features::Features;
use crate::prepare::pattern::{Role, Structure};

/// `pattern_constant` and `pattern_uv`, which the pattern functions read their rows with.
const PATTERN_HEAD: &str = "\
vec4 pattern_constant(uint row) {
    return uintBitsToFloat(material_data_row(row));
}

vec2 pattern_uv(vec2 uv, uint row) {
    vec4 t = pattern_constant(row);
    vec4 m = pattern_constant(row + 1u);
    return vec2(m.x * uv.x + m.y * uv.y + t.y, m.z * uv.x + m.w * uv.y + t.z);
}

// By what `pattern_uv` scales areas.
float pattern_uv_scale(uint row) {
    vec4 m = pattern_constant(row + 1u);
    return abs(m.x * m.w - m.y * m.z);
}
";

/// The struct of lobe slots: one a model kind in the scene, and which of them the material uses.
fn lobes(f: &Features) -> String {
    let mut text = "struct Lobes {\n    uint kind;\n".to_owned();
    for &b in &f.bsdfs {
        text += &format!("    {} {};\n", bsdf::MODELS[b].glsl_type, bsdf::MODELS[b].keyword);
    }
    text += "};\n\nLobes lobes_default() {\n    Lobes l;\n    l.kind = 0u;\n";
    for &b in &f.bsdfs {
        let model = &bsdf::MODELS[b];
        let defaults: Vec<String> = model
            .inputs
            .iter()
            .map(|i| match i.kind {
                InputKind::Scalar => float(i.default[0]),
                InputKind::Color => {
                    format!("Spectrum({}, {}, {})", float(i.default[0]), float(i.default[1]), float(i.default[2]))
                }
            })
            .collect();
        text += &format!("    l.{0} = {0}_params({1});\n", model.keyword, defaults.join(", "));
    }
    text + "    return l;\n}\n\n"
}

fn float(x: f64) -> String {
    format!("{:?}", x as f32)
}

/// One function for each structure, then `material_lobes`, `material_emission`, `material_alpha`, `material_normal`.
pub fn patterns(f: &Features) -> String {
    let mut text = PATTERN_HEAD.to_owned() + "\n" + &lobes(f);
    let mut cases: [Vec<(usize, String)>; 4] = Default::default();
    for (number, structure) in f.structures.iter().enumerate() {
        let (signature, role) = match structure.role {
            Role::Bsdf(_) => (format!("void pattern_{number}(uint data, SurfacePoint point, inout Lobes l)"), 0),
            Role::Emission => (format!("Spectrum pattern_{number}(uint data, SurfacePoint point)"), 1),
            Role::Alpha => (format!("float pattern_{number}(uint data, SurfacePoint point)"), 2),
            Role::Normal => (format!("vec3 pattern_{number}(uint data, SurfacePoint point)"), 3),
        };
        text += &format!("{signature} {{\n{}}}\n\n", body(structure, f.texture_mips));
        cases[role].push((number, format!("pattern_{number}")));
    }
    text += &choice(
        "Lobes material_lobes(MaterialRecord m, SurfacePoint point)",
        "Lobes r = lobes_default();\n    r.kind = m.bsdf;",
        "m.pattern",
        &cases[0],
        |call| format!("{call}(m.data, point, r);"),
    );
    let roles = [
        ("Spectrum material_emission", "Spectrum r = Spectrum(0.0);", "emission", f.emission),
        ("float material_alpha", "float r = 1.0;", "alpha", f.alpha),
        ("vec3 material_normal", "vec3 r = vec3(0.0, 0.0, 1.0);", "normal", f.normal_maps),
    ];
    for (role, (name, init, key, is_needed)) in roles.into_iter().enumerate() {
        if is_needed {
            text += &choice(
                &format!("{name}(MaterialRecord m, SurfacePoint point)"),
                init,
                &format!("m.{key}_pattern"),
                &cases[role + 1],
                |call| format!("r = {call}(m.{key}_data, point);"),
            );
        }
    }
    text
}

fn body(structure: &Structure, has_footprints: bool) -> String {
    let (mut text, outputs) = structure.glsl(has_footprints);
    match structure.role {
        Role::Bsdf(model) => {
            let model = &bsdf::MODELS[model];
            let arguments: Vec<String> = outputs
                .iter()
                .zip(model.inputs)
                .map(|(o, i)| format!("{o}.{}", if i.kind == InputKind::Scalar { "x" } else { "xyz" }))
                .collect();
            text += &format!("    l.{0} = {0}_params({1});\n", model.keyword, arguments.join(", "));
        }
        Role::Emission => text += &format!("    return {}.xyz;\n", outputs[0]),
        Role::Alpha => text += &format!("    return {}.x;\n", outputs[0]),
        Role::Normal => text += &format!("    return 2.0 * {}.xyz - 1.0;\n", outputs[0]),
    }
    text
}

/// A function that initialises `r`, does the case that `key` names, and returns `r`. One case needs no test of the key, unless a
/// material may have none of the role.
fn choice(signature: &str, init: &str, key: &str, cases: &[(usize, String)], act: impl Fn(&str) -> String) -> String {
    let mut text = format!("{signature} {{\n    {init}\n");
    match cases {
        [(_, call)] if key == "m.pattern" => text += &format!("    {}\n", act(call)),
        _ => {
            for (number, call) in cases {
                text += &format!("    if ({key} == {number}u) {{\n        {}\n    }}\n", act(call));
            }
        }
    }
    text + "    return r;\n}\n\n"
}

/// Turns directions along the surface for a frame whose y points against the bitangent.
const MIRROR: &str = "\
#if GLTF_ANISOTROPY
void lobes_mirror(inout Lobes l, bool is_mirrored) {
    l.gltf.along.y *= is_mirrored ? -1.0 : 1.0;
}
#endif

";

/// `bsdf_eval`, `bsdf_pdf`, `bsdf_sample`, `bsdf_albedo`, `bsdf_is_delta` over the kinds in the scene.
pub fn bsdfs(f: &Features) -> String {
    let functions = [
        ("Spectrum bsdf_eval(Lobes l, vec3 wo, vec3 wi)", "Spectrum(0.0)", "eval", ", wo, wi"),
        ("float bsdf_pdf(Lobes l, vec3 wo, vec3 wi)", "0.0", "pdf", ", wo, wi"),
        (
            "BsdfSample bsdf_sample(Lobes l, vec3 wo, uint choice, vec2 u)",
            "bsdf_sample_none()",
            "sample",
            ", wo, choice, u",
        ),
        ("Spectrum bsdf_albedo(Lobes l)", "Spectrum(0.0)", "albedo", ""),
        ("bool bsdf_is_delta(Lobes l)", "false", "is_delta", ""),
    ];
    let mut text = MIRROR.to_owned();
    for (signature, default, function, arguments) in functions {
        let call = |b: usize| {
            let keyword = bsdf::MODELS[b].keyword;
            format!("{keyword}_{function}(l.{keyword}{arguments})")
        };
        let kind = signature.split(' ').next().expect("a signature begins with its type");
        text += &format!("{signature} {{\n");
        match f.bsdfs[..] {
            [only] => text += &format!("    return {};\n}}\n\n", call(only)),
            _ => {
                text += &format!("    {kind} r = {default};\n");
                for &b in &f.bsdfs {
                    let constant = bsdf::MODELS[b].keyword.to_uppercase();
                    text += &format!("    if (l.kind == BSDF_{constant}) {{\n        r = {};\n    }}\n", call(b));
                }
                text += "    return r;\n}\n\n";
            }
        }
    }
    text
}

/// `light_connect`, `light_density` over the kinds that are sampled, `light_background` over those a ray leaving the scene sees.
pub fn lights(f: &Features) -> String {
    let sampled = || f.lights.iter().map(|&k| &KINDS[k]);
    let on_surfaces: Vec<&Kind> = sampled().filter(|k| matches!(k.reach, Reach::Surface(_))).collect();
    let mut text = String::new();
    if f.next_event() {
        let kinds: Vec<&Kind> = sampled().collect();
        let signature = "LightSample light_connect(PathState s, LightRecord light, vec3 p, vec2 u)";
        text += &light_choice(signature, "light_sample_none()", &kinds, "connect(s, light, p, u)");
    }
    if !on_surfaces.is_empty() {
        let signature = "float light_density(LightRecord light, vec3 p, vec3 wi, float distance, bool is_front)";
        text += &light_choice(signature, "0.0", &on_surfaces, "density(light, p, wi, distance, is_front)");
    }
    let terms: Vec<String> = f.backgrounds().map(|k| format!("{}_light_arriving(s)", KINDS[k].keyword)).collect();
    if !terms.is_empty() {
        text += &format!("Spectrum light_background(PathState s) {{\n    return {};\n}}\n\n", terms.join(" + "));
    }
    text
}

/// One kind is a direct call.
fn light_choice(signature: &str, default: &str, kinds: &[&Kind], call: &str) -> String {
    let mut text = format!("{signature} {{\n");
    if let [only] = kinds {
        return text + &format!("    return {}_light_{call};\n}}\n\n", only.keyword);
    }
    let kind = signature.split(' ').next().expect("a signature begins with its type");
    text += &format!("    {kind} r = {default};\n");
    for k in kinds {
        text += &format!("    if (light.kind == {}) {{\n        r = {}_light_{call};\n    }}\n", k.constant, k.keyword);
    }
    text + "    return r;\n}\n\n"
}

/// `camera_ray` over the kinds in the text: the scene's own, unless everything is on.
pub fn cameras(f: &Features) -> String {
    let call = |k: usize| format!("{}_ray(camera, film, id)", camera::MODELS[k].keyword);
    let mut text = "CameraRay camera_ray(CameraRecord camera, vec2 film, SampleId id) {\n".to_owned();
    match f.cameras[..] {
        [only] => text += &format!("    return {};\n}}\n", call(only)),
        _ => {
            text += "    CameraRay r = camera_plain(vec3(0.0), camera.forward);\n";
            for &k in &f.cameras {
                text += &format!("    if (camera.kind == {k}u) {{\n        r = {};\n    }}\n", call(k));
            }
            text += "    return r;\n}\n";
        }
    }
    text
}
