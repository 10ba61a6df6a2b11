//! How fast a sampler converges, and what its blocks cost: relMSE from the spread of replicates, without a reference.
//!
//! Of R replicates of N samples, the variance of a pixel over the replicates is the squared error of one (there is no bias: `conform`). The
//! replicates form groups of four; each group gives a line of ln relMSE over ln N, and Student's t over the groups an interval of its
//! slope: -1 for independent samples, steeper where Owen-scrambled nets meet smooth integrands (Owen 1997: up to -3).
//!
//! A pixel's blocks are aligned parts of two scrambled sequences by turns, so that their difference tells the error
//! (`metric::estimate`). What that costs against one long sequence is known without rendering it: N samples are the mean of two nets of
//! N/2, so that one net of N has twice relMSE(2N), and the price is relMSE(N) over that. So is the price of a scramble for each block, the other
//! way to a right estimate: (16/N) relMSE(16) over twice relMSE(2N).

use std::fmt::Write as _;

use serde::Serialize;

use super::converge::curves::{Interval, interval, slope};
use super::panels::{self, Failure, Frame, Line, Panel};
use super::replicates::{self, Replicates};
use crate::error::Error;
use crate::film::Film;
use crate::film::slot::BLOCK_SAMPLES;
use crate::film::source::DeviceInfo;
use crate::gpu::Device;
use crate::integrator::{Estimator, SamplerKind, Settings};
use crate::metric::error::EPSILON;
use crate::metric::estimate;
use crate::scene::Scene;

const BLOCK: u64 = BLOCK_SAMPLES as u64;
/// Replicates of a group.
const GROUP: u32 = 4;

#[derive(Clone, Debug, Serialize)]
pub struct Level {
    pub spp: u64,
    pub relmse: Interval,
    /// relMSE of two sequences, and of a scramble for each block, over that of one long sequence; None at the last level.
    pub of_two: Option<f64>,
    pub of_blocks: Option<f64>,
    /// Mean of the renders' own estimate over this; None for a single block.
    pub estimate_ratio: Option<f64>,
}

#[derive(Clone, Debug, Serialize)]
pub struct Row {
    pub bench: &'static str,
    pub scene: String,
    pub estimator: Estimator,
    pub sampler: SamplerKind,
    pub width: u32,
    pub height: u32,
    pub replicates: u32,
    /// From 32 samples a pixel on.
    pub exponent: Interval,
    pub levels: Vec<Level>,
}

/// Sums over the replicates of a group at one level, pixel by pixel.
#[derive(Clone, Default)]
struct Sums {
    sum: Vec<[f64; 3]>,
    square: Vec<[f64; 3]>,
    estimate: f64,
}

impl Sums {
    fn add(&mut self, film: &Film) {
        self.sum.resize(film.pixel_count(), [0.0; 3]);
        self.square.resize(film.pixel_count(), [0.0; 3]);
        for pixel in 0..film.pixel_count() {
            let mean = film.mean(pixel);
            for c in 0..3 {
                self.sum[pixel][c] += mean[c];
                self.square[pixel][c] += mean[c] * mean[c];
            }
        }
        self.estimate += estimate::from_film(film).map_or(f64::NAN, |e| e.relmse.value);
    }

    /// Unbiased variance of one replicate, in units of relMSE with `mean` for the truth.
    fn relmse(&self, mean: &[[f64; 3]]) -> f64 {
        let n = f64::from(GROUP);
        let mut total = 0.0;
        for ((sum, square), r) in self.sum.iter().zip(&self.square).zip(mean) {
            for c in 0..3 {
                let variance = ((square[c] - sum[c] * sum[c] / n) / (n - 1.0)).max(0.0);
                total += variance / (r[c] * r[c] + EPSILON);
            }
        }
        total / (3.0 * mean.len() as f64)
    }
}

/// `groups` groups of replicates, up to `spp` samples a pixel.
pub fn measure(
    device: &Device,
    scene: &Scene,
    estimator: Estimator,
    sampler: SamplerKind,
    groups: u32,
    spp: u64,
) -> Result<(Row, DeviceInfo), Error> {
    let settings = Settings { estimator, sampler, ..replicates::settings(scene) };
    let mut replicates = Replicates::new(device, scene, &settings)?;
    let levels: Vec<u64> = (0..).map(|k| 1u64 << k).take_while(|blocks| *blocks * BLOCK <= spp.max(128)).collect();
    let mut sums = vec![vec![Sums::default(); levels.len()]; groups as usize];
    for seed in 1..=groups * GROUP {
        let group = &mut sums[((seed - 1) / GROUP) as usize];
        replicates.levels(seed, &levels, &mut |level, film| group[level].add(film))?;
    }
    let mean = mean(&sums);
    // By group, then level.
    let found: Vec<Vec<f64>> = sums.iter().map(|g| g.iter().map(|s| s.relmse(&mean)).collect()).collect();
    let at = |level: usize| interval(&found.iter().map(|g| g[level]).collect::<Vec<_>>());
    let first = at(0).value;
    let told = (levels.iter().enumerate()).map(|(level, &blocks)| {
        let relmse = at(level);
        let estimate = sums.iter().map(|g| g[level].estimate).sum::<f64>() / f64::from(groups * GROUP);
        let spp = blocks * BLOCK;
        // A single block is one sequence still.
        let of_one =
            if blocks == 1 { Some(first) } else { (level + 1 < levels.len()).then(|| 2.0 * at(level + 1).value) };
        let estimate_ratio = Some(estimate / relmse.value).filter(|r| r.is_finite());
        Level {
            spp,
            relmse,
            of_two: of_one.map(|one| relmse.value / one),
            of_blocks: of_one.map(|one| first * BLOCK as f64 / spp as f64 / one),
            estimate_ratio,
        }
    });
    let slopes: Vec<f64> = found
        .iter()
        .map(|g| {
            let points = levels.iter().zip(g).skip(1).map(|(blocks, e)| ((*blocks as f64).ln(), e.max(1e-300).ln()));
            slope(&points.collect::<Vec<_>>())
        })
        .collect();
    let row = Row {
        bench: "exponents",
        scene: scene.name.clone(),
        estimator,
        sampler,
        width: scene.film.width,
        height: scene.film.height,
        replicates: groups * GROUP,
        exponent: interval(&slopes),
        levels: told.collect(),
    };
    Ok((row, replicates.describe()))
}

/// Over all replicates at the last level.
fn mean(sums: &[Vec<Sums>]) -> Vec<[f64; 3]> {
    let last = || sums.iter().filter_map(|g| g.last());
    let mut mean = vec![[0.0; 3]; last().next().map_or(0, |s| s.sum.len())];
    let count = last().count() as f64 * f64::from(GROUP);
    for sums in last() {
        for (mean, sum) in mean.iter_mut().zip(&sums.sum) {
            (0..3).for_each(|c| mean[c] += sum[c] / count);
        }
    }
    mean
}

fn word(value: impl clap::ValueEnum) -> String {
    value.to_possible_value().map_or(String::new(), |v| v.get_name().into())
}

impl Row {
    fn name(&self) -> String {
        format!("{}, {}", self.scene, word(self.estimator))
    }
}

pub fn markdown(rows: &[Row]) -> String {
    let mut text = String::from(
        "| scene, estimator | sampler | exponent [95 %] | at spp | relMSE | own estimate / truth | two sequences / one at 64, 256, 1024, 2048 spp | a scramble for each block / one at 2048 |\n\
         |---|---|---|---|---|---|---|---|\n",
    );
    for r in rows {
        let Some(last) = r.levels.last() else { continue };
        let e = &r.exponent;
        let price = |spp: u64, of: fn(&Level) -> Option<f64>| {
            let level = r.levels.iter().find(|l| l.spp == spp);
            level.and_then(of).map_or("-".into(), |v| format!("{v:.2}"))
        };
        let of_two = [64, 256, 1024, 2048].map(|spp| price(spp, |l| l.of_two)).join(", ");
        let _ = writeln!(
            text,
            "| {} | {} | {:.2} [{:.2}, {:.2}] | {} | {:.2e} [{:.2e}, {:.2e}] | {} | {of_two} | {} |",
            r.name(),
            word(r.sampler),
            e.value,
            e.low,
            e.high,
            last.spp,
            last.relmse.value,
            last.relmse.low,
            last.relmse.high,
            last.estimate_ratio.map_or("-".into(), |v| format!("{v:.2}")),
            price(2048, |l| l.of_blocks),
        );
    }
    text
}

/// One line a level.
pub fn csv(rows: &[Row]) -> String {
    let mut text = String::from(
        "scene,estimator,sampler,replicates,spp,relmse,relmse_low,relmse_high,of_two,of_blocks,estimate_ratio\n",
    );
    let figure = |value: Option<f64>| value.map_or(String::new(), |v| format!("{v:.4}"));
    for r in rows {
        for l in &r.levels {
            let _ = writeln!(
                text,
                "{},{},{},{},{},{:.5e},{:.5e},{:.5e},{},{},{}",
                r.scene,
                word(r.estimator),
                word(r.sampler),
                r.replicates,
                l.spp,
                l.relmse.value,
                l.relmse.low,
                l.relmse.high,
                figure(l.of_two),
                figure(l.of_blocks),
                figure(l.estimate_ratio)
            );
        }
    }
    text
}

/// relMSE against samples, a panel a scene, its samplers as lines.
pub fn svg(rows: &[Row], foot: &[String]) -> Result<Option<String>, Failure> {
    let mut all: Vec<Panel> = Vec::new();
    for r in rows {
        let points = r.levels.iter().map(|l| (l.spp as f64, [l.relmse.value, l.relmse.low, l.relmse.high]));
        let name =
            format!("{}: {:.2} [{:.2}, {:.2}]", word(r.sampler), r.exponent.value, r.exponent.low, r.exponent.high);
        let line = Line { name, points: points.collect(), mark: None };
        match all.iter_mut().find(|p| p.title == r.name()) {
            Some(panel) => panel.lines.push(line),
            None => all.push(Panel { title: r.name(), lines: vec![line], guide: Some(-1.0) }),
        }
    }
    panels::draw(&all, &Frame { x: "samples a pixel", y: "relMSE", size: (430, 330), columns: 2, foot })
}
