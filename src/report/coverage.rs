//! How far a render's estimate of its own error can be believed: the same scene with very many seeds, each judged by all the others.
//!
//! The true relMSE of a replicate is taken against the mean of all other replicates of both samplers, which share nothing with it; with
//! a thousand of each, that mean's own error is a two-thousandth. Counted is how often the 95 % interval holds the true relMSE, and how
//! far the estimate lies from it; both also apart for the renders that call their own tails too heavy.

use std::fmt::Write as _;

use rayon::prelude::*;
use serde::Serialize;

use super::converge::curves::{Interval, median};
use super::replicates::{self, Replicates};
use crate::error::Error;
use crate::film::slot::BLOCK_SAMPLES;
use crate::film::source::DeviceInfo;
use crate::gpu::Device;
use crate::integrator::{SamplerKind, Settings};
use crate::metric::error::{EPSILON, relative_square};
use crate::metric::estimate::{self, FilmError};
use crate::metric::stats::wilson;
use crate::render::blocks_for;
use crate::scene::Scene;

/// One render.
#[derive(Clone, Copy, Debug)]
pub struct Replicate {
    pub seed: u32,
    pub truth: f64,
    pub error: FilmError,
}

impl Replicate {
    fn is_covered(&self) -> bool {
        self.error.relmse.low <= self.truth && self.truth <= self.error.relmse.high
    }
    fn ratio(&self) -> f64 {
        self.error.relmse.value / self.truth
    }
}

/// A scene and a sampler.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    pub bench: &'static str,
    pub scene: String,
    pub sampler: &'static str,
    pub width: u32,
    pub height: u32,
    pub spp: u64,
    pub seeds: u32,
    /// Median over the seeds.
    pub relmse: f64,
    /// Share of 95 % intervals that hold the true relMSE.
    pub coverage: Interval,
    /// Median of estimate over truth, and the quartiles.
    pub estimate_ratio: [f64; 3],
    /// Median of |estimate/truth - 1|.
    pub estimate_off: f64,
    /// Share of renders that say that their tails are too heavy.
    pub flagged: f64,
    /// Coverage among those that do not, and the median of their |estimate/truth - 1|; None where all do.
    pub unflagged_coverage: Option<Interval>,
    pub unflagged_off: Option<f64>,
    #[serde(skip)]
    pub replicates: Vec<Replicate>,
}

/// Both samplers on one scene. `observe` is told how many renders are done.
pub fn measure(
    device: &Device,
    scene: &Scene,
    spp: u64,
    seeds: u32,
    observe: &dyn Fn(usize),
) -> Result<(Vec<Row>, DeviceInfo), Error> {
    let samplers = [("sobol", SamplerKind::Sobol), ("independent", SamplerKind::Independent)];
    let mut pictures: Vec<Vec<[f32; 3]>> = Vec::new();
    let mut errors: Vec<FilmError> = Vec::new();
    let mut info = DeviceInfo::default();
    for (_, sampler) in samplers {
        let settings = Settings { sampler, ..replicates::settings(scene) };
        let mut replicates = Replicates::new(device, scene, &settings)?;
        for seed in 1..=seeds {
            let (film, _) = replicates.film(seed, blocks_of(spp))?;
            pictures.push(film.mean_f32());
            errors.push(estimate::from_film(&film).expect("two blocks at least"));
            observe(pictures.len());
        }
        info = replicates.describe();
    }
    let truths = truths(&pictures);
    let rows = samplers.iter().enumerate().map(|(s, (name, _))| {
        let range = s * seeds as usize..(s + 1) * seeds as usize;
        let of_seed = |i: usize| Replicate { seed: (i - range.start) as u32 + 1, truth: truths[i], error: errors[i] };
        let replicates: Vec<Replicate> = range.clone().map(of_seed).collect();
        row(scene, name, spp, replicates)
    });
    Ok((rows.collect(), info))
}

/// relMSE of each picture against the mean of all others.
fn truths(pictures: &[Vec<[f32; 3]>]) -> Vec<f64> {
    let count = pictures.len() as f64;
    let mut sum = vec![[0.0f64; 3]; pictures.first().map_or(0, Vec::len)];
    for picture in pictures {
        for (sum, pixel) in sum.iter_mut().zip(picture) {
            (0..3).for_each(|c| sum[c] += f64::from(pixel[c]));
        }
    }
    let truth = |picture: &Vec<[f32; 3]>| {
        let term = |(sum, x): (&[f64; 3], &[f32; 3])| {
            let others = std::array::from_fn(|c| ((sum[c] - f64::from(x[c])) / (count - 1.0)) as f32);
            relative_square(*x, others, EPSILON)
        };
        sum.iter().zip(picture).map(term).sum::<f64>() / picture.len() as f64
    };
    pictures.par_iter().map(truth).collect()
}

fn row(scene: &Scene, sampler: &'static str, spp: u64, replicates: Vec<Replicate>) -> Row {
    let mut ratios: Vec<f64> = replicates.iter().map(Replicate::ratio).collect();
    ratios.sort_by(f64::total_cmp);
    let quantile = |q: f64| ratios[((ratios.len() - 1) as f64 * q).round() as usize];
    let off = |list: &mut dyn Iterator<Item = &Replicate>| {
        let all: Vec<f64> = list.map(|r| (r.ratio() - 1.0).abs()).collect();
        (!all.is_empty()).then(|| median(all.into_iter()))
    };
    let covered = |list: &mut dyn Iterator<Item = &Replicate>| {
        let (hits, count) = list.fold((0, 0), |(h, n), r| (h + u64::from(r.is_covered()), n + 1));
        let [low, high] = wilson(hits, count, 0.95);
        (count > 0).then(|| Interval { value: hits as f64 / count as f64, low, high })
    };
    let trusted = || replicates.iter().filter(|r| !r.error.is_heavy_tailed);
    Row {
        bench: "coverage",
        scene: scene.name.clone(),
        sampler,
        width: scene.film.width,
        height: scene.film.height,
        spp: blocks_of(spp) * u64::from(BLOCK_SAMPLES),
        seeds: replicates.len() as u32,
        relmse: median(replicates.iter().map(|r| r.truth)),
        coverage: covered(&mut replicates.iter()).expect("there are seeds"),
        estimate_ratio: [quantile(0.5), quantile(0.25), quantile(0.75)],
        estimate_off: off(&mut replicates.iter()).expect("there are seeds"),
        flagged: 1.0 - trusted().count() as f64 / replicates.len() as f64,
        unflagged_coverage: covered(&mut trusted()),
        unflagged_off: off(&mut trusted()),
        replicates,
    }
}

pub fn markdown(rows: &[Row]) -> String {
    let mut text = String::from(
        "| scene | sampler | relMSE, median | intervals that hold it | estimate / truth: median [quartiles] | off by, median | say that tails are too heavy | of the others: hold it | off by |\n\
         |---|---|---|---|---|---|---|---|---|\n",
    );
    let percent = |v: f64| format!("{:.1} %", 100.0 * v);
    let interval = |i: &Interval| format!("{} [{:.1}, {:.1}]", percent(i.value), 100.0 * i.low, 100.0 * i.high);
    for r in rows {
        let [middle, low, high] = r.estimate_ratio;
        let _ = writeln!(
            text,
            "| {} | {} | {:.2e} | {} | {middle:.2} [{low:.2}, {high:.2}] | {} | {} | {} | {} |",
            r.scene,
            r.sampler,
            r.relmse,
            interval(&r.coverage),
            percent(r.estimate_off),
            percent(r.flagged),
            r.unflagged_coverage.as_ref().map_or("-".into(), interval),
            r.unflagged_off.map_or("-".into(), percent),
        );
    }
    text
}

/// One line a render.
pub fn csv(rows: &[Row]) -> String {
    let mut text =
        String::from("scene,sampler,seed,relmse,estimate,low,high,heavy_tails,effective_pixels,effective_blocks\n");
    for row in rows {
        for r in &row.replicates {
            let e = &r.error;
            let _ = writeln!(
                text,
                "{},{},{},{:.3e},{:.3e},{:.3e},{:.3e},{},{:.0},{:.2}",
                row.scene,
                row.sampler,
                r.seed,
                r.truth,
                e.relmse.value,
                e.relmse.low,
                e.relmse.high,
                u8::from(e.is_heavy_tailed),
                e.effective_pixels,
                e.effective_blocks
            );
        }
    }
    text
}

/// Blocks of so many samples, two at least: fewer have no estimate.
fn blocks_of(spp: u64) -> u64 {
    blocks_for(spp).max(2)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_is_judged_by_the_others() {
        let pictures = [vec![[1.0f32; 3]], vec![[2.0; 3]], vec![[4.0; 3]]];
        let found = truths(&pictures);
        for (f, (x, others)) in found.iter().zip([(1.0, 3.0), (2.0, 2.5), (4.0, 1.5)]) {
            let wanted = (x - others) * (x - others) / (others * others + EPSILON);
            assert!((f / wanted - 1.0f64).abs() < 1e-6, "{f} {wanted}");
        }
    }
}
