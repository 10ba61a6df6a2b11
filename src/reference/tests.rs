//! The oracle against closed forms, with every estimator: what it is trusted for.

use std::sync::Arc;

use glam::DVec3;

use super::independent::Independent;
use super::known;
use super::path::World;
use super::replay::Replay;
use super::{meters, render, scenes};
use crate::film::Film;
use crate::integrator::{Estimator, SamplerKind, Settings};
use crate::prepare;
use crate::scene::Scene;

/// Mean over the image and its standard error, from the spread of blocks in each pixel.
fn mean(film: &Film) -> (DVec3, DVec3) {
    let count = film.pixel_count();
    let variance: DVec3 = (0..count).map(|i| DVec3::from(film.variance_of_mean(i))).sum();
    (DVec3::from(film.image_mean()), (variance / (count * count) as f64).map(f64::sqrt))
}

fn meets(known: &known::Known, what: &str, world: impl World, settings: Settings) {
    let film = render::film(world, settings, 32);
    let (mean, error) = mean(&film);
    // 4.5 standard errors: two-sided 7e-6 a channel; 1e-5 of the value for the width of the view.
    let bound = 4.5 * error + 1e-5 * known.radiance;
    let off = (mean - known.radiance).abs();
    assert!(
        off.cmple(bound).all() && mean.is_finite(),
        "{} ({}), {what} with {:?}: {mean}, expected {}, standard error {error}",
        known.name,
        known.about,
        settings.estimator,
        known.radiance
    );
}

const ESTIMATORS: [Estimator; 3] = [Estimator::Bsdf, Estimator::Light, Estimator::Mis];

fn replay(scene: &Scene, settings: &Settings) -> Replay {
    Replay::new(Arc::new(prepare::prepare(scene, settings).unwrap()), settings)
}

#[test]
fn closed_forms_hold_with_every_estimator() {
    for known in known::all().into_iter().chain(meters::all()) {
        for estimator in ESTIMATORS {
            let settings = Settings { estimator, sampler: SamplerKind::Independent, ..Settings::default() };
            if estimator == Estimator::Bsdf && known.scene.has_delta_lights() {
                continue;
            }
            meets(&known, "independent", Independent::new(&known.scene), settings);
            meets(&known, "replay", replay(&known.scene, &settings), settings);
        }
    }
}

/// Lights without size are not there for BSDF sampling: nothing is invented, and the render says so.
#[test]
fn the_estimator_bsdf_does_not_see_lights_without_size() {
    let settings = Settings { estimator: Estimator::Bsdf, ..Settings::default() };
    let scene = known::lights::spots().scene;
    let prepared = prepare::prepare(&scene, &settings).unwrap();
    assert!(prepared.notes.iter().any(|n| n.contains("cannot find 3 lights without size")), "{:?}", prepared.notes);
    for film in
        [render::film(replay(&scene, &settings), settings, 2), render::film(Independent::new(&scene), settings, 2)]
    {
        assert_eq!(film.image_mean(), [0.0; 3]);
    }
    assert!(prepare::prepare(&scene, &Settings::default()).unwrap().notes.is_empty());
}

#[test]
fn both_worlds_and_all_estimators_give_the_same_mean() {
    for scene in scenes::all(16) {
        let mut seen: Vec<(String, DVec3, DVec3)> = Vec::new();
        let base_index = if scene.has_delta_lights() { 2 } else { 4 };
        for estimator in ESTIMATORS {
            let settings = Settings { estimator, sampler: SamplerKind::Independent, ..Settings::default() };
            if estimator == Estimator::Bsdf && scene.has_delta_lights() {
                continue;
            }
            let (m, e) = mean(&render::film(Independent::new(&scene), settings, 8));
            seen.push((format!("independent {estimator:?}"), m, e));
            let (m, e) = mean(&render::film(replay(&scene, &settings), settings, 8));
            seen.push((format!("replay {estimator:?}"), m, e));
        }
        for (name, m, e) in &seen {
            let (base, base_mean, base_error) = &seen[base_index];
            // 5 standard errors of the difference: 5e-7 a channel, and the variance is itself estimated from 8 blocks.
            let bound = 5.0 * (e * e + base_error * base_error).map(f64::sqrt);
            assert!(
                (m - base_mean).abs().cmple(bound).all(),
                "{}: {name} {m} +- {e}, {base} {base_mean} +- {base_error}",
                scene.name
            );
        }
    }
}

/// Not a check: `cargo test --release --lib reference::tests::speed -- --ignored --nocapture`.
#[test]
#[ignore = "prints a rate"]
fn speed() {
    let scene = crate::reference::scenes::cornell(128);
    let start = std::time::Instant::now();
    let film = render::film(Independent::new(&scene), Settings::default(), 2);
    let seconds = start.elapsed().as_secs_f64();
    let (samples, rays) = (film.sample_count() as f64, film.ray_count() as f64);
    println!(
        "{:.3} Msamples/s, {:.2} Mrays/s, mean {:?}",
        samples / seconds * 1e-6,
        rays / seconds * 1e-6,
        film.image_mean()
    );
}

/// Not a check: writes the scenes to look at.
#[test]
#[ignore = "writes pictures"]
fn pictures() {
    for scene in crate::reference::scenes::all(256) {
        let film = render::film(Independent::new(&scene), Settings::default(), 4);
        let bytes: Vec<u8> =
            film.mean_f32().iter().flatten().map(|v| (v.clamp(0.0, 1.0).powf(1.0 / 2.2) * 255.0) as u8).collect();
        image::save_buffer(format!("/tmp/{}.png", scene.name), &bytes, 256, 256, image::ColorType::Rgb8).unwrap();
    }
}
