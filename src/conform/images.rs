//! Gates 7 and 8: whole images. Device against the independent oracle and against closed forms, estimators against each other,
//! the specialised kernel against everything-on.
//!
//! Both sides use independent samples, so blocks of 16 are independent and Welch's t test (1947) judges each pixel (or square
//! of pixels) and channel; Sidak's correction (1967) makes the level that of the whole image. The test of the image mean sees what is too small for pixels: its
//! detectable bias is stated, the smallest relative bias of the mean that the gate would find with probability 0.95.

use glam::DVec3;

use super::report::{Gate, GateRow};
use super::subject::Subject;
use crate::error::Error;
use crate::film::Film;
use crate::film::slot::BLOCK_SAMPLES;
use crate::integrator::{Estimator, Instancing, SamplerKind, Settings};
use crate::metric::stats::{Moments, normal_quantile, sidak, welch_t};
use crate::reference::independent::Independent;
use crate::reference::known::Known;
use crate::reference::render;
use crate::scene::Scene;

/// False alarms of a whole row, at most.
const LEVEL: f64 = 1e-4;
/// Power at which the detectable bias is stated.
const POWER: f64 = 0.95;
/// Systematic rounding of an f32 mean, relative; checks of means allow it.
pub const ROUNDING: f64 = 2e-5;

/// Settings of a row: independent samples.
pub fn settings(estimator: Estimator) -> Settings {
    Settings { estimator, sampler: SamplerKind::Independent, ..Settings::default() }
}

/// One channel of a square of pixels as its blocks saw it: the mean, its variance, and degrees of freedom by Welch and
/// Satterthwaite, written as the moments of so many values that the t test sees just these.
fn moments(film: &Film, square: &Square, channel: usize) -> Moments {
    let (mut mean, mut variance, mut fourth, mut count) = (0.0, 0.0, 0.0, 0.0);
    for pixel in square.pixels(film.width()) {
        let v = film.variance_of_mean(pixel)[channel];
        mean += film.mean(pixel)[channel];
        variance += v;
        fourth += v * v / (f64::from(film.block_count(pixel)) - 1.0);
        count += 1.0;
    }
    let dof = if fourth > 0.0 { variance * variance / fourth } else { 1.0 };
    Moments { count: dof + 1.0, mean: mean / count, variance: variance / (count * count) * (dof + 1.0) }
}

/// Pixels [x, x + width) x [y, y + height).
struct Square {
    x: u32,
    y: u32,
    width: u32,
    height: u32,
}

impl Square {
    /// All squares of `side` pixels of a film, smaller ones at its far edges.
    fn all(film: &Film, side: u32) -> Vec<Self> {
        let (w, h) = (film.width(), film.height());
        let corners = (0..h.div_ceil(side)).flat_map(|j| (0..w.div_ceil(side)).map(move |i| (i * side, j * side)));
        corners.map(|(x, y)| Self { x, y, width: side.min(w - x), height: side.min(h - y) }).collect()
    }

    fn pixels(&self, width: u32) -> impl Iterator<Item = usize> + '_ {
        (self.y..self.y + self.height)
            .flat_map(move |y| (self.x..self.x + self.width).map(move |x| (y * width + x) as usize))
    }
}

/// Mean over all pixels with its standard error, a channel.
pub fn image_mean(film: &Film) -> (DVec3, DVec3) {
    let count = film.pixel_count();
    let variance: DVec3 = (0..count).map(|i| DVec3::from(film.variance_of_mean(i))).sum();
    (DVec3::from(film.image_mean()), (variance / (count * count) as f64).map(f64::sqrt))
}

/// Outcome of comparing two films of the same scene.
struct Comparison {
    is_equal: bool,
    evidence: String,
    bound: String,
}

/// Squares of `side` pixels: 1 where both films sample alike; larger where one of them sees rare bright events, which too few
/// blocks of one pixel may not show in the variance.
fn compare(a: &Film, b: &Film, side: u32) -> Comparison {
    let squares = Square::all(a, side);
    let tests = squares.len() * 3;
    // Half of the level for the squares, half for the three means.
    let level = sidak(0.5 * LEVEL, tests);
    let (mut p, mut at) = (1.0, (0, 0, 0));
    for square in &squares {
        for channel in 0..3 {
            let (ma, mb) = (moments(a, square, channel), moments(b, square, channel));
            // Without variance on both sides (a lamp seen directly) the two differ by rounding only.
            let is_close = (ma.mean - mb.mean).abs() <= ROUNDING * ma.mean.abs().max(mb.mean.abs());
            let this = if is_close { 1.0 } else { welch_t(ma, mb).p };
            // A NaN is the worst there is.
            if this.is_nan() || this < p {
                (p, at) = (this, (square.x, square.y, channel));
            }
        }
    }
    let ((mean_a, error_a), (mean_b, error_b)) = (image_mean(a), image_mean(b));
    let error = (error_a * error_a + error_b * error_b).map(f64::sqrt);
    let z = normal_quantile(1.0 - 0.5 * sidak(0.5 * LEVEL, 3));
    let limit = z * error + ROUNDING * mean_b.abs();
    let off = mean_a - mean_b;
    let detectable = (z + normal_quantile(POWER)) * error / mean_b.abs();
    let (x, y, channel) = at;
    let what = if side == 1 { "pixel".to_owned() } else { format!("{side}x{side} square") };
    Comparison {
        is_equal: p >= level && off.abs().cmple(limit).all(),
        evidence: format!(
            "worst {what} ({x}, {y}) {}: p = {p:.1e}; mean off by {:.3} %",
            ["R", "G", "B"][channel],
            100.0 * (off / mean_b).abs().max_element()
        ),
        bound: format!(
            "p >= {level:.1e} in {tests} tests; mean within {:.3} %; detectable bias {:.3} %",
            100.0 * (limit / mean_b.abs()).max_element(),
            100.0 * detectable.max_element()
        ),
    }
}

fn blocks(spp: u32) -> u64 {
    u64::from(spp.div_ceil(BLOCK_SAMPLES))
}

/// The independent oracle's image of `scene`.
pub fn oracle(scene: &Scene, spp: u32) -> Film {
    render::film(Independent::new(scene), settings(Estimator::Mis), blocks(spp))
}

/// Gate 7: the device against the oracle's image, with as many samples.
pub fn against_oracle(subject: &Subject, scene: &Scene, estimator: Estimator, oracle: &Film) -> Result<GateRow, Error> {
    against_oracle_in(subject, scene, estimator, oracle, 1)
}

/// The same by squares of `side` pixels.
pub fn against_oracle_in(
    subject: &Subject,
    scene: &Scene,
    estimator: Estimator,
    oracle: &Film,
    side: u32,
) -> Result<GateRow, Error> {
    let seen = subject.film(scene, &settings(estimator), u64::from(oracle.min_block_count()))?;
    let c = compare(&seen, oracle, side);
    let spp = oracle.min_block_count() * BLOCK_SAMPLES;
    let name = format!("image {} {estimator:?}", scene.name).to_lowercase();
    Ok(GateRow::new(Gate::Images, name, c.is_equal, format!("{spp} spp: {}", c.evidence), c.bound))
}

/// Gate 7: two estimators on the device, with different seeds so that nothing is shared.
pub fn estimators(subject: &Subject, scene: &Scene, other: Estimator, spp: u32) -> Result<GateRow, Error> {
    let a = subject.film(scene, &Settings { seed: 1, ..settings(other) }, blocks(spp))?;
    let b = subject.film(scene, &settings(Estimator::Mis), blocks(spp))?;
    let c = compare(&a, &b, 8);
    let name = format!("estimators {} {other:?} and mis", scene.name).to_lowercase();
    Ok(GateRow::new(Gate::Images, name, c.is_equal, format!("{spp} spp: {}", c.evidence), c.bound))
}

/// Gate 7: a scene whose radiance is known.
pub fn closed_form(subject: &Subject, known: &Known, estimator: Estimator, spp: u32) -> Result<GateRow, Error> {
    // Whatever can be placed is: the answer is the same.
    let settings = Settings { instancing: Instancing::Always, ..settings(estimator) };
    let film = subject.film(&known.scene, &settings, blocks(spp))?;
    let (mean, error) = image_mean(&film);
    let z = normal_quantile(1.0 - 0.5 * sidak(LEVEL, 3));
    // 1e-5: the width of the view; the rest is rounding.
    let bound = z * error + (1e-5 + ROUNDING) * known.radiance;
    let off = mean - known.radiance;
    Ok(GateRow::new(
        Gate::Images,
        format!("closed form {} {estimator:?}", known.name).to_lowercase(),
        off.abs().cmple(bound).all(),
        format!("{mean:.5}, off by {:.4} %", 100.0 * (off / known.radiance).abs().max_element()),
        format!(
            "{:.5} within {:.4} %: {}",
            known.radiance,
            100.0 * (bound / known.radiance).max_element(),
            known.about
        ),
    ))
}

/// Gate 8: the specialised kernel and everything-on, pixel by pixel on the same numbers. They must be two kernels, the specialised one
/// of fewer words: where a scene fell back to everything-on, equal pictures say nothing.
pub fn specialised(subject: &Subject, scene: &Scene, spp: u32) -> Result<GateRow, Error> {
    /// Largest share of samples that part (different texts round differently); a pixel parts with any of its own.
    const PARTED_SHARE: f64 = 0.01;
    let settings = Settings::default();
    let (a, own) = subject.film_and_kernel(scene, &settings, blocks(spp))?;
    let (b, all) = Subject { everything: true, ..*subject }.film_and_kernel(scene, &settings, blocks(spp))?;
    let mean = |film: &Film, i: usize| film.mean(i).iter().sum::<f64>() / 3.0;
    let pairs: Vec<(f64, f64)> = (0..a.pixel_count()).map(|i| (mean(&a, i), mean(&b, i))).collect();
    let parted = pairs.iter().filter(|(x, y)| (x - y).abs() > 1e-4 * x.abs().max(y.abs())).count();
    let equal = (0..a.pixel_count()).filter(|&i| a.mean(i) == b.mean(i)).count();
    let difference = Moments::of(pairs.iter().map(|(x, y)| x - y));
    let level = pairs.iter().map(|p| p.0).sum::<f64>() / pairs.len() as f64;
    let bound = 4.5 * difference.variance_of_mean().sqrt() + ROUNDING * level;
    let parted_bound = 1.0 - (1.0 - PARTED_SHARE).powf(f64::from(spp));
    Ok(GateRow::new(
        Gate::Specialised,
        format!("specialised {}", scene.name),
        own.spirv_words < all.spirv_words
            && parted as f64 <= parted_bound * pairs.len() as f64
            && difference.mean.abs() <= bound,
        format!(
            "{} and {} words; {parted} of {} pixels parted, {equal} equal to the bit; mean difference {:+.1e} of {level:.4}",
            own.spirv_words,
            all.spirv_words,
            pairs.len(),
            difference.mean
        ),
        format!("fewer words; parted <= {:.1} %; |mean difference| <= {bound:.1e}", 100.0 * parted_bound),
    ))
}
