//! Gate 9: deliberate faults, each of which a named gate must catch. A gate that cannot fail is no gate.
//!
//! A fault is one replacement in the kernel's text or one change of the records. Its row passes when every check it names fails
//! on it; the same checks pass on the sound kernel in gates 6 to 8. Some faults are unbiased and only a replay sees them; faults
//! of the records are the same for device and replay, and only the independent oracle sees them: the table says which.

use std::collections::HashMap;

use super::aov;
use super::camera;
use super::images;
use super::replay;
use super::report::{Gate, GateRow, Verdict, is_wanted};
use super::subject::{Fault, Subject};
use super::superposition;
use crate::error::Error;
use crate::film::Film;
use crate::film::slot::BLOCK_SAMPLES;
use crate::gpu::Device;
use crate::integrator::{Estimator, Settings};
use crate::prepare::Prepared;
use crate::prepare::records::{NONE, TEXTURE_MIPS, TEXTURE_SRGB};
use crate::reference::known::{self, Known};
use crate::reference::known_nested;
use crate::reference::meters;
use crate::reference::scenes::{self, lights};
use crate::scene::Scene;
use crate::shader::compile::Edit;
use crate::texture;

/// A check that must fail on the fault.
#[derive(Clone, Copy)]
enum Check {
    /// Gate 6 on a scene.
    Replay(fn(u32) -> Scene),
    /// Gate 7 against the independent oracle.
    Image(fn(u32) -> Scene),
    /// Gate 6 of the AOVs.
    Aov(fn(u32) -> Scene),
    /// Gate 7 of the light groups.
    Groups(fn(u32) -> Scene),
    /// Gate 7 against a closed form.
    ClosedForm(fn() -> Known),
    /// Gate 8 on a scene.
    Specialised(fn(u32) -> Scene),
}
use Check::{Aov, ClosedForm, Groups, Image, Replay, Specialised};

struct Mutation {
    name: &'static str,
    fault: Fault,
    caught_by: &'static [Check],
}

const fn text(file: &'static str, from: &'static str, to: &'static str) -> Fault {
    Fault::Text(Edit { file, from, to })
}

const MUTATIONS: &[Mutation] = &[
    Mutation {
        name: "odd blocks repeat the sequence of even ones, and two halves seem to agree",
        fault: text("sampler/sobol.glsl", "pixel_index ^ odd", "pixel_index"),
        caught_by: &[Replay(scenes::cornell)],
    },
    Mutation {
        name: "lambert evaluates without its cosine",
        fault: text("bsdf/lambert.glsl", "b.albedo * (INV_PI * wi.z)", "b.albedo * INV_PI"),
        caught_by: &[ClosedForm(known::sphere_lamp), Replay(scenes::cornell), Image(scenes::cornell)],
    },
    Mutation {
        name: "lambert is rho over 2 pi",
        fault: text("bsdf/lambert.glsl", "b.albedo * (INV_PI", "b.albedo * (INV_TWO_PI"),
        caught_by: &[ClosedForm(known::uniform_sky), Image(scenes::cornell)],
    },
    Mutation {
        name: "the density of lambert is halved in both weights, which stays unbiased",
        fault: text(
            "bsdf/lambert.glsl",
            "return is_reflection ? INV_PI * wi.z",
            "return is_reflection ? INV_TWO_PI * wi.z",
        ),
        caught_by: &[Replay(scenes::cornell)],
    },
    Mutation {
        name: "the Jacobian of reflection 1/(4 wo.h) is dropped",
        fault: text(
            "bsdf/ggx.glsl",
            "return vec2(0.5 * d * i.z / (o.z * si + i.z * so), 0.5 * d / (o.z + so));",
            "return vec2(2.0 * d * i.z / (o.z * si + i.z * so), 2.0 * d / (o.z + so));",
        ),
        caught_by: &[Replay(scenes::materials), Image(scenes::materials)],
    },
    Mutation {
        name: "roughness is not squared",
        fault: text(
            "bsdf/ggx.glsl",
            "float x = sqr(clamp(roughness, 0.0, 1.0));",
            "float x = clamp(roughness, 0.0, 1.0);",
        ),
        // Not by the image: at 512 samples the other models leave it too little power (p = 8e-8 at the worst pixel).
        caught_by: &[Replay(scenes::materials)],
    },
    Mutation {
        name: "the factor 1/eta^2 of refraction is missing in samples",
        fault: text("bsdf/dielectric.glsl", "float weight = s.eta_scale * (", "float weight = ("),
        caught_by: &[ClosedForm(known::lamp_in_glass)],
    },
    Mutation {
        name: "what a rough diffuse surface loses is not given back",
        fault: text("bsdf/rough_diffuse.glsl", "value += b.multiple * (", "value += 0.0 * b.multiple * ("),
        caught_by: &[Replay(scenes::layers), Image(scenes::layers)],
    },
    Mutation {
        name: "light passes the coat of plastic once, not twice",
        fault: text("bsdf/plastic.glsl", "float through = shares.z * coat_shares(", "float through = coat_shares("),
        caught_by: &[Replay(scenes::layers)],
    },
    Mutation {
        name: "the surface of a mixture is picked by the word that picks its lobe",
        fault: text("integrator/scatter.glsl", "path_word(s, BSDF_MIX)", "path_word(s, BSDF_LOBE)"),
        caught_by: &[Replay(scenes::mixtures), Image(scenes::mixtures)],
    },
    Mutation {
        name: "rough glass gives back nothing of what it samples",
        fault: text(
            "bsdf/dielectric.glsl",
            "value = b.is_compensated ? vec2(value.x + multiple.x, mix(value.y, multiple.y, lost)) : value;",
            "",
        ),
        caught_by: &[Replay(scenes::materials)],
    },
    Mutation {
        name: "anisotropy does not follow mirrored texture coordinates",
        fault: text("integrator/scatter.glsl", "lobes_mirror(r.lobes, (tangent.w < 0.0) != is_back);", ""),
        caught_by: &[Replay(scenes::layers), Image(scenes::layers)],
    },
    Mutation {
        name: "the weight of light samples is that of the other technique",
        fault: text(
            "integrator/scatter.glsl",
            "mis_weight(light.pdf, bsdf_pdf(shading.lobes, shading.wo, wi))",
            "mis_weight(bsdf_pdf(shading.lobes, shading.wo, wi), light.pdf)",
        ),
        caught_by: &[Replay(scenes::cornell), Image(scenes::cornell)],
    },
    Mutation {
        name: "the probability of the chosen light is left out",
        fault: text("integrator/emission.glsl", "r.pdf *= light_pmf(s.from, s.from_normal, index);", ""),
        caught_by: &[Replay(scenes::sphere_lamps), Image(scenes::sphere_lamps)],
    },
    Mutation {
        name: "the sky is looked up half a texel off",
        fault: text("light/sky.glsl", "vec2 x = sky_position(sky, d) - 0.5;", "vec2 x = sky_position(sky, d);"),
        caught_by: &[ClosedForm(known::turned_sky), ClosedForm(known::mirror_ball), Image(scenes::textured)],
    },
    Mutation {
        name: "survivors of roulette are not divided by their probability",
        fault: text("integrator/scatter.glsl", "s.throughput *= plays ? 1.0 / q : 1.0;", ""),
        caught_by: &[ClosedForm(known::furnace_sphere)],
    },
    Mutation {
        name: "one random dimension is used twice",
        fault: text("integrator/scatter.glsl", "u01(path_word(s, BSDF_V))", "u01(path_word(s, BSDF_U))"),
        caught_by: &[Replay(scenes::cornell), Image(scenes::cornell)],
    },
    Mutation {
        name: "shadow rays reach past the light",
        fault: text(
            "integrator/scatter.glsl",
            "is_candidate ? light.distance : 0.0",
            "is_candidate ? light.distance * 1.02 : 0.0",
        ),
        caught_by: &[Image(scenes::cornell), ClosedForm(known::lights::point_before_a_ball)],
    },
    Mutation {
        name: "media do not absorb",
        fault: text("integrator/state.glsl", "return is_inside ? through : Spectrum(1.0);", "return Spectrum(1.0);"),
        caught_by: &[ClosedForm(known::absorbing_slab)],
    },
    Mutation {
        name: "a path that is in no medium is dimmed where media are compiled in",
        fault: text(
            "integrator/state.glsl",
            "return is_inside ? through : Spectrum(1.0);",
            "return is_inside ? through : Spectrum(0.9);",
        ),
        caught_by: &[Specialised(scenes::cornell)],
    },
    Mutation {
        name: "nothing is left out of the kernel of a scene that needs little",
        fault: Fault::NothingLeftOut,
        caught_by: &[Specialised(scenes::cornell)],
    },
    Mutation {
        name: "light scattered once counts as indirect",
        fault: text("integrator/state.glsl", "edges <= 2u ? light", "edges <= 1u ? light"),
        caught_by: &[Aov(scenes::textured)],
    },
    Mutation {
        name: "sampled light of every group goes to the first",
        fault: text("integrator/scatter.glsl", "LIGHT_GROUP(light_group(light.light))", "LIGHT_GROUP(0u)"),
        caught_by: &[Aov(lights::lamps), Aov(lights::glowing), Groups(lights::glowing)],
    },
    Mutation {
        name: "emission that a path runs into is of its light's neighbour in the list of groups",
        fault: text("integrator/emission.glsl", "LIGHT_GROUP(material.group)", "LIGHT_GROUP(material.group ^ 1u)"),
        caught_by: &[Aov(lights::glowing), Groups(lights::glowing)],
    },
    Mutation {
        name: "suns are of the sky's light group",
        fault: text("light/sun.glsl", "LIGHT_GROUP(light.shape)", "LIGHT_GROUP(SKY_GROUP)"),
        caught_by: &[Aov(lights::suns)],
    },
    Mutation {
        name: "the records of lamps name the first light group",
        fault: Fault::Records(|p| p.lights.iter_mut().filter(|l| l.material == NONE).for_each(|l| l.shape = 0)),
        caught_by: &[Aov(lights::lamps), Groups(lights::lamps)],
    },
    Mutation {
        name: "a nested boundary refracts as if air were outside",
        fault: text(
            "integrator/media.glsl",
            "e.outside = medium_eta(media_current(is_entered ? e.medium : e.beyond));",
            "e.outside = 1.0;",
        ),
        caught_by: &[ClosedForm(known_nested::inside_nested_balls), Replay(scenes::nested)],
    },
    Mutation {
        name: "a boundary inside a body of higher priority is shown",
        fault: text("integrator/media.glsl", "bool is_end = closes ? is_change :", "bool is_end = closes ? true :"),
        caught_by: &[Replay(scenes::nested)],
    },
    Mutation {
        name: "normals go through the matrix, not its inverse transpose",
        fault: Fault::Records(normals_through_the_matrix),
        caught_by: &[Image(scenes::textured)],
    },
    Mutation {
        name: "normals of placed meshes go through the matrix, not its inverse transpose",
        fault: text(
            "bvh/placed.glsl",
            "(n.x * m.to_object0.xyz + n.y * m.to_object1.xyz) + n.z * m.to_object2.xyz",
            "vec3(dot(m.to_world0.xyz, n), dot(m.to_world1.xyz, n), dot(m.to_world2.xyz, n))",
        ),
        caught_by: &[Replay(scenes::placed), Image(scenes::placed)],
    },
    Mutation {
        name: "mirrored placements keep the hand of their tangents",
        fault: text(
            "integrator/surface.glsl",
            "(placed.flags & INSTANCE_MIRRORED) != 0u ? -n0.handedness : n0.handedness",
            "n0.handedness",
        ),
        caught_by: &[Replay(scenes::placed), Image(scenes::placed)],
    },
    Mutation {
        name: "the way into object space turns the wrong way",
        fault: Fault::Records(|p| {
            for r in p.instances.iter_mut().skip(1) {
                (r.to_object0[1], r.to_object1[0]) = (r.to_object1[0], r.to_object0[1]);
            }
        }),
        caught_by: &[Replay(scenes::placed), Image(scenes::placed)],
    },
    Mutation {
        name: "all placements of a mesh look like the first",
        fault: text("integrator/surface.glsl", "            s.material = placed.material;\n", ""),
        caught_by: &[Replay(scenes::placed), Image(scenes::placed)],
    },
    Mutation {
        name: "texture coordinates are half a texel off",
        fault: Fault::Records(shift_texture_coordinates),
        caught_by: &[Image(scenes::textured)],
    },
    Mutation {
        name: "sRGB texels are taken as linear",
        fault: Fault::Records(|p| p.textures.iter_mut().for_each(|t| t.flags &= !TEXTURE_SRGB)),
        caught_by: &[Image(scenes::textured)],
    },
    Mutation {
        name: "footprints are four times too large",
        fault: text("integrator/footprint.glsl", "areas = part *", "areas = 4.0 * part *"),
        caught_by: &[Replay(scenes::mipmapped)],
    },
    Mutation {
        name: "the first smaller level of every texture is black",
        fault: Fault::Records(blacken_levels),
        caught_by: &[Image(scenes::mipmapped)],
    },
    Mutation {
        name: "a point lamp's light does not thin out with the square of the distance",
        fault: text("light/inverse_square.glsl", "1.0 / (is_apart ? d2 : 1.0)", "1.0"),
        caught_by: &[ClosedForm(known::lights::point_lamp), ClosedForm(known::lights::lumen_lamp)],
    },
    Mutation {
        name: "a spot lights what is outside its cone",
        fault: text("light/spot.glsl", "return x > 0.0 ? share : 0.0;", "return x > 0.0 ? 0.0 : share;"),
        caught_by: &[ClosedForm(known::lights::spots_aside), ClosedForm(known::lights::spots)],
    },
    Mutation {
        name: "a light without size shares its weight with the surface's sampling",
        fault: text("integrator/scatter.glsl", "share = light.is_delta ? 1.0 : share;", ""),
        caught_by: &[ClosedForm(known::lights::point_under_sky), Replay(lights::lamps), Image(lights::lamps)],
    },
    Mutation {
        name: "a sun that a path runs into counts as if it were always the light chosen",
        fault: text("light/sun.glsl", " * light_pmf(s.from, s.from_normal, row)", ""),
        caught_by: &[ClosedForm(known::lights::wide_sun)],
    },
    Mutation {
        name: "a sun is half as wide as its record for the paths that run into it",
        fault: text("light/sun.glsl", "0.5 * dot(chord, chord) <= h", "2.0 * dot(chord, chord) <= h"),
        caught_by: &[ClosedForm(known::lights::wide_sun)],
    },
    Mutation {
        name: "a meter's light samples lack their cosine",
        fault: text(
            "integrator/receiver.glsl",
            "float density = dot(light.wi, normal) * INV_PI;",
            "float density = INV_PI;",
        ),
        caught_by: &[ClosedForm(meters::grazing_lamp)],
    },
    Mutation {
        name: "points of a surface meter are chosen without regard to area",
        fault: Fault::Records(|p| {
            p.sensor_alias.iter_mut().for_each(|a| (a.threshold0, a.threshold1) = (u32::MAX, u32::MAX));
        }),
        caught_by: &[ClosedForm(meters::unequal_triangles)],
    },
    Mutation {
        name: "the lens is half as large",
        fault: text("camera/thin_lens.glsl", "* camera.lens;", "* camera.lens * 0.5;"),
        caught_by: &[Replay(camera::thin_lens)],
    },
    Mutation {
        name: "the recorded probabilities of lights are not those of the table",
        fault: Fault::Records(|p| {
            let even = 1.0 / p.lights.len() as f32;
            p.lights.iter_mut().for_each(|l| l.pmf = even);
        }),
        caught_by: &[Image(scenes::sphere_lamps)],
    },
];

/// n = M^-T n0 became M n0 = M M^T n, up to length, for the stretched ball of `scenes::textured`.
fn normals_through_the_matrix(p: &mut Prepared) {
    let m = scenes::stretched_ball().matrix3;
    for record in &mut p.normals {
        let n = glam::DVec3::from(record.normal.map(f64::from));
        record.normal = (m * (m.transpose() * n)).normalize_or_zero().as_vec3().to_array();
    }
}

fn blacken_levels(p: &mut Prepared) {
    for t in p.textures.iter().filter(|t| t.flags & TEXTURE_MIPS != 0) {
        let offsets = p.texels[t.first_row as usize - texture::mip::OFFSET_ROWS];
        let [first, end] = [offsets[1], offsets[2]].map(|o| (t.first_row + o) as usize);
        p.texels[first..end].fill([0; 4]);
    }
}

fn shift_texture_coordinates(p: &mut Prepared) {
    for uv in &mut p.uvs {
        // The image of `scenes::textured` is 8 texels wide and looked up at twice the coordinate.
        uv.uv0[0] += 0.5 / 8.0 / 2.0;
    }
}

/// Image size and samples a pixel of the checks: the smallest at which all faults show by a wide margin.
const SIZE: u32 = 32;
const SPP: u32 = 512;

/// One row a fault.
pub fn rows(device: &Device, filter: &str) -> Vec<GateRow> {
    let mut oracle = HashMap::new();
    let wanted = MUTATIONS.iter().filter(|m| is_wanted(Gate::Mutations, m.name, filter));
    wanted.map(|m| row(device, m, &mut oracle)).collect()
}

fn row(device: &Device, mutation: &Mutation, oracle: &mut HashMap<String, Film>) -> GateRow {
    let subject = Subject::with_fault(device, mutation.fault);
    let outcomes: Vec<Result<GateRow, Error>> =
        mutation.caught_by.iter().map(|check| run(&subject, check, oracle)).collect();
    let is_caught = |o: &Result<GateRow, Error>| matches!(o, Ok(r) if r.verdict == Verdict::Fail);
    let evidence: Vec<String> = outcomes
        .iter()
        .map(|o| match o {
            Ok(r) => format!(
                "{} by gate {} {}: {}",
                if r.verdict == Verdict::Fail { "caught" } else { "NOT caught" },
                r.gate.number(),
                r.name,
                r.evidence
            ),
            Err(e) => format!("could not run: {e}"),
        })
        .collect();
    let is_passed = !outcomes.is_empty() && outcomes.iter().all(is_caught);
    GateRow::new(Gate::Mutations, mutation.name, is_passed, evidence.join("; "), "every named check fails")
}

fn run(subject: &Subject, check: &Check, oracle: &mut HashMap<String, Film>) -> Result<GateRow, Error> {
    match check {
        Aov(scene) => aov::replay(subject, &scene(SIZE)),
        Groups(scene) => superposition::groups_row(subject, &scene(SIZE), SPP),
        Replay(scene) => replay::row(subject, &scene(SIZE), &Settings::default()),
        ClosedForm(known) => images::closed_form(subject, &known(), Estimator::Mis, SPP),
        Specialised(scene) => images::specialised(subject, &scene(SIZE), BLOCK_SAMPLES),
        Image(scene) => {
            let scene = scene(SIZE);
            let film = oracle.entry(scene.name.clone()).or_insert_with(|| images::oracle(&scene, SPP));
            images::against_oracle(subject, &scene, Estimator::Mis, film)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shader::source;

    #[test]
    fn every_text_fault_fits_exactly_once() {
        for m in MUTATIONS {
            if let Fault::Text(edit) = m.fault {
                let text = source::get(edit.file).unwrap();
                assert_eq!(text.matches(edit.from).count(), 1, "{}: \"{}\" in {}", m.name, edit.from, edit.file);
                assert_ne!(edit.from, edit.to);
            }
            assert!(!m.caught_by.is_empty(), "{}", m.name);
        }
        assert!(MUTATIONS.len() >= 10);
    }
}
