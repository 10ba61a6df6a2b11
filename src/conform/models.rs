//! Gate 7 on every sample model of the assets: the device against the independent oracle, a row a model.
//!
//! The rows run when the filter says "models" (`steradian conform --filter models`, or "models fox" for one); else a single row
//! counts them as skipped. Small images: a model is a check of the reader and of what its materials ask for, not of statistics.
//! Squares of 4 x 4 pixels are compared, so that the few blocks of a pixel do not decide; each row states the bias it would find.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::images;
use super::report::{Gate, GateRow, Verdict, is_wanted};
use super::subject::Subject;
use crate::integrator::Estimator;
use crate::scene::{self, Pixels, Scene, SkyRadiance};

const SIZE: u32 = 48;
const SPP: u32 = 64;
/// Pixels on a side of what one test sees.
const SIDE: u32 = 4;
/// Radiance that the sky's texels are cut at: light that glass throws from the sun is found by chance, and would hide every bias.
const BRIGHTEST: f32 = 4.0;
/// The sky that models stand under, below the assets folder.
pub const SKY: &str = "hdri/kloppenheim_05_1k.hdr";

/// Where the assets are: STERADIAN_ASSETS, else beside the repository.
pub fn folder() -> PathBuf {
    std::env::var_os("STERADIAN_ASSETS").map_or_else(|| PathBuf::from("../shared/assets"), PathBuf::from)
}

/// The model files below `folder`/gltf, in the order of their names.
pub fn list(folder: &Path) -> Vec<PathBuf> {
    let (mut found, mut open) = (Vec::new(), vec![folder.join("gltf")]);
    while let Some(folder) = open.pop() {
        for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
            let path = entry.path();
            match path.extension().and_then(|e| e.to_str()) {
                _ if path.is_dir() => open.push(path),
                Some("gltf" | "glb") => found.push(path),
                _ => {}
            }
        }
    }
    found.sort_by_key(|path| path.file_name().map(|n| n.to_ascii_lowercase()));
    found
}

/// The model at a size, framed, under the sky of `folder`.
pub fn framed(path: &Path, folder: &Path, size: [u32; 2]) -> Result<Scene, scene::Error> {
    let mut scene = scene::load(path)?;
    let sky = scene::format::image_file::read_sky(&folder.join(SKY), &mut scene.notes)?;
    scene.images.push(sky);
    let radiance = SkyRadiance::Image(scene.images.len() - 1);
    scene.sky = Some(scene::Sky { radiance, rotation_rad: 0.6, scale: 1.0 });
    [scene.film.width, scene.film.height] = size;
    scene.name = path.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
    scene::frame_camera(&mut scene);
    Ok(scene)
}

/// Turns the view of a model that is flat, and whose file has no camera, to its front: such models are cards with something on them.
pub fn face(path: &Path, scene: &mut Scene) -> Result<(), scene::Error> {
    /// Depth over the larger of width and height, below which a model is a card.
    const FLAT: f64 = 0.35;
    let has_camera = scene::load(path)?.camera.is_placed;
    let is_flat = scene::bounds(scene).is_some_and(|(low, high)| {
        let size = high - low;
        size.z < FLAT * size.x.max(size.y)
    });
    if is_flat && !has_camera {
        scene.camera.is_placed = false;
        scene::frame_camera_from(scene, 0.0, 0.0);
    }
    Ok(())
}

/// The rows that `filter` names.
pub fn rows(subject: &Subject, filter: &str) -> Vec<GateRow> {
    let folder = folder();
    let models = list(&folder);
    if !filter.contains("models") {
        let evidence = match models.len() {
            0 => "skipped: no assets".to_owned(),
            count => format!("skipped: {count} sample models, which --filter models runs"),
        };
        let row = GateRow {
            gate: Gate::Images,
            name: "models".into(),
            verdict: Verdict::Skip,
            evidence,
            bound: "STERADIAN_ASSETS".into(),
        };
        return [row].into_iter().filter(|r| r.is_wanted(filter)).collect();
    }
    let name =
        |path: &Path| format!("models {}", path.file_stem().unwrap_or_default().to_string_lossy()).to_ascii_lowercase();
    let wanted = models.iter().filter(|path| is_wanted(Gate::Images, &name(path), &filter.to_ascii_lowercase()));
    wanted
        .map(|path| {
            let run = || {
                let mut scene =
                    framed(path, &folder, [SIZE; 2]).map_err(|e| crate::error::Error::Scene(e.to_string()))?;
                if let Some(Pixels::RgbF32(texels)) = scene.images.last_mut().map(|sky| &mut sky.pixels) {
                    let texels: &mut Vec<f32> = Arc::make_mut(texels);
                    texels.iter_mut().for_each(|x| *x = x.min(BRIGHTEST));
                }
                let oracle = images::oracle(&scene, SPP);
                images::against_oracle_in(subject, &scene, Estimator::Mis, &oracle, SIDE)
            };
            let row = run().unwrap_or_else(|e: crate::error::Error| {
                GateRow::new(Gate::Images, "", false, e.to_string(), "the row runs")
            });
            GateRow { name: name(path), ..row }
        })
        .collect()
}
