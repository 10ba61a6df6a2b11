//! Gate 6: single paths of the device against the replay oracle, which runs on the same records and the same integers.
//!
//! Until rounding makes a choice fall differently (a lobe, a silhouette, a roulette), the oracle's path is the device's. A sample
//! is parted when its number of rays differs, or its radiance by more than `FOLLOWS` of the larger of the two and `FLOOR` of
//! the image's mean. Two things must hold: few samples are parted, and parting has no direction: the mean difference
//! over all samples stays within 4.5 standard errors of 0, rounding allowed for.

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use super::report::{Gate, GateRow};
use super::subject::Subject;
use crate::error::Error;
use crate::film::slot::SlotRecord;
use crate::integrator::Settings;
use crate::metric::stats::Moments;
use crate::reference::path::trace;
use crate::reference::replay::Replay;
use crate::scene::Scene;

/// Largest relative difference of a sample that followed: f32 through some ten vertices, with cosines that cancel.
const FOLLOWS: f64 = 2e-3;
/// Part of the mean radiance below which a difference does not count.
const FLOOR: f64 = 1e-4;
/// Largest share of parted samples; measured on lavapipe: 0 to 0.54 %, most in smooth glass.
const PARTED_SHARE: f64 = 0.01;
/// Systematic rounding of a mean in f32, relative.
const ROUNDING: f64 = 2e-5;
/// Of every pixel: the end of an even block and the beginning of an odd one, which may have sequences of their own.
const SAMPLES: Range<u64> = 8..24;

/// One row for `scene`.
pub fn row(subject: &Subject, scene: &Scene, settings: &Settings) -> Result<GateRow, Error> {
    let (slots, prepared) = subject.samples(scene, settings, SAMPLES)?;
    let world = Replay::new(prepared.clone(), settings);
    let (width, pixels) = (prepared.width as usize, prepared.width as usize * prepared.height as usize);
    let sample_of = |i: usize| SAMPLES.start + (i / pixels) as u64;
    let expected: Vec<(DVec3, u32)> = (0..slots.len())
        .into_par_iter()
        .map(|i| {
            let pixel = [(i % pixels % width) as u32, (i % pixels / width) as u32];
            let sample = trace(&world, settings, pixel, sample_of(i), |_| ());
            (if sample.radiance.is_finite() { sample.radiance } else { DVec3::ZERO }, sample.rays)
        })
        .collect();
    let mean = expected.iter().map(|e| e.0.element_sum()).sum::<f64>() / (3 * expected.len()) as f64;
    let is_parted = |slot: &SlotRecord, (radiance, rays): &(DVec3, u32)| {
        let seen = DVec3::from(slot.sum.map(f64::from));
        let bound = FOLLOWS * seen.abs().max(radiance.abs()) + FLOOR * mean;
        slot.rays != *rays || !(seen - radiance).abs().cmple(bound).all()
    };
    let parted: Vec<usize> = (0..slots.len()).filter(|&i| is_parted(&slots[i], &expected[i])).collect();
    let share = parted.len() as f64 / slots.len() as f64;
    let sum = |c: [f32; 3]| c.iter().map(|&c| f64::from(c)).sum::<f64>();
    let difference = Moments::of(slots.iter().zip(&expected).map(|(s, e)| (sum(s.sum) - e.0.element_sum()) / 3.0));
    let bound = 4.5 * difference.variance_of_mean().sqrt() + ROUNDING * mean;
    let first = parted.first().map_or(String::new(), |i| {
        format!(", first at ({}, {}) sample {}", i % pixels % width, i % pixels / width, sample_of(*i))
    });
    Ok(GateRow::new(
        Gate::Replay,
        format!("replay {} {:?}", scene.name, settings.estimator).to_lowercase(),
        share <= PARTED_SHARE && difference.mean.abs() <= bound,
        format!(
            "{} of {} samples parted ({:.3} %){first}; mean difference {:+.2e} of {mean:.4}",
            parted.len(),
            slots.len(),
            100.0 * share,
            difference.mean
        ),
        format!(
            "parted <= {} %; |mean difference| <= {bound:.1e}: 4.5 standard errors and rounding",
            100.0 * PARTED_SHARE
        ),
    ))
}
