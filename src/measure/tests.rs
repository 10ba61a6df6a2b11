//! Intervals cover the truth as often as they say; values are those of closed forms.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::{DAffine3, DVec3};

use super::*;
use crate::integrator::{Estimator, SamplerKind, Settings};
use crate::light::integrals::polygon_irradiance;
use crate::prepare;
use crate::reference::known::{lambert, lamp, place as add, sphere_at};
use crate::reference::render::Renderer;
use crate::reference::replay::Replay;
use crate::scene::{Place, Quantity, Shape, SurfaceMeter};

fn meter(position: DVec3, normal: DVec3) -> Sensor {
    Sensor { name: "meter".into(), quantity: Quantity::Irradiance, place: Place::Point { position, normal } }
}

/// A rectangle lamp that the meter's horizon cuts, and the irradiance by Lambert's formula.
fn cut_lamp() -> (Scene, Sensor, DVec3) {
    let mut scene = Scene::default();
    let emission = DVec3::new(3.0, 2.0, 1.0);
    let (corner, u, v) = (DVec3::new(-0.5, -0.3, 1.0), DVec3::new(1.0, 0.0, 0.2), DVec3::new(0.0, 0.9, 0.0));
    // Facing down to the origin: u x v points up, so the rectangle is given as v, u.
    let matrix3 = glam::DMat3::from_cols(0.5 * v, 0.5 * u, v.cross(u).normalize());
    let to_world = DAffine3 { matrix3, translation: corner + 0.5 * (u + v) };
    add(&mut scene, "lamp", Shape::Rectangle, to_world, lamp(emission));
    let normal = DVec3::new(0.3, 0.8, 0.4).normalize();
    let polygon = [corner, corner + u, corner + u + v, corner + v];
    (scene, meter(DVec3::ZERO, normal), emission * polygon_irradiance(DVec3::ZERO, normal, &polygon))
}

fn read_on_cpu(scene: &Scene, sensor: &Sensor, settings: &Settings, repetitions: u32, blocks: u64) -> Reading {
    let area_m2 = sensor.area_m2(scene);
    let mut scene = scene.clone();
    place(&mut scene, sensor, repetitions);
    let world = Replay::new(Arc::new(prepare::prepare(&scene, settings).unwrap()), settings);
    let stops = Stops { blocks, error: None };
    read(&mut Renderer::new(world, *settings), sensor, area_m2, &stops, &|| false).unwrap().unwrap()
}

/// 1000 seeds: the share that covers has a standard deviation of 0.7 %, and may be 2 % off.
#[test]
fn intervals_cover_the_truth_95_times_of_100() {
    coverage(1000);
}

/// By hand, for docs/measure.md: `cargo test --lib measure::tests::coverage -- --ignored --nocapture`.
#[test]
#[ignore = "20000 seeds take a minute"]
fn coverage_at_length() {
    coverage(20_000);
}

fn coverage(seeds: u32) {
    let (scene, sensor, truth) = cut_lamp();
    for (sampler, estimator) in [
        (SamplerKind::Sobol, Estimator::Mis),
        (SamplerKind::Sobol, Estimator::Bsdf),
        (SamplerKind::Independent, Estimator::Mis),
    ] {
        let mut covered = [0; 2];
        for seed in 0..seeds {
            let settings = Settings { sampler, estimator, seed, ..Settings::default() };
            let r = read_on_cpu(&scene, &sensor, &settings, REPETITIONS, 1);
            covered[0] += u32::from((r.value[0] - truth.x).abs() <= r.half_width[0]);
            let luminous = LUMENS_A_WATT * crate::reference::path::luminance(truth);
            covered[1] += u32::from((r.luminous - luminous).abs() <= r.luminous_half_width);
        }
        let share = covered.map(|c| f64::from(c) / f64::from(seeds));
        println!("{sampler:?} {estimator:?}: {share:?} of {seeds}");
        assert!(share.iter().all(|s| (0.93..=0.97).contains(s)), "{sampler:?} {estimator:?}: {covered:?} of {seeds}");
    }
}

#[test]
fn an_error_asked_for_is_met_by_doubling() {
    let (mut scene, sensor, truth) = cut_lamp();
    place(&mut scene, &sensor, REPETITIONS);
    let settings = Settings { sampler: SamplerKind::Independent, ..Settings::default() };
    let world = Replay::new(Arc::new(prepare::prepare(&scene, &settings).unwrap()), &settings);
    let mut source = Renderer::new(world, settings);
    let r = read(&mut source, &sensor, None, &Stops { blocks: 4096, error: Some(0.01) }, &|| false).unwrap().unwrap();
    assert_eq!(r.error_met, Some(true));
    assert!(r.luminous_half_width <= 0.01 * r.luminous && r.spp >= 32 && r.spp < 65536, "{r:?}");
    assert!((r.value[0] / truth.x - 1.0).abs() < 0.02, "{r:?}");
    // Not met in two blocks, and said.
    let r = read(&mut source, &sensor, None, &Stops { blocks: 2, error: Some(1e-6) }, &|| false).unwrap().unwrap();
    assert_eq!((r.error_met, r.spp), (Some(false), 32));
}

/// All that a lamp gives arrives at a black ball around it; twice the ball's radius, the same flux.
#[test]
fn flux_is_the_lamp_s_power_and_does_not_depend_on_the_ball() {
    let power = PI * 4.0 * PI * 0.25 * 0.25;
    for radius in [1.0, 2.0] {
        let mut scene = Scene::default();
        add(&mut scene, "lamp", Shape::Sphere, sphere_at(DVec3::new(0.3, 0.1, 0.0), 0.25), lamp(DVec3::ONE));
        add(&mut scene, "ball", Shape::Sphere, sphere_at(DVec3::ZERO, radius), lambert(DVec3::ZERO));
        let surface = |shape: usize, is_back, is_leaving| Sensor {
            name: "flux".into(),
            quantity: Quantity::Flux,
            place: Place::Surface { meter: SurfaceMeter { shapes: vec![shape], is_back }, is_leaving },
        };
        for (sensor, wanted) in [
            (surface(1, true, false), power),
            (surface(0, false, true), power),
            (surface(1, true, true), 0.0),
            (surface(1, false, false), 0.0),
        ] {
            let r = read_on_cpu(&scene, &sensor, &Settings::default(), 32, 32);
            assert!((r.value[1] - wanted).abs() <= 1.5 * r.half_width[1], "{sensor:?}: {r:?}, wanted {wanted}");
        }
    }
}
