//! Multiple importance sampling against Veach's bound, surface by surface, with one sample of each technique.
//!
//! With V the variance of one sample, mu its mean, and "best" the better technique alone. Balance heuristic (Veach 1997, theorem 9.2 with
//! n_1 = n_2 = 1): V <= V_best + (1 - 1/2) mu^2. The kernels use the power heuristic with beta = 2, for which his theorem 9.3 multiplies
//! V_best by a constant. A form that needs no more than a line: its weights satisfy sum w_i^2/p_i <= (9/8) / (p_1 + p_2), for with
//! y = p_1 p_2 / (p_1^2 + p_2^2) the quotient is 1 + y - 2 y^2 <= 9/8. So its second moment is at most 9/8 of V_best + mu^2, of which the
//! squared means of its two parts, mu^2/2 or more, are taken off: V <= 9/8 V_best + 5/8 mu^2. That is checked; the balance heuristic's bound
//! is the stricter, the power heuristic is not promised to meet it, and it is reported beside.
//!
//! Variances come from blocks of independent samples, with light from one bounce only (`direct`): then a sample is one light sample
//! and one of the surface. The place in the pixel is shared by both, which the theorem does not know; it would add half of the variance
//! inside the pixel to the bounds, and is left out. "Best" is the better technique of a whole surface, or of a cell of it. A technique that has
//! not found its light in all the samples of a cell (its mean is off by more than `FOUND`) shows a small variance there, and does not count.

use std::fmt::Write as _;

use serde::Serialize;

use super::converge::curves::{Interval, interval};
use super::replicates::Replicates;
use crate::error::Error;
use crate::film::Film;
use crate::film::aov::{self, Aovs};
use crate::film::slot::BLOCK_SAMPLES;
use crate::film::source::DeviceInfo;
use crate::gpu::Device;
use crate::integrator::{Estimator, IntegratorKind, SamplerKind, Settings};
use crate::metric::error::EPSILON;
use crate::scene::Scene;

const TECHNIQUES: [(Estimator, &str); 3] =
    [(Estimator::Bsdf, "bsdf"), (Estimator::Light, "light"), (Estimator::Mis, "mis")];
const BLOCK: u64 = BLOCK_SAMPLES as u64;
/// Pixels of a cell's side: the smallest part of a surface that is judged.
const CELL: usize = 8;
/// Cells with fewer pixels of the surface are left out: half of a cell.
const CELL_MIN: usize = CELL * CELL / 2;
/// How far the mean of a cell may be off where a technique has found its light: some ten times the standard error of a cell's mean
/// at a variance of its mean square, 32 pixels and 768 samples each (0.6 %).
const FOUND: f64 = 0.05;

/// Variances of one sample over the surface's pixels and channels, as shares of the mean square of the mean.
#[derive(Clone, Debug, Serialize)]
pub struct Surface {
    pub name: String,
    pub pixels: usize,
    pub bsdf: f64,
    pub light: f64,
    pub mis: f64,
    /// Of the better technique.
    pub best: f64,
    pub bound_balance: f64,
    pub bound_power: f64,
    /// Largest quotient of `mis` and the power heuristic's bound in any cell of 8 x 8 pixels.
    pub worst_cell: f64,
}

/// A technique over the whole image.
#[derive(Clone, Debug, Serialize)]
pub struct Technique {
    pub name: &'static str,
    /// relMSE of one sample a pixel.
    pub relmse_of_one: Interval,
    /// Of the device, for a sample of every pixel.
    pub seconds_of_one: Interval,
    /// Their product: relMSE after a second.
    pub relmse_of_second: Interval,
}

#[derive(Clone, Debug, Serialize)]
pub struct Report {
    pub bench: &'static str,
    pub scene: String,
    pub width: u32,
    pub height: u32,
    pub spp: u64,
    pub rounds: u32,
    pub surfaces: Vec<Surface>,
    pub techniques: Vec<Technique>,
    /// Every surface and each of its cells within the bounds, and `mis` below either technique at equal time.
    pub holds: bool,
}

/// Variance of one sample, and the mean, summed over rounds; by pixel.
struct Seen {
    variance: Vec<[f64; 3]>,
    mean: Vec<[f64; 3]>,
    relmse: Vec<f64>,
    seconds: Vec<f64>,
}

/// `rounds` (two at least) of `blocks` blocks of each technique, in turns.
pub fn measure(device: &Device, scene: &Scene, blocks: u64, rounds: u32) -> Result<(Report, DeviceInfo), Error> {
    let base =
        Settings { integrator: IntegratorKind::Direct, sampler: SamplerKind::Independent, ..Settings::default() };
    let mut kernels = Vec::new();
    for (estimator, _) in TECHNIQUES {
        kernels.push(Replicates::new(device, scene, &Settings { estimator, ..base })?);
    }
    let size = scene.film.width as usize * scene.film.height as usize;
    let empty =
        || Seen { variance: vec![[0.0; 3]; size], mean: vec![[0.0; 3]; size], relmse: Vec::new(), seconds: Vec::new() };
    let mut seen: Vec<Seen> = TECHNIQUES.iter().map(|_| empty()).collect();
    // The driver compiles at the first dispatch.
    kernels.iter_mut().try_for_each(|k| k.film(0, 1).map(drop))?;
    for round in 0..rounds {
        for step in 0..TECHNIQUES.len() {
            let t = if round % 2 == 0 { step } else { TECHNIQUES.len() - 1 - step };
            let (film, stats) = kernels[t].film(1 + round, blocks)?;
            seen[t].add(&film, (blocks * BLOCK) as f64, f64::from(rounds));
            seen[t].seconds.push(stats.device_time_s / (blocks * BLOCK) as f64);
        }
    }
    let aovs = Aovs::NONE.with("object");
    let (ids, _) = Replicates::new(device, scene, &Settings { aovs, ..base })?.film(0, 1)?;
    let surfaces = surfaces(scene, &ids, &seen);
    let technique = |(s, (_, name)): (&Seen, &(Estimator, &'static str))| {
        let product: Vec<f64> = s.relmse.iter().zip(&s.seconds).map(|(e, t)| e * t).collect();
        Technique {
            name,
            relmse_of_one: interval(&s.relmse),
            seconds_of_one: interval(&s.seconds),
            relmse_of_second: interval(&product),
        }
    };
    let techniques: Vec<Technique> = seen.iter().zip(&TECHNIQUES).map(technique).collect();
    let at_equal_time = |t: usize| techniques[t].relmse_of_second.value;
    let holds = at_equal_time(2) < at_equal_time(0).min(at_equal_time(1))
        && surfaces.iter().all(|s| s.mis <= s.bound_power && s.worst_cell <= 1.0);
    let report = Report {
        bench: "mis-bound",
        scene: scene.name.clone(),
        width: scene.film.width,
        height: scene.film.height,
        spp: blocks * BLOCK,
        rounds,
        surfaces,
        techniques,
        holds,
    };
    Ok((report, kernels[2].describe()))
}

impl Seen {
    fn add(&mut self, film: &Film, samples: f64, rounds: f64) {
        let mut total = 0.0;
        for pixel in 0..film.pixel_count() {
            let (variance, mean) = (film.variance_of_mean(pixel), film.mean(pixel));
            for c in 0..3 {
                self.variance[pixel][c] += samples * variance[c] / rounds;
                self.mean[pixel][c] += mean[c] / rounds;
                total += samples * variance[c] / (mean[c] * mean[c] + EPSILON);
            }
        }
        self.relmse.push(total / (3.0 * film.pixel_count() as f64));
    }
}

/// Sums over pixels and channels.
#[derive(Clone, Copy, Default)]
struct Sums {
    pixels: usize,
    variances: [f64; 3],
    means: [f64; 3],
    /// Of the mean of `mis`.
    square: f64,
}

impl Sums {
    fn add(&mut self, seen: &[Seen], pixel: usize) {
        self.pixels += 1;
        for c in 0..3 {
            for (t, technique) in seen.iter().enumerate() {
                self.variances[t] += technique.variance[pixel][c];
                self.means[t] += technique.mean[pixel][c];
            }
            self.square += seen[2].mean[pixel][c].powi(2);
        }
    }

    /// Variance of the better technique; None where neither has found the light.
    fn best(&self) -> Option<f64> {
        let has_found = |t: &usize| (self.means[*t] / self.means[2] - 1.0).abs() <= FOUND;
        [0, 1].into_iter().filter(has_found).map(|t| self.variances[t]).reduce(f64::min)
    }
}

/// Surfaces that do not shine, by the objects that fill pixels.
fn surfaces(scene: &Scene, ids: &Film, seen: &[Seen]) -> Vec<Surface> {
    let (width, height) = (ids.width() as usize, ids.height() as usize);
    let index = aov::index_of("object");
    let object = |pixel: usize| {
        let mut met = ids.ids(index, pixel);
        // Of all samples of a block: pixels of one object only.
        met.next().filter(|(_, count)| *count == BLOCK_SAMPLES).map(|(id, _)| id as usize)
    };
    let objects: Vec<Option<usize>> = (0..width * height).map(object).collect();
    let mut list = Vec::new();
    for (number, instance) in scene.instances.iter().enumerate() {
        if scene.materials[instance.material].emits() {
            continue;
        }
        let columns = width.div_ceil(CELL);
        let mut cells = vec![Sums::default(); columns * height.div_ceil(CELL)];
        let mut all = Sums::default();
        for pixel in (0..width * height).filter(|p| objects[*p] == Some(number)) {
            all.add(seen, pixel);
            cells[pixel / width / CELL * columns + pixel % width / CELL].add(seen, pixel);
        }
        let Some(best) = all.best().filter(|_| all.pixels >= CELL_MIN && all.square > 0.0) else { continue };
        let share = |v: f64| v / all.square;
        let judged = cells.iter().filter(|c| c.pixels >= CELL_MIN && c.square > 0.0);
        let quotient = |c: &Sums| Some(c.variances[2] / (1.125 * c.best()? + 0.625 * c.square));
        list.push(Surface {
            name: instance.name.clone(),
            pixels: all.pixels,
            bsdf: share(all.variances[0]),
            light: share(all.variances[1]),
            mis: share(all.variances[2]),
            best: share(best),
            bound_balance: share(best) + 0.5,
            bound_power: 1.125 * share(best) + 0.625,
            worst_cell: judged.filter_map(quotient).fold(0.0, f64::max),
        });
    }
    list
}

pub fn markdown(reports: &[Report]) -> String {
    reports.iter().map(markdown_of).collect::<Vec<_>>().join("\n")
}

fn markdown_of(report: &Report) -> String {
    let mut text = String::from(
        "| surface | pixels | bsdf | light | mis | better of both | bound, balance | bound, power | mis / power's bound, worst 8 x 8 pixels |\n\
         |---|---|---|---|---|---|---|---|---|\n",
    );
    for s in &report.surfaces {
        let _ = writeln!(
            text,
            "| {} | {} | {:.3} | {:.3} | {:.3} | {:.3} | {:.3} | {:.3} | {:.2} |",
            s.name, s.pixels, s.bsdf, s.light, s.mis, s.best, s.bound_balance, s.bound_power, s.worst_cell
        );
    }
    text += "\n| whole image | relMSE of one sample | μs a sample | relMSE after a second |\n|---|---|---|---|\n";
    let pixels = f64::from(report.width * report.height);
    let with = |i: &Interval, scale: f64| format!("{:.3e} ± {:.0e}", scale * i.value, scale * (i.high - i.value));
    for t in &report.techniques {
        let _ = writeln!(
            text,
            "| {} | {} | {} | {} |",
            t.name,
            with(&t.relmse_of_one, 1.0),
            with(&t.seconds_of_one, 1e6 / pixels),
            with(&t.relmse_of_second, 1.0)
        );
    }
    text
}

pub fn csv(reports: &[Report]) -> String {
    let mut text = String::from("scene,surface,pixels,bsdf,light,mis,best,bound_balance,bound_power,worst_cell\n");
    for (report, s) in reports.iter().flat_map(|r| r.surfaces.iter().map(move |s| (r, s))) {
        let _ = writeln!(
            text,
            "{},{},{},{:.5},{:.5},{:.5},{:.5},{:.5},{:.5},{:.4}",
            report.scene,
            s.name,
            s.pixels,
            s.bsdf,
            s.light,
            s.mis,
            s.best,
            s.bound_balance,
            s.bound_power,
            s.worst_cell
        );
    }
    text += "\nscene,technique,relmse_of_one,low,high,seconds_of_one,low,high,relmse_of_second,low,high\n";
    for (report, t) in reports.iter().flat_map(|r| r.techniques.iter().map(move |t| (r, t))) {
        let three = |i: &Interval| format!("{:.5e},{:.5e},{:.5e}", i.value, i.low, i.high);
        let _ = writeln!(
            text,
            "{},{},{},{},{}",
            report.scene,
            t.name,
            three(&t.relmse_of_one),
            three(&t.seconds_of_one),
            three(&t.relmse_of_second)
        );
    }
    text
}

#[cfg(test)]
mod tests {
    /// The line of the page: the power heuristic's second moment over the balance heuristic's.
    #[test]
    fn the_power_heuristic_loses_an_eighth_at_most() {
        let quotient = |x: f64| (1.0 + x.powi(3)) * (1.0 + x) / (1.0 + x * x).powi(2);
        let worst = (0..100_000).map(|i| quotient(f64::from(i) * 1e-4)).fold(0.0, f64::max);
        assert!((worst - 1.125).abs() < 1e-6, "{worst}");
        let y = |x: f64| x / (1.0 + x * x);
        for x in [0.0, 0.1, 0.7, 1.0, 3.0] {
            assert!((quotient(x) - (1.0 + y(x) - 2.0 * y(x) * y(x))).abs() < 1e-12);
        }
    }
}
