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

/// The struct of lobe slots: one a model kind in the scene, and which of them the material uses; or, where some material mixes
/// surfaces, one a kind and as many more as a mixture has of it, their shares, and the word that picks one.
fn lobes(f: &Features) -> String {
    let mut text = "struct Lobes {\n    uint kind;\n".to_owned();
    for &lobe in &f.lobes {
        text += &format!("    {} {};\n", bsdf::MODELS[lobe.0].glsl_type, slot(lobe));
        if f.mixtures {
            text += &format!("    float share_{};\n", slot(lobe));
        }
    }
    text += if f.mixtures { "    uint pick;\n" } else { "" };
    text += "};\n\nLobes lobes_default() {\n    Lobes l;\n    l.kind = 0u;\n";
    for &lobe in &f.lobes {
        let model = &bsdf::MODELS[lobe.0];
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
        text += &format!("    l.{} = {}_params({});\n", slot(lobe), model.keyword, defaults.join(", "));
        if f.mixtures {
            text += &format!("    l.share_{} = 0.0;\n", slot(lobe));
        }
    }
    text += if f.mixtures { "    l.pick = 0u;\n" } else { "" };
    text + "    return l;\n}\n\n"
}

/// Name of a slot of `Lobes`.
fn slot((model, number): (usize, usize)) -> String {
    let keyword = bsdf::MODELS[model].keyword;
    if number == 0 { keyword.to_owned() } else { format!("{keyword}_{number}") }
}

fn float(x: f64) -> String {
    format!("{:?}", x as f32)
}

/// One function for each structure, then `material_lobes`, `material_emission`, `material_alpha`, `material_normal`.
pub fn patterns(f: &Features) -> String {
    let mut text = PATTERN_HEAD.to_owned() + "\n" + &lobes(f);
    let mut cases: [Vec<(usize, String)>; 4] = Default::default();
    // In a medium, indices of refraction are those relative to it.
    let (outside, argument) = if f.media_stack { (", float outside", ", outside") } else { ("", "") };
    for (number, structure) in f.structures.iter().enumerate() {
        let (signature, role) = match &structure.role {
            Role::Bsdf(_) | Role::Mix(_) => {
                (format!("void pattern_{number}(uint data, SurfacePoint point{outside}, inout Lobes l)"), 0)
            }
            Role::Emission => (format!("Spectrum pattern_{number}(uint data, SurfacePoint point)"), 1),
            Role::Alpha => (format!("float pattern_{number}(uint data, SurfacePoint point)"), 2),
            Role::Normal => (format!("vec3 pattern_{number}(uint data, SurfacePoint point)"), 3),
        };
        text += &format!("{signature} {{\n{}}}\n\n", body(structure, f));
        cases[role].push((number, format!("pattern_{number}")));
    }
    text += &choice(
        &format!("Lobes material_lobes(MaterialRecord m, SurfacePoint point{outside})"),
        "Lobes r = lobes_default();\n    r.kind = m.bsdf;",
        "m.pattern",
        &cases[0],
        |call| format!("{call}(m.data, point{argument}, r);"),
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

fn body(structure: &Structure, f: &Features) -> String {
    let (mut text, outputs) = structure.glsl(f.texture_mips);
    match &structure.role {
        Role::Bsdf(_) | Role::Mix(_) => {
            let is_mixture = matches!(structure.role, Role::Mix(_));
            let mut at = 0;
            for lobe in structure.lobes() {
                let model = &bsdf::MODELS[lobe.0];
                let arguments: Vec<String> = outputs[at..]
                    .iter()
                    .zip(model.inputs)
                    .map(|(o, i)| {
                        let relative = if f.media_stack && i.is_index { " / outside" } else { "" };
                        format!("{o}.{}{relative}", if i.kind == InputKind::Scalar { "x" } else { "xyz" })
                    })
                    .collect();
                at += model.inputs.len();
                text += &format!("    l.{} = {}_params({});\n", slot(lobe), model.keyword, arguments.join(", "));
                if is_mixture {
                    text += &format!("    l.share_{} = {}.x;\n", slot(lobe), outputs[at]);
                    at += 1;
                } else if f.mixtures {
                    text += &format!("    l.share_{} = 1.0;\n", slot(lobe));
                }
            }
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
fn mirror(f: &Features) -> String {
    let gltf = f.lobes.iter().filter(|l| bsdf::MODELS[l.0].keyword == "gltf");
    let lines: String = gltf.map(|l| format!("    l.{}.along.y *= is_mirrored ? -1.0 : 1.0;\n", slot(*l))).collect();
    format!("#if GLTF_ANISOTROPY\nvoid lobes_mirror(inout Lobes l, bool is_mirrored) {{\n{lines}}}\n#endif\n\n")
}

/// The same five functions where surfaces may be mixed: sums over all slots by their shares. A model that knows no inside sees
/// both directions mirrored from below.
fn mixtures(f: &Features) -> String {
    let each = |line: &dyn Fn(&str, &str, &str) -> String| -> String {
        let of = |l: &(usize, usize)| {
            let model = &bsdf::MODELS[l.0];
            let up = if f.transmission && !model.transmits { " * up" } else { "" };
            line(&slot(*l), model.keyword, up)
        };
        f.lobes.iter().map(of).collect()
    };
    let up = if f.transmission { "    vec3 up = vec3(1.0, 1.0, wo.z < 0.0 ? -1.0 : 1.0);\n" } else { "" };
    let sum = |signature: &str, kind: &str, head: &str, line: &dyn Fn(&str, &str, &str) -> String| {
        format!("{kind} {signature} {{\n    {kind} r = {kind}(0.0);\n{head}{}    return r;\n}}\n\n", each(line))
    };
    let mut text = sum("bsdf_eval(Lobes l, vec3 wo, vec3 wi)", "Spectrum", up, &|s, k, up| {
        format!("    r += l.share_{s} * {k}_eval(l.{s}, wo{up}, wi{up});\n")
    });
    text += &sum("bsdf_pdf(Lobes l, vec3 wo, vec3 wi)", "float", up, &|s, k, up| {
        format!("    r += l.share_{s} * {k}_pdf(l.{s}, wo{up}, wi{up});\n")
    });
    text += "BsdfSample bsdf_sample(Lobes l, vec3 wo, uint choice, vec2 u) {\n    BsdfSample r = bsdf_sample_none();\n    \
             BsdfSample s;\n    float up_to = 0.0;\n    bool is_taken = false;\n";
    text += up;
    text += &each(&|s, k, up| {
        let turn = if up.is_empty() { String::new() } else { "    s.wi *= up;\n".to_owned() };
        format!(
            "    s = {k}_sample(l.{s}, wo{up}, choice, u);\n{turn}    s.pdf *= l.share_{s};\n    up_to += l.share_{s};\n    \
             if (!is_taken && l.share_{s} > 0.0) {{\n        r = s;\n    }}\n    \
             is_taken = is_taken || bsdf_is_chosen(l.pick, up_to);\n"
        )
    });
    text += "    bool is_delta = (r.flags & SAMPLE_DELTA) != 0u;\n    float pdf = bsdf_pdf(l, wo, r.wi);\n    \
             Spectrum weight = pdf > 0.0 ? bsdf_eval(l, wo, r.wi) / pdf : Spectrum(0.0);\n    \
             bool is_summed = !is_delta && r.pdf > 0.0;\n    r.weight = is_summed ? weight : r.weight;\n    \
             r.pdf = is_summed ? pdf : r.pdf;\n    return r;\n}\n\n";
    text +=
        &sum("bsdf_albedo(Lobes l)", "Spectrum", "", &|s, k, _| format!("    r += l.share_{s} * {k}_albedo(l.{s});\n"));
    let deltas = each(&|s, k, _| format!("    r = r && (l.share_{s} == 0.0 || {k}_is_delta(l.{s}));\n"));
    text + &format!("bool bsdf_is_delta(Lobes l) {{\n    bool r = true;\n{deltas}    return r;\n}}\n\n")
}

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
    let mut text = mirror(f);
    if f.mixtures {
        return text + &mixtures(f);
    }
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
    let calls: String = f.backgrounds().map(|k| format!("    {}_light_arriving(s);\n", KINDS[k].keyword)).collect();
    if !calls.is_empty() {
        text += &format!("void light_background(inout PathState s) {{\n{calls}}}\n\n");
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
