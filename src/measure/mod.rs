//! Measuring: a sensor's value with its interval, from independent repetitions of one measurement.
//!
//! The meter is the scene's camera (`camera`, `scene::Sensor::camera`) and the film a row of `repetitions` pixels. Each pixel has random
//! numbers of its own (the sampler hashes the pixel; Owen scrambles of different pixels are independent), so the pixels' means
//! are independent and equally distributed, and the mean of them has an interval by Student's t with `repetitions - 1` degrees of
//! freedom. The luminous value is 683 lm/W times the luminance of each repetition, so that its interval is its own.
//! Coverage over 1000 seeds: tests below. Fields of the JSON: docs/measure.md.

mod text;

use std::time::Instant;

use crate::error::Error;
use crate::film::Film;
use crate::film::slot::BLOCK_SAMPLES;
use crate::film::source::SampleSource;
use crate::metric::stats::Moments;
use crate::scene::{Film as SceneFilm, Scene, Sensor};
pub use text::table;

/// Luminous efficacy of RGB radiance, lm/W, by the project's convention.
pub const LUMENS_A_WATT: f64 = 683.0;
pub const CONFIDENCE: f64 = 0.95;
/// Independent repetitions of a measurement: t of 31 degrees of freedom is 4 % wider than the normal's.
pub const REPETITIONS: u32 = 32;
/// Samples of each repetition when nothing says when to stop, and at most when only an error does.
pub const DEFAULT_SPP: u64 = 2048;
pub const MOST_SPP: u64 = 1 << 20;

/// Systematic rounding of a mean, relative: of f32 paths and records on a device, of the slots' f32 sums in f64 paths.
const ROUNDING_F32: f64 = 2e-5;
const ROUNDING_F64: f64 = 2e-7;

/// When to stop.
#[derive(Clone, Copy, Debug)]
pub struct Stops {
    /// Blocks of 16 samples of each repetition, at most.
    pub blocks: u64,
    /// Half width of the luminous value's interval over the value.
    pub error: Option<f64>,
}

/// A value and half the width of its 95 % interval.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Estimate {
    pub value: f64,
    pub half_width: f64,
}

/// One sensor's outcome.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Reading {
    pub name: String,
    pub quantity: &'static str,
    pub unit: &'static str,
    /// Linear Rec.709 R, G, B.
    pub value: [f64; 3],
    pub half_width: [f64; 3],
    pub luminous: f64,
    pub luminous_half_width: f64,
    pub luminous_unit: &'static str,
    pub confidence: f64,
    pub degrees_of_freedom: u32,
    pub repetitions: u32,
    /// Samples of each repetition.
    pub spp: u64,
    pub samples: u64,
    pub rays: u64,
    /// Part of the half widths that stands for rounding, relative to the value.
    pub rounding: f64,
    /// Of the surface, one side; null for rays and points.
    pub area_m2: Option<f64>,
    /// The error asked for was met; null when none was.
    pub error_met: Option<bool>,
    /// Samples that were NaN, infinite or negative, and paths cut at the depth limit.
    pub bad_samples: u64,
    pub cut_paths: u64,
    /// Tracing, preparation of the scene not included.
    pub trace_s: f64,
}

/// Makes `sensor` the camera of `scene`, with one pixel a repetition.
pub fn place(scene: &mut Scene, sensor: &Sensor, repetitions: u32) {
    scene.camera = sensor.camera(scene);
    let SceneFilm { spp, max_depth, .. } = scene.film;
    scene.film = SceneFilm { width: repetitions, height: 1, spp, max_depth, ..SceneFilm::default() };
}

/// Measures with a source that renders the scene of `place`. None when interrupted before the first block of every repetition.
pub fn read(
    source: &mut dyn SampleSource,
    sensor: &Sensor,
    area_m2: Option<f64>,
    stops: &Stops,
    interrupted: &dyn Fn() -> bool,
) -> Result<Option<Reading>, Error> {
    let begun = Instant::now();
    let (width, height) = source.resolution();
    let mut film = Film::new(width, height, source.aovs(), 0);
    let factor = match (sensor.quantity, area_m2) {
        (crate::scene::Quantity::Flux, Some(area)) => area,
        _ => 1.0,
    };
    let rounding = if source.describe().kind == "cpu" { ROUNDING_F64 } else { ROUNDING_F32 };
    let (mut done, mut rays) = (0, 0);
    let is_met = |film: &Film| {
        let luminous = luminous(film, factor, rounding);
        stops.error.map(|e| luminous.half_width <= e * luminous.value.abs())
    };
    // Doubling: few looks, so that stopping at a lucky one hardly narrows the interval; never at the first, of 16 samples.
    while done < stops.blocks && !interrupted() {
        let end = if stops.error.is_some() { (2 * done).max(1) } else { stops.blocks }.min(stops.blocks);
        rays += source.render_blocks(done..end, &mut film, interrupted)?.rays;
        done = u64::from(film.min_block_count());
        if done > 1 && is_met(&film) == Some(true) {
            break;
        }
    }
    if film.min_block_count() == 0 {
        return Ok(None);
    }
    let channels = [0, 1, 2].map(|c| estimate(&film, |rgb| factor * rgb[c], rounding));
    let luminous = luminous(&film, factor, rounding);
    let (unit, luminous_unit) = sensor.quantity.units();
    let ledger = film.ledger();
    Ok(Some(Reading {
        name: sensor.name.clone(),
        quantity: sensor.quantity.name(),
        unit,
        value: channels.map(|e| e.value),
        half_width: channels.map(|e| e.half_width),
        luminous: luminous.value,
        luminous_half_width: luminous.half_width,
        luminous_unit,
        confidence: CONFIDENCE,
        degrees_of_freedom: film.pixel_count() as u32 - 1,
        repetitions: film.pixel_count() as u32,
        spp: u64::from(film.min_block_count() * BLOCK_SAMPLES),
        samples: film.sample_count(),
        rays,
        rounding,
        area_m2,
        error_met: is_met(&film),
        bad_samples: ledger.nan + ledger.inf + ledger.negative,
        cut_paths: ledger.depth,
        trace_s: begun.elapsed().as_secs_f64(),
    }))
}

/// Mean over the repetitions of a function of their RGB means, with its interval.
fn estimate(film: &Film, of: impl Fn([f64; 3]) -> f64 + Copy, rounding: f64) -> Estimate {
    let moments = Moments::of((0..film.pixel_count()).map(|i| of(film.mean(i))));
    Estimate { value: moments.mean, half_width: moments.half_width(CONFIDENCE) + rounding * moments.mean.abs() }
}

fn luminous(film: &Film, factor: f64, rounding: f64) -> Estimate {
    let of = |rgb: [f64; 3]| LUMENS_A_WATT * factor * crate::reference::path::luminance(rgb.into());
    estimate(film, of, rounding)
}

#[cfg(test)]
mod tests;
