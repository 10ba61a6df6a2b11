//! The oracle against closed forms, with every estimator: what it is trusted for.

use std::sync::Arc;

use glam::DVec3;

use super::independent::Independent;
use super::path::{World, trace};
use super::replay::Replay;
use super::{known, known_nested};
use super::{meters, render, scenes};
use crate::film::Film;
use crate::integrator::{Estimator, Instancing, SamplerKind, Settings};
use crate::light::alias::AliasTable;
use crate::light::{LIGHT_SKY, LIGHT_SPHERE};
use crate::prepare;
use crate::prepare::records::LightRecord;
use crate::scene::{Scene, Shape, Texture, Value};

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
    for known in known::all().into_iter().chain(known_nested::all()).chain(meters::all()) {
        for estimator in ESTIMATORS {
            let settings = Settings {
                estimator,
                sampler: SamplerKind::Independent,
                instancing: Instancing::Always,
                ..Settings::default()
            };
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
fn the_cosine_law_holds_to_grazing_angles() {
    for known in known::TILTS_DEG.map(known::tilted_receiver) {
        for estimator in [Estimator::Light, Estimator::Mis] {
            let settings = Settings { estimator, sampler: SamplerKind::Independent, ..Settings::default() };
            meets(&known, "independent", Independent::new(&known.scene), settings);
            meets(&known, "replay", replay(&known.scene, &settings), settings);
        }
    }
}

/// A mirrored ball shows its texture and its normal map as they lie on the ball: by the scene's own transform, at each point.
#[test]
fn a_mirrored_ball_is_textured_in_its_own_frame() {
    let globe = scenes::mirrored_globe();
    let center = globe.translation;
    let from = center + DVec3::new(0.7, 0.9, 2.0);
    let mut scene = known::narrow("globe", from, center);
    scene.camera = known::camera(from, center, 0.3);
    scene.textures.push(Texture::Checker { a: [0.9; 4], b: [0.1; 4], scale: [9.0, 5.0] });
    let checker = Value::Texture { texture: 0, uv_set: 0, uv_transform: glam::DAffine2::IDENTITY };
    let material = scenes::slanted(known::material("lambert", &[("albedo", checker)]));
    known::place(&mut scene, "globe", Shape::Sphere, globe, material);
    let settings = Settings::default();
    let (independent, replay) = (Independent::new(&scene), replay(&scene, &settings));
    let mut seen = 0;
    for sample in 0..32 {
        for pixel in (0..64).map(|k| [k % 8, k / 8]) {
            // f32 records: 1e-5; a square's border may fall to either side of rounding.
            seen += in_own_frame(&independent, &settings, DVec3::ZERO, pixel, sample, 1e-9);
            seen += in_own_frame(&replay, &settings, from, pixel, sample, 1e-5);
        }
    }
    assert!(seen > 2000, "{seen} samples saw the globe");
}

/// 1 where the sample saw the globe clear of a border; it then must show what the object's own frame says.
fn in_own_frame(
    world: &impl World,
    settings: &Settings,
    world_origin: DVec3,
    pixel: [u32; 2],
    index: u64,
    bound: f64,
) -> usize {
    let mut place = None;
    let globe = scenes::mirrored_globe();
    let sample = trace(world, settings, pixel, index, |v| {
        place.get_or_insert(v.point);
    });
    let (Some(point), Some(first)) = (place, sample.first) else { return 0 };
    let l = globe.inverse().transform_point3(point + world_origin).normalize();
    let squares = [9.0 * (0.5 + l.x.atan2(-l.z) / std::f64::consts::TAU), 5.0 * (l.y.acos() / std::f64::consts::PI)];
    let is_at_border = |x: f64| (x - x.round()).abs() < 1e-4;
    if squares.into_iter().any(is_at_border) {
        return 0;
    }
    let is_even = (squares[0].floor() + squares[1].floor()).rem_euclid(2.0) == 0.0;
    assert!((first.albedo.x - if is_even { 0.9 } else { 0.1 }).abs() < 1e-6, "{l}: {}", first.albedo);
    // (0.65, 0.6, 0.95) in [0,1] is (0.3, 0.2, 0.9): along growing u, up the picture (falling v), outward.
    let u = DVec3::new(-l.z, 0.0, l.x).normalize();
    let wanted = (globe.matrix3 * (0.3 * u + 0.2 * u.cross(l) + 0.9 * l)).normalize();
    assert!((first.normal - wanted).length() < bound, "{l}: normal {}, not {wanted}", first.normal);
    1
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

/// Not a check: `cargo test --lib sky_share -- --ignored --nocapture` prints the error for shares of light samples that go to the
/// sky, beside the share by power alone. What the cap in prepare::lights stands on.
#[test]
#[ignore = "prints errors"]
fn sky_share() {
    let mut showcase = crate::scene::load("scenes/showcase.toml".as_ref()).unwrap();
    (showcase.film.width, showcase.film.height) = (72, 45);
    for scene in [showcase, scenes::small_sun(64), scenes::room_with_window(64)] {
        let settings = Settings::default();
        let prepared = prepare::prepare(&scene, &settings).unwrap();
        let sky = prepared.lights.iter().position(|l| l.kind == LIGHT_SKY).unwrap();
        let capped = f64::from(prepared.lights[sky].pmf);
        let by_power = by_power_alone(&prepared, sky);
        for share in [0.1, 0.25, 0.5, 0.75, 0.9, 0.98, by_power] {
            let mut p = prepared.clone();
            let others = 1.0 - capped;
            let weight = |(i, l): (usize, &LightRecord)| {
                if i == sky { share } else { f64::from(l.pmf) * (1.0 - share) / others }
            };
            let table = AliasTable::new(&p.lights.iter().enumerate().map(weight).collect::<Vec<_>>()).unwrap();
            p.lights.iter_mut().zip(&table.pmf).for_each(|(l, pmf)| l.pmf = *pmf as f32);
            p.light_alias = table.records();
            let film = render::film(Replay::new(Arc::new(p), &settings), settings, 16);
            let e = crate::metric::estimate::from_film(&film).unwrap();
            println!(
                "{} sky {share:.4}{}: relMSE {:.5} [{:.5}, {:.5}], trimmed {:.5}",
                scene.name,
                if share == by_power { " (by power alone)" } else { "" },
                e.relmse.value,
                e.relmse.low,
                e.relmse.high,
                e.relmse_trimmed
            );
        }
    }
}

/// Share of the sky without a cap: pi R^2 times the integral of its luminance beside the powers of the others.
fn by_power_alone(p: &prepare::Prepared, sky: usize) -> f64 {
    let (width, height) = (p.sky.width as usize, p.sky.height as usize);
    let luminance = |c: [f32; 3]| crate::reference::path::luminance(DVec3::from(c.map(f64::from)));
    let integral: f64 = match width {
        0 => 4.0 * std::f64::consts::PI * luminance(p.sky.scale),
        _ => (0..width * height)
            .map(|k| {
                let solid = crate::light::sky_table::cell_solid_angle(k / width, width, height);
                solid * luminance(p.sky_texels[k].radiance) * f64::from(p.sky.scale[1])
            })
            .sum(),
    };
    let sky_power = std::f64::consts::PI * p.bounding_radius().powi(2) * integral;
    // Constants of the emission patterns: all lamps here have one.
    let others: f64 = (p.lights.iter().enumerate())
        .filter(|(i, _)| *i != sky)
        .map(|(_, l)| {
            let data = p.materials[l.material as usize].emission_data as usize;
            let radiance = luminance([0, 1, 2].map(|c| f32::from_bits(p.material_data[data][c])));
            let edges = [l.a, l.b, l.c].map(|v| DVec3::from(v.map(f64::from)));
            match l.kind {
                LIGHT_SPHERE => 4.0 * std::f64::consts::PI.powi(2) * f64::from(l.b[0]).powi(2) * radiance,
                _ => 0.5 * std::f64::consts::PI * (edges[1] - edges[0]).cross(edges[2] - edges[0]).length() * radiance,
            }
        })
        .sum();
    sky_power / (sky_power + others)
}
