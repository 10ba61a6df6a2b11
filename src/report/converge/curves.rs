//! What the runs of a study say: medians and bands, exponents, time to a quality, bias apart from variance.

use serde::Serialize;

use super::{Run, Snapshot, Study};
use crate::metric::error::EPSILON;
use crate::metric::stats::{Moments, student_t_quantile};

/// Levels below this are not fitted: few samples have not yet met what is rare.
const FIT_FROM_SPP: u64 = 32;
/// Qualities that times are told for.
pub const QUALITIES: [f64; 4] = [1.0, 1e-1, 1e-2, 1e-3];

/// A number with its 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Interval {
    pub value: f64,
    pub low: f64,
    pub high: f64,
}

/// One level of a variant over its replicates.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Point {
    pub spp: f64,
    pub seconds: f64,
    pub relmse: f64,
    pub relmse_low: f64,
    pub relmse_high: f64,
    pub flip: f64,
    pub flip_low: f64,
    pub flip_high: f64,
}

impl Point {
    /// `figures`, unless nothing is left of the error when the reference's own noise is taken off.
    pub fn relmse_words(&self, figures: String) -> String {
        if self.relmse > 0.0 { figures } else { "below the reference's noise".into() }
    }
}

/// Seconds to reach a relMSE on the median curve.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Quality {
    pub relmse: f64,
    pub seconds: f64,
    pub spp: f64,
    /// Beyond the last snapshot, by the fitted exponent.
    pub is_extrapolated: bool,
}

/// The summary of one variant.
#[derive(Clone, Debug, Serialize)]
#[allow(non_snake_case)] // throughput_MSps is the field's name
pub struct Summary {
    pub variant: String,
    pub repeats: usize,
    pub setup_s: f64,
    pub throughput_MSps: f64,
    /// Medians at the end of the budget.
    pub at_budget: Point,
    /// Exponent of relMSE in spp; -1 for independent samples. None below two replicates or three levels.
    pub exponent: Option<Interval>,
    /// Median of the renders' own estimate over the true error, at the end of the budget; None where the reference cannot tell.
    pub estimate_ratio: Option<f64>,
    /// Squared bias in units of relMSE at the largest level of all replicates, variance taken out.
    pub bias_squared: Option<Interval>,
    /// Variance of one replicate in units of relMSE there.
    pub variance: Option<f64>,
    pub bias_spp: Option<u64>,
    /// Signed relative bias of the image mean there.
    pub mean_bias: Option<Interval>,
    pub qualities: Vec<Quality>,
    pub curve: Vec<Point>,
    pub device: String,
    pub driver: String,
    pub kernel_hash: String,
    pub seeds: Vec<u32>,
}

/// A summary for each variant.
pub fn summaries(study: &Study) -> Vec<Summary> {
    (0..study.plan.variants.len()).filter_map(|v| summary(study, v)).collect()
}

fn summary(study: &Study, variant: usize) -> Option<Summary> {
    let runs: Vec<&Run> = study.runs.iter().filter(|r| r.variant == variant && !r.snapshots.is_empty()).collect();
    if runs.is_empty() {
        return None;
    }
    let noise = study.reference.noise.unwrap_or(0.0);
    let curve = curve(&runs, noise);
    let last: Vec<&Snapshot> = runs.iter().filter_map(|r| r.snapshots.last()).collect();
    let at_budget = point(&last, noise);
    let exponent = exponent(&runs, noise);
    // An error below the reference's own noise is not known.
    let known = last.iter().filter(|s| s.errors.relmse > 2.0 * noise);
    let ratios: Vec<f64> = known.filter_map(|s| Some(s.estimate?.relmse.value / (s.errors.relmse - noise))).collect();
    let pixels = study.reference.picture.pixels.len() as f64;
    let rates =
        runs.iter().filter_map(|r| Some(r.snapshots.last()?.spp as f64 / (r.snapshots.last()?.seconds - r.setup_s)));
    let split = split(study, variant);
    let device = &study.devices[variant];
    Some(Summary {
        variant: study.plan.variants[variant].name.clone(),
        repeats: runs.len(),
        setup_s: median(runs.iter().map(|r| r.setup_s)),
        throughput_MSps: median(rates) * pixels * 1e-6,
        at_budget,
        exponent,
        estimate_ratio: (!ratios.is_empty()).then(|| median(ratios.iter().copied())),
        bias_squared: split.map(|s| s.bias_squared),
        variance: split.map(|s| s.variance),
        bias_spp: split.map(|s| s.spp),
        mean_bias: mean_bias(study, &runs),
        qualities: qualities(&curve, exponent.map_or(-1.0, |e| e.value)),
        curve,
        device: device.name.clone(),
        driver: device.driver.clone(),
        kernel_hash: device.kernel_hash.clone(),
        seeds: runs.iter().map(|r| r.seed).collect(),
    })
}

/// Medians over the replicates at every level that all of them reached, and at the end of the budget.
fn curve(runs: &[&Run], noise: f64) -> Vec<Point> {
    let mut points = Vec::new();
    for snapshot in &runs[0].snapshots {
        let same: Vec<&Snapshot> =
            runs.iter().filter_map(|r| r.snapshots.iter().find(|s| s.spp == snapshot.spp)).collect();
        if same.len() == runs.len() {
            points.push(point(&same, noise));
        }
    }
    let last: Vec<&Snapshot> = runs.iter().filter_map(|r| r.snapshots.last()).collect();
    let end = point(&last, noise);
    if points.last().is_none_or(|p| end.spp > p.spp) {
        points.push(end);
    }
    points
}

fn point(snapshots: &[&Snapshot], noise: f64) -> Point {
    let relmse = |s: &&Snapshot| (s.errors.relmse - noise).max(0.0);
    let low = |f: &dyn Fn(&&Snapshot) -> f64| snapshots.iter().map(f).fold(f64::INFINITY, f64::min);
    let high = |f: &dyn Fn(&&Snapshot) -> f64| snapshots.iter().map(f).fold(0.0, f64::max);
    let flip = |s: &&Snapshot| s.errors.flip;
    Point {
        spp: median(snapshots.iter().map(|s| s.spp as f64)),
        seconds: median(snapshots.iter().map(|s| s.seconds)),
        relmse: median(snapshots.iter().map(relmse)),
        relmse_low: low(&relmse),
        relmse_high: high(&relmse),
        flip: median(snapshots.iter().map(flip)),
        flip_low: low(&flip),
        flip_high: high(&flip),
    }
}

/// Slope of ln relMSE over ln spp, one least-squares line a replicate, and Student's t over the replicates.
fn exponent(runs: &[&Run], noise: f64) -> Option<Interval> {
    let slopes: Vec<f64> = runs
        .iter()
        .filter_map(|run| {
            let points: Vec<(f64, f64)> = (run.snapshots.iter())
                .filter(|s| s.spp >= FIT_FROM_SPP && s.errors.relmse > 2.0 * noise)
                .map(|s| ((s.spp as f64).ln(), (s.errors.relmse - noise).ln()))
                .collect();
            (points.len() >= 3).then(|| slope(&points))
        })
        .collect();
    (slopes.len() >= 2).then(|| interval(&slopes))
}

pub fn slope(points: &[(f64, f64)]) -> f64 {
    let n = points.len() as f64;
    let (mx, my) = points.iter().fold((0.0, 0.0), |(x, y), p| (x + p.0 / n, y + p.1 / n));
    let (xy, xx) =
        points.iter().fold((0.0, 0.0), |(xy, xx), p| (xy + (p.0 - mx) * (p.1 - my), xx + (p.0 - mx).powi(2)));
    xy / xx
}

/// Mean of the values and its interval by Student's t.
pub fn interval(values: &[f64]) -> Interval {
    let m = Moments::of(values.iter().copied());
    let half = m.half_width(0.95);
    Interval { value: m.mean, low: m.mean - half, high: m.mean + half }
}

#[derive(Clone, Copy)]
struct Split {
    spp: u64,
    bias_squared: Interval,
    variance: f64,
}

/// MSE = bias^2 + variance, in units of relMSE: of the replicates' mean image the square of its distance from the reference, less
/// its own variance and the reference's. Pixels are independent, so their scatter gives the interval.
fn split(study: &Study, variant: usize) -> Option<Split> {
    let level = study.levels[variant].iter().rev().find(|l| l.count == study.plan.repeats && l.count >= 2)?;
    let n = f64::from(level.count);
    let reference = &study.reference;
    let (mut terms, mut variance) = (Vec::with_capacity(level.sum.len()), 0.0);
    for (i, r) in reference.picture.pixels.iter().enumerate() {
        let mut term = 0.0;
        for c in 0..3 {
            let r_value = f64::from(r[c]);
            let weight = 1.0 / (3.0 * (r_value * r_value + EPSILON));
            let mean = level.sum[i][c] / n;
            let spread = ((level.square[i][c] - n * mean * mean) / (n - 1.0)).max(0.0);
            let noise = reference.variance.as_ref().map_or(0.0, |v| f64::from(v[i][c]));
            term += weight * ((mean - r_value).powi(2) - spread / n - noise);
            variance += weight * spread;
        }
        terms.push(term);
    }
    let m = Moments::of(terms.iter().copied());
    let half = student_t_quantile(0.975, m.count - 1.0) * m.variance_of_mean().sqrt();
    let bias_squared = Interval { value: m.mean, low: m.mean - half, high: m.mean + half };
    Some(Split { spp: level.spp, bias_squared, variance: variance / terms.len() as f64 })
}

/// Relative bias of the image mean over the replicates' ends; the reference's own error of the mean widens it.
fn mean_bias(study: &Study, runs: &[&Run]) -> Option<Interval> {
    if runs.len() < 2 {
        return None;
    }
    let values = runs.iter().filter_map(|r| r.snapshots.last()).map(|s| s.errors.bias / s.errors.reference_mean);
    let m = Moments::of(values);
    let reference_mean = runs[0].snapshots.last()?.errors.reference_mean;
    let own = study.reference.standard_error_of_mean().unwrap_or(0.0) / reference_mean;
    let half = student_t_quantile(0.975, m.count - 1.0) * (m.variance_of_mean() + own * own).sqrt();
    Some(Interval { value: m.mean, low: m.mean - half, high: m.mean + half })
}

/// Log-log interpolation on the median curve; beyond its end the fitted exponent goes on.
fn qualities(curve: &[Point], exponent: f64) -> Vec<Quality> {
    QUALITIES.iter().filter_map(|&wanted| quality(curve, exponent, wanted)).collect()
}

fn quality(curve: &[Point], exponent: f64, wanted: f64) -> Option<Quality> {
    let place = curve.iter().position(|p| p.relmse <= wanted);
    let between = |a: f64, b: f64, t: f64| (a.ln() + t * (b.ln() - a.ln())).exp();
    match place {
        Some(0) => {
            Some(Quality { relmse: wanted, seconds: curve[0].seconds, spp: curve[0].spp, is_extrapolated: false })
        }
        Some(i) => {
            let (a, b) = (curve[i - 1], curve[i]);
            let t = (wanted.ln() - a.relmse.ln()) / (b.relmse.max(1e-300).ln() - a.relmse.ln());
            let (seconds, spp) = (between(a.seconds, b.seconds, t), between(a.spp, b.spp, t));
            Some(Quality { relmse: wanted, seconds, spp, is_extrapolated: false })
        }
        None => {
            let (first, end) = (curve.first()?, curve.last()?);
            let factor = (wanted / end.relmse).powf(1.0 / exponent.min(-0.1));
            // Set-up is paid once; only the rest grows.
            let setup = if curve.len() > 1 { (2.0 * first.seconds - curve[1].seconds).max(0.0) } else { 0.0 };
            let seconds = setup + (end.seconds - setup) * factor;
            Some(Quality { relmse: wanted, seconds, spp: end.spp * factor, is_extrapolated: true })
        }
    }
}

/// Middle value; the mean of the middle two of an even count.
pub fn median(values: impl Iterator<Item = f64>) -> f64 {
    crate::report::specialise::median(values.collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(spp: f64, seconds: f64, relmse: f64) -> Point {
        let (relmse_low, relmse_high) = (relmse, relmse);
        Point { spp, seconds, relmse, relmse_low, relmse_high, flip: 0.0, flip_low: 0.0, flip_high: 0.0 }
    }

    #[test]
    fn time_to_quality_on_a_line_of_slope_minus_one() {
        let curve = [at(16.0, 1.1, 1.0), at(32.0, 1.2, 0.5), at(64.0, 1.4, 0.25)];
        let q = quality(&curve, -1.0, 0.5).unwrap();
        assert!((q.spp - 32.0).abs() < 1e-9 && (q.seconds - 1.2).abs() < 1e-9 && !q.is_extrapolated);
        let far = quality(&curve, -1.0, 0.025).unwrap();
        assert!(far.is_extrapolated && (far.spp - 640.0).abs() < 1e-6, "{far:?}");
        // Set-up of 1 s, 0.4 s for 64 samples a pixel.
        assert!((far.seconds - 5.0).abs() < 1e-9, "{far:?}");
    }

    #[test]
    fn the_slope_of_a_power_law() {
        let points: Vec<(f64, f64)> = (4..12).map(|k| (f64::from(k), 3.0 - 1.25 * f64::from(k))).collect();
        assert!((slope(&points) + 1.25).abs() < 1e-12);
    }
}
