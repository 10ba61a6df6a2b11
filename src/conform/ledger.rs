//! Gate 6 for the bias ledger: what a device counts as lost is what both worlds of the oracle count, on scenes where it is known.

use glam::{DAffine3, DVec3};

use super::report::{Gate, GateRow};
use super::subject::Subject;
use crate::error::Error;
use crate::film::slot::{BLOCK_SAMPLES, LEDGER_ALPHA_OVERFLOW};
use crate::integrator::Settings;
use crate::integrator::path::ALPHA_LAYERS;
use crate::reference::independent::Independent;
use crate::reference::known::{camera, lambert, material, place, sphere_at};
use crate::reference::render;
use crate::reference::replay::Replay;
use crate::scene::*;

/// A scene and what its ledger must say.
pub struct Loss {
    pub name: &'static str,
    scene: Scene,
    /// Rays that ran out of layers, a sample; None where it depends on the samples, and the oracle alone says it.
    a_sample: Option<u32>,
}

const SIZE: u32 = 2;
/// The same paths in f32 and f64: a few hundred roundings.
const ROUNDING: f64 = 1e-4;

/// `count` clear sheets between z = 1 and 2, larger than any ray strays, under a white sky.
fn sheets(name: &'static str, count: u32, camera: Camera) -> Scene {
    let mut scene = Scene {
        name: name.to_owned(),
        camera,
        film: Film { width: SIZE, height: SIZE, ..Film::default() },
        ..Scene::default()
    };
    let z = |sheet: u32| 1.0 + sheet as f32 / count as f32;
    let corners = |sheet| [[-3e4, -1e4, z(sheet)], [3e4, -1e4, z(sheet)], [0.0, 3e4, z(sheet)]];
    scene.meshes.push(Mesh {
        positions: (0..count).flat_map(corners).collect(),
        triangles: (0..count).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect(),
        ..Mesh::default()
    });
    let clear = Material { alpha: Alpha::Blend { value: Value::scalar(0.0) }, ..lambert(DVec3::ZERO) };
    place(&mut scene, "sheets", Shape::Mesh(0), DAffine3::IDENTITY, clear);
    scene.sky = Some(Sky { radiance: SkyRadiance::Uniform(DVec3::ONE), rotation_rad: 0.0, scale: 1.0 });
    scene
}

pub fn losses() -> Vec<Loss> {
    let through = || camera(DVec3::ZERO, DVec3::Z, 0.1);
    let mut lit = sheets("floor under sheets", ALPHA_LAYERS + 1, camera(DVec3::ZERO, DVec3::NEG_Z, 0.1));
    let floor = DAffine3::from_scale_rotation_translation(DVec3::splat(3.0), glam::DQuat::IDENTITY, DVec3::NEG_Z);
    place(&mut lit, "floor", Shape::Rectangle, floor, lambert(DVec3::ONE));
    // Where media nest, another loop follows the ray. The surface behind all sheets is white and as absent as they are; taken as there, it
    // shows the sky, which a sheet taken in its place would not.
    let mut nested = sheets("sheets where media nest", ALPHA_LAYERS, through());
    let clear = Alpha::Blend { value: Value::scalar(0.0) };
    let behind = DAffine3::from_scale_rotation_translation(DVec3::splat(1e4), glam::DQuat::IDENTITY, 3.0 * DVec3::Z);
    place(&mut nested, "last", Shape::Rectangle, behind, Material { alpha: clear, ..lambert(DVec3::ONE) });
    for shift in [0.0, 1.0] {
        let glass = material("dielectric", &[("roughness", Value::scalar(0.0))]);
        place(&mut nested, "ball", Shape::Sphere, sphere_at(DVec3::new(shift, 0.0, -1e3), 1.0), glass);
    }
    vec![
        Loss {
            name: "as many sheets as are followed",
            scene: sheets("sheets", ALPHA_LAYERS, through()),
            a_sample: Some(0),
        },
        Loss { name: "one sheet too many", scene: sheets("sheets", ALPHA_LAYERS + 1, through()), a_sample: Some(1) },
        Loss { name: "one sheet too many where media nest", scene: nested, a_sample: Some(1) },
        Loss { name: "shadow rays through one sheet too many", scene: lit, a_sample: None },
    ]
}

pub fn row(subject: &Subject, loss: &Loss) -> Result<GateRow, Error> {
    let settings = Settings::default();
    let (slots, prepared) = subject.samples(&loss.scene, &settings, 0..u64::from(BLOCK_SAMPLES))?;
    let seen: u64 = slots.iter().map(|s| u64::from(LEDGER_ALPHA_OVERFLOW.read(s))).sum();
    let light = slots.iter().map(|s| f64::from(s.sum[0])).sum::<f64>() / slots.len() as f64;
    let film = render::film(Replay::new(prepared, &settings), settings, 1);
    let (replay, expected) = (film.ledger().alpha_overflow, film.image_mean()[0]);
    let counts = [seen, replay];
    let independent = render::film(Independent::new(&loss.scene), settings, 1).ledger().alpha_overflow;
    let samples = u64::from(SIZE * SIZE * BLOCK_SAMPLES);
    let is_known = loss.a_sample.is_none_or(|n| [counts[0], independent] == [samples * u64::from(n); 2]);
    // Where the oracle alone knows: the same samples lose the same, and something is lost by each of them at least.
    let is_some = loss.a_sample.is_some() || (counts[0] >= samples && independent >= samples);
    Ok(GateRow::new(
        Gate::Replay,
        format!("ledger {}", loss.name),
        counts[0] == counts[1] && is_known && is_some && (light - expected).abs() <= ROUNDING * expected.abs(),
        format!(
            "{} rays out of layers in {samples} samples; replay {}, independent {independent}; radiance {light:.6}, replay {expected:.6}",
            counts[0], counts[1]
        ),
        match loss.a_sample {
            Some(n) => {
                format!("{n} a sample in all three: more than {ALPHA_LAYERS} absent surfaces are taken as opaque")
            }
            None => "device and replay count the same, at least one a sample".to_owned(),
        },
    ))
}
