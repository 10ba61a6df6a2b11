//! The rows of gates 6, 7 and 8: which scenes, which estimators, how many samples.

use rayon::prelude::*;

use super::report::{Gate, GateRow, Verdict, is_wanted};
use super::subject::Subject;
use super::{aov, camera, cosine, film, images, ledger, models, replay, superposition};
use crate::error::Error;
use crate::integrator::{Estimator, Settings};
use crate::reference::{known, known_nested, meters, scenes};
use crate::scene::Scene;

/// Size of the images: `SMALL` for continuous integration, `FULL` by command.
#[derive(Clone, Copy, Debug)]
pub struct Scale {
    pub size: u32,
    pub spp: u32,
    pub closed_form_spp: u32,
}

pub const SMALL: Scale = Scale { size: 64, spp: 256, closed_form_spp: 4096 };
pub const FULL: Scale = Scale { size: 128, spp: 1024, closed_form_spp: 16384 };

/// Models under the HDR sky, below the assets folder.
const MODELS: [&str; 3] = [
    "gltf/FlightHelmet/FlightHelmet.gltf",
    "gltf/GlassHurricaneCandleHolder/GlassHurricaneCandleHolder.glb",
    "gltf/NormalTangentTest/NormalTangentTest.glb",
];

type Run<'a> = Box<dyn Fn(&Subject) -> Result<GateRow, Error> + Send + Sync + 'a>;

/// Runs the rows that `filter` names; each is given to `seen` when it is done.
pub fn rows(subject: &Subject, filter: &str, scale: Scale, seen: &(dyn Fn(&GateRow) + Sync)) -> Vec<GateRow> {
    let scenes = scenes::all(scale.size);
    let (mut models, missing) = some_models(scale.size);
    models.push(scenes::mipmapped(scale.size));
    let known: Vec<known::Known> = known::all().into_iter().chain(meters::all()).chain(known_nested::all()).collect();
    let aov_scenes = [
        scenes::alpha_sheets(32),
        scenes::textured(32),
        scenes::materials(32),
        scenes::lights::lamps(32),
        scenes::lights::suns(32),
    ];
    let grouped = [scenes::lights::lamps(scale.size), scenes::lights::glowing(scale.size)];
    let cameras = camera::scenes(scale.size / 2);
    let losses = ledger::losses();
    let deep = known::deep_furnace();
    let mut list: Vec<(Gate, String, Run)> = Vec::new();
    for scene in scenes.iter().chain(&models).chain(&cameras) {
        let row = move |s: &Subject| replay::row(s, scene, &Settings::default());
        list.push((Gate::Replay, format!("replay {}", scene.name), Box::new(row)));
    }
    for loss in &losses {
        let row = move |s: &Subject| ledger::row(s, loss);
        list.push((Gate::Replay, format!("ledger {}", loss.name), Box::new(row)));
    }
    for known in &known {
        let row = move |s: &Subject| images::closed_form(s, known, Estimator::Mis, scale.closed_form_spp);
        list.push((Gate::Images, format!("closed form {}", known.name), Box::new(row)));
    }
    let row = |s: &Subject| images::closed_form(s, &deep, Estimator::Mis, scale.spp);
    list.push((Gate::Images, format!("closed form {}", deep.name), Box::new(row)));
    let law = move |s: &Subject| cosine::row(s, scale.closed_form_spp);
    list.push((Gate::Images, cosine::NAME.to_owned(), Box::new(law)));
    for scene in &aov_scenes {
        list.push((Gate::Replay, format!("aov replay {}", scene.name), Box::new(move |s| aov::replay(s, scene))));
        list.push((Gate::Images, format!("aov image {}", scene.name), Box::new(move |s| aov::image(s, scene))));
    }
    for (name, filter) in film::step_edges() {
        let row = move |s: &Subject| film::step_edge(s, filter, scale.closed_form_spp);
        list.push((Gate::Images, name, Box::new(row)));
    }
    for scene in scenes.iter().chain(&models).chain(&cameras) {
        let row = move |s: &Subject| {
            let oracle = images::oracle(scene, scale.spp);
            images::against_oracle(s, scene, Estimator::Mis, &oracle)
        };
        list.push((Gate::Images, format!("image {}", scene.name), Box::new(row)));
    }
    for scene in &scenes {
        for other in [Estimator::Bsdf, Estimator::Light] {
            if other == Estimator::Bsdf && scene.has_delta_lights() {
                continue;
            }
            let row = move |s: &Subject| images::estimators(s, scene, other, scale.spp);
            list.push((Gate::Images, format!("estimators {} {other:?}", scene.name).to_lowercase(), Box::new(row)));
        }
    }
    let row = move |s: &Subject| superposition::row(s, &scenes::lights::lamps(scale.size), scale.spp);
    list.push((Gate::Images, "superposition lamps".to_owned(), Box::new(row)));
    for scene in &grouped {
        let row = move |s: &Subject| superposition::groups_row(s, scene, scale.spp);
        list.push((Gate::Images, format!("light groups {}", scene.name), Box::new(row)));
    }
    for scene in scenes.iter().chain(&models).chain(&cameras) {
        let row = move |s: &Subject| images::specialised(s, scene, 16);
        list.push((Gate::Specialised, format!("specialised {}", scene.name), Box::new(row)));
    }
    let run = |(gate, name, run): (Gate, String, Run)| {
        let row = run(subject).unwrap_or_else(|e| GateRow::new(gate, name, false, e.to_string(), "the row runs"));
        seen(&row);
        row
    };
    list.retain(|(gate, name, _)| is_wanted(*gate, name, filter));
    // Gate 8 is compilers at work, each on one core: several rows at a time.
    let (of_kernels, others): (Vec<_>, Vec<_>) = list.into_iter().partition(|(gate, ..)| *gate == Gate::Specialised);
    let mut rows: Vec<GateRow> = others.into_iter().map(run).collect();
    rows.par_extend(of_kernels.into_par_iter().map(run));
    for (file, fault) in missing {
        let name = format!("image {file}");
        if is_wanted(Gate::Images, &name, filter) {
            let verdict = if fault.is_some() { Verdict::Fail } else { Verdict::Skip };
            let (evidence, bound) = (fault.unwrap_or("skipped: no assets".to_owned()), "STERADIAN_ASSETS".to_owned());
            let row = GateRow { gate: Gate::Images, name, verdict, evidence, bound };
            seen(&row);
            rows.push(row);
        }
    }
    for row in models::rows(subject, filter) {
        seen(&row);
        rows.push(row);
    }
    rows
}

/// The models that are there, framed and lit; the names of the rest, each with why it does not load where its file is there.
fn some_models(size: u32) -> (Vec<Scene>, Vec<(String, Option<String>)>) {
    let folder = models::folder();
    let (mut found, mut missing) = (Vec::new(), Vec::new());
    for file in MODELS {
        match models::framed(&folder.join(file), &folder, [size; 2]) {
            Ok(scene) => found.push(scene),
            // A file that is there and does not load is a fault of the loader: its row fails and is not skipped.
            Err(why) => missing.push((file.to_owned(), folder.join(file).exists().then(|| why.to_string()))),
        }
    }
    (found, missing)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::conform::subject::Fault;
    use crate::gpu::Device;
    use crate::shader::compile::Edit;

    /// By hand: `FILTER="gate 7" cargo test --lib conform::paths -- --ignored --nocapture`; EDIT="file|from|to" changes the text.
    #[test]
    #[ignore = "prints the rows of gates 6 to 9 on the first Vulkan device"]
    fn print_rows() {
        let filter = std::env::var("FILTER").unwrap_or_default();
        let device = Device::open(&crate::gpu::Choice::Auto, &crate::gpu::Options::default()).unwrap();
        let fault = std::env::var("EDIT").ok().map(|edit| {
            let parts: Vec<&'static str> = edit.leak().split('|').collect();
            Fault::Text(Edit { file: parts[0], from: parts[1], to: parts[2] })
        });
        let mut all = rows(&Subject { fault, ..Subject::new(&device) }, &filter, SMALL, &|_| ());
        if fault.is_none() {
            all.extend(super::super::mutations::rows(&device, &filter));
        }
        for r in &all {
            println!("{:?} gate {} {}: {}  [{}]", r.verdict, r.gate.number(), r.name, r.evidence, r.bound);
        }
    }
}
