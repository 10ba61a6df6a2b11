//! Adaptive sampling: samples go where the error is, and no pixel's mean is biased by it.
//!
//! Of n samples in all, the sum of v_p / n_p over the pixels is smallest for n_p in proportion to sqrt(v_p), where v_p is what a block of
//! pixel p adds to the relative error: its variance over r^2 + (0.1 mean)^2 (relMSE as `--error` reads it). Such an n_p is not
//! known; it must be guessed from samples, and a count that depends on the samples that it counts biases their mean: a pixel stops when it
//! happens to look converged, which is when it has missed what is rare (Kirk and Arvo 1991, "Unbiased sampling techniques for image
//! synthesis").
//!
//! Here no count depends on the samples of its own pixel. Pixels are coloured like a chessboard. **Counts of white pixels are made
//! from samples of black ones and from nothing else, and the other way round**: the variance (that of the pixels of the other colour
//! within 5x5), the image's mean, and the factor that makes the counts of a colour add up to its half of the samples. Pixels share no
//! random numbers (`sampler::SampleId`). So, whatever the black samples are, given them the counts of white pixels are constants, and the
//! means of so many samples unbiased. That would fail if a black pixel's part in it depended on how many samples it has, which white
//! ones decide; so only its first `floor` blocks speak, and that number is the same for all and known beforehand:
//!
//! - up to 4 blocks a pixel all have the same (floor 4);
//! - at 4 floors a pixel on average, every pixel has 2 floors at least: these become the new floor, and the weights are made anew.
//!
//! Within such an epoch a pixel has a share s_p of the mean: its weight times a factor of its colour, and no more than 8. The counts for m
//! blocks a pixel on average are, for a fixed offset u_p in [0, 1) that rounds fairly, and the count at the epoch's beginning,
//!
//! ```text
//! n_p(m) = max(n_p(begin), floor(max(m/2, t(m) s_p) + u_p)),    t(m) <= m
//! ```
//!
//! with t(m) as large as the sum allows, which is m times the number of pixels. So there is at least half of the mean everywhere (nothing
//! is starved, dark or not), rounded down, and at most eight times the mean. **Counts never fall as m grows**: the step to m + 1 pays one
//! block for each pixel, and with t as it was none asks for more than one, by m/2; so t(m + 1) is no smaller. (A most that grew with m
//! and not with t would ask for eight.) So they depend on m and the seed and not on how a render is cut into passes, and it can be
//! repeated. The factor makes max(1/2, s_p) a little more than 1 on average: else t = m, rounded, might leave some of the sum over.
//!
//! A pixel far ahead of the floor passes later floors early: its statistics are noted when it has exactly 8, 16, ... blocks, 8 bytes each,
//! and kept in part files (`store`).
//!
//! What is not covered: which m a render ends at, by `--time` or `--error`, depends on its samples as it does without this. Errors of
//! neighbours may be correlated in the second order: each had a say in the other's count. Measured: docs/adaptive.md. Tests:
//! film/adaptive/tests.rs.

mod store;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::error::Error;
use crate::film::slot::BLOCK_SAMPLES;
use crate::film::source::{PassStats, SampleSource};
use crate::film::spans::Span;
use crate::film::{Film, Tile};
use crate::metric::error::EPSILON_OF_MEAN;

/// Blocks that all pixels take before any is preferred: of 12 neighbours 36 degrees of freedom.
const FIRST_FLOOR: u32 = 4;
/// No pixel has less than the mean over this (rounded down), nor more than `MOST` times the mean.
const LEAST: u64 = 2;
const MOST: f64 = 8.0;
/// Shares are summed in whole parts of so many, for the sum to be the same in any order: and they come to one part in `SPARE` more than 1.
const PARTS: u64 = 1 << 20;
const SPARE: u64 = 64;
/// Neighbours are read this far away: 12 of the other colour in 5x5.
const REACH: usize = 2;
/// Least weight in parts of the mean one, so that samples which the largest may not have find a taker.
const LEAST_WEIGHT: f64 = 1e-3;

/// What a pixel's first blocks say: root of its mean square over the channels, and of the variance of a block's mean.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub(super) struct Noted {
    mean: f32,
    deviation: f32,
}

/// Samples of the pixels of an adaptive render.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Spread {
    pub fewest_spp: u64,
    pub most_spp: u64,
}

impl Film {
    /// Blocks to come go where the error is. The film must be empty, and begin with the first block.
    pub fn begin_adaptive(&mut self) {
        assert!(self.sample_count() == 0 && self.first_block() == 0, "statistics of all blocks are noted");
        self.adaptive = Some(Box::new(Adaptive::new(self.window())));
    }

    pub fn is_adaptive(&self) -> bool {
        self.adaptive.is_some()
    }

    /// None where all pixels are to have the same.
    pub fn spread(&self) -> Option<Spread> {
        let samples = |blocks: u32| u64::from(blocks) * u64::from(BLOCK_SAMPLES);
        let (fewest, most) = (self.min_block_count(), self.max_block_count());
        self.is_adaptive().then(|| Spread { fewest_spp: samples(fewest), most_spp: samples(most) })
    }

    /// Blocks of every pixel, or where sampling is adaptive of a pixel on average. A source that was stopped may have left out some.
    pub fn blocks_done(&self) -> u64 {
        self.adaptive.as_ref().map_or(u64::from(self.min_block_count()), |adaptive| adaptive.mean())
    }

    /// Samples a pixel: the fewest of any, or where sampling is adaptive the mean, rounded down.
    pub fn spp(&self) -> u64 {
        match self.is_adaptive() {
            true => self.sample_count() / self.pixel_count().max(1) as u64,
            false => u64::from(self.min_block_count()) * u64::from(BLOCK_SAMPLES),
        }
    }
}

/// Takes samples into an adaptive film until it has `mean` blocks a pixel on average: see `Adaptive::advance`.
pub fn advance(
    source: &mut dyn SampleSource,
    film: &mut Film,
    mean: u64,
    stop: &dyn Fn() -> bool,
) -> Result<PassStats, Error> {
    let mut adaptive = film.adaptive.take().expect("the caller asked the film");
    let stats = adaptive.advance(source, film, mean, stop);
    film.adaptive = Some(adaptive);
    stats
}

/// How many blocks each pixel of a window gets.
#[derive(Clone, Debug)]
pub struct Adaptive {
    width: usize,
    pixel_count: usize,
    /// Blocks a pixel on average, so far.
    mean: u64,
    /// First blocks that speak; 0 in the beginning.
    floor: u32,
    /// Counts at the epoch's beginning.
    base: Vec<u32>,
    /// In parts of the mean.
    shares: Vec<f32>,
    /// By log2 of the number of blocks, from that of `floor` on; empty where not yet.
    noted: Vec<Vec<Noted>>,
    weigh: fn(usize, &[Noted]) -> Vec<f32>,
}

impl Adaptive {
    pub fn new(window: Tile) -> Self {
        let pixel_count = window.pixel_count();
        Self {
            width: window.width as usize,
            pixel_count,
            mean: 0,
            floor: 0,
            base: vec![0; pixel_count],
            shares: Vec::new(),
            noted: vec![Vec::new(); u32::BITS as usize],
            weigh,
        }
    }

    /// Blocks a pixel on average.
    pub fn mean(&self) -> u64 {
        self.mean
    }

    /// Host memory.
    pub fn bytes(&self) -> usize {
        let noted: usize = self.noted.iter().map(Vec::len).sum();
        size_of_val(&self.base[..]) + size_of_val(&self.shares[..]) + noted * size_of::<Noted>()
    }

    /// Takes samples until there are `mean` blocks a pixel on average, fewer by a few in all where they do not come out even. When
    /// `stop` turns true it may return early.
    pub fn advance(
        &mut self,
        source: &mut dyn SampleSource,
        film: &mut Film,
        mean: u64,
        stop: &dyn Fn() -> bool,
    ) -> Result<PassStats, Error> {
        let mut stats = PassStats::default();
        while self.mean < mean {
            let next = mean.min(self.epoch_end());
            let counts = self.counts(next);
            let (taken, is_complete) = self.take(source, film, &counts, stop)?;
            stats += taken;
            if !is_complete {
                break;
            }
            self.mean = next;
            if next == self.epoch_end() {
                self.begin_epoch(counts);
            }
        }
        Ok(stats)
    }

    /// Mean blocks at which the floor doubles.
    fn epoch_end(&self) -> u64 {
        if self.floor == 0 { u64::from(FIRST_FLOOR) } else { 2 * LEAST * u64::from(self.floor) }
    }

    fn begin_epoch(&mut self, counts: Vec<u32>) {
        self.base = counts;
        if self.floor > 0 {
            self.noted[self.floor.ilog2() as usize] = Vec::new();
        }
        self.floor = if self.floor == 0 { FIRST_FLOOR } else { 2 * self.floor };
        self.share();
    }

    /// Makes the shares from what pixels had noted at `floor` blocks, which all of them have.
    fn share(&mut self) {
        let weights = (self.weigh)(self.width, &self.noted[self.floor.ilog2() as usize]);
        let factors = [0, 1].map(|colour| {
            let pixels = self.pixels_of(colour);
            let budget = pixels.len() as u64 * (PARTS + PARTS / SPARE);
            let parts = |wanted: f64| (wanted.clamp(1.0 / LEAST as f64, MOST) * PARTS as f64) as u64;
            let sum = |factor: f64| pixels.par_iter().map(|&p| parts(factor * f64::from(weights[p]))).sum::<u64>();
            largest(|factor| sum(factor) <= budget, 1.0 / mean_of(&weights, self.width, colour))
        });
        let share =
            |(p, &weight): (usize, &f32)| (factors[colour_of(p, self.width)] * f64::from(weight)).min(MOST) as f32;
        self.shares = weights.iter().enumerate().map(share).collect();
    }

    fn pixels_of(&self, colour: usize) -> Vec<usize> {
        (0..self.pixel_count).filter(|&p| colour_of(p, self.width) == colour).collect()
    }

    /// Blocks of each pixel at `mean` blocks on average, within the epoch.
    fn counts(&self, mean: u64) -> Vec<u32> {
        if self.floor == 0 {
            return vec![mean as u32; self.pixel_count];
        }
        let least = mean as f64 / LEAST as f64;
        let count = |pixel: usize, scale: f64| {
            let wanted = least.max(scale * f64::from(self.shares[pixel])) + offset(pixel, self.width);
            // Beyond `u32::MAX` the cast stays there.
            (wanted as u32).max(self.base[pixel])
        };
        let scales = [0, 1].map(|colour| {
            let pixels = self.pixels_of(colour);
            let budget = mean * pixels.len() as u64;
            let sum = |scale: f64| pixels.par_iter().map(|&p| u64::from(count(p, scale))).sum::<u64>();
            largest(|scale| scale <= mean as f64 && sum(scale) <= budget, mean as f64)
        });
        (0..self.pixel_count).into_par_iter().map(|p| count(p, scales[colour_of(p, self.width)])).collect()
    }

    /// Renders what pixels lack of `counts`, and notes their statistics where they pass a floor to come. False where it was stopped before
    /// the last.
    fn take(
        &mut self,
        source: &mut dyn SampleSource,
        film: &mut Film,
        counts: &[u32],
        stop: &dyn Fn() -> bool,
    ) -> Result<(PassStats, bool), Error> {
        let mut stats = PassStats::default();
        loop {
            // No further than the next floor at once.
            let span = |pixel: usize| {
                let first = film.block_count(pixel);
                let end = counts[pixel].min((first + 1).next_power_of_two().max(FIRST_FLOOR));
                (first < end).then(|| Span { pixel: pixel as u32, first: u64::from(first), count: end - first })
            };
            let spans: Vec<Span> = (0..self.pixel_count).into_par_iter().filter_map(span).collect();
            if spans.is_empty() {
                return Ok((stats, true));
            }
            stats += source.render_spans(&spans, film, stop)?;
            spans.iter().for_each(|s| self.note(film, s.pixel as usize));
            if stop() {
                return Ok((stats, false));
            }
        }
    }

    fn note(&mut self, film: &Film, pixel: usize) {
        let count = film.block_count(pixel);
        if count < FIRST_FLOOR || !count.is_power_of_two() {
            return;
        }
        let noted = &mut self.noted[count.ilog2() as usize];
        noted.resize(self.pixel_count, Noted::default());
        let root = |squares: [f64; 3]| (squares.iter().sum::<f64>() / 3.0).sqrt() as f32;
        let variance = film.variance_of_mean(pixel).map(|v| v * f64::from(count));
        noted[pixel] = Noted { mean: root(film.mean(pixel).map(|m| m * m)), deviation: root(variance) };
    }
}

/// 0 or 1.
fn colour_of(pixel: usize, width: usize) -> usize {
    (pixel % width + pixel / width) & 1
}

/// In [0, 1), spread evenly over pixels that lie together: the sequence of Roberts 2018 ("The unreasonable effectiveness of
/// quasirandom sequences"), whose two numbers are the powers of 1/1.32471795724474602596.
fn offset(pixel: usize, width: usize) -> f64 {
    ((pixel % width) as f64 * 0.754_877_666_246_692_7 + (pixel / width) as f64 * 0.569_840_290_998_053_2).fract()
}

/// The largest factor that fits, to the last bit; `fits` is true up to some factor, and 0 fits. `first` is where the search begins.
fn largest(fits: impl Fn(f64) -> bool, first: f64) -> f64 {
    let (mut low, mut high) = (0.0, first);
    while fits(high) {
        (low, high) = (high, 2.0 * high);
        if high > 1e300 {
            return low;
        }
    }
    // Ends where two numbers are neighbours, after some 55; more where it is far below `first`.
    for _ in 0..128 {
        let middle = 0.5 * (low + high);
        if middle == low || middle == high {
            break;
        }
        if fits(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

/// Mean over the pixels of a colour; 0 where there are none.
fn mean_of(values: &[f32], width: usize, colour: usize) -> f64 {
    let own = (0..values.len()).filter(|&p| colour_of(p, width) == colour);
    let (sum, count) = own.fold((0.0, 0.0), |(sum, count), p| (sum + f64::from(values[p]), count + 1.0));
    if count > 0.0 { sum / count } else { 0.0 }
}

/// A weight for each pixel, of the pixels of the other colour only: the mean of their relative standard deviations. Tried by counts that
/// follow from the showcase at 64, 128 and 256 spp, and variances from 4096 spp: the expected relMSE at 256, 512 and 1024 spp falls by
/// 1.57, 1.62, 1.66; by 1.29, 1.42, 1.49 with the root of the mean variance over the mean square, which bright samples that few pixels have
/// met rule; and with 24 neighbours instead of 12 by a little less.
fn weigh(width: usize, noted: &[Noted]) -> Vec<f32> {
    let means: Vec<f32> = noted.iter().map(|n| n.mean).collect();
    let epsilon = [0, 1].map(|colour| EPSILON_OF_MEAN * mean_of(&means, width, colour));
    let relative = |(pixel, n): (usize, &Noted)| {
        let scale = f64::from(n.mean).hypot(epsilon[colour_of(pixel, width)]);
        finite((f64::from(n.deviation) / scale) as f32)
    };
    let relative: Vec<f32> = noted.iter().enumerate().map(relative).collect();
    let height = noted.len() / width.max(1);
    let weight = |pixel: usize| {
        let (x, y) = (pixel % width, pixel / width);
        let (mut sum, mut count) = (0.0, 0.0);
        for j in y.saturating_sub(REACH)..(y + REACH + 1).min(height) {
            for i in x.saturating_sub(REACH)..(x + REACH + 1).min(width) {
                if (i + j + x + y) % 2 == 1 {
                    sum += relative[j * width + i];
                    count += 1.0;
                }
            }
        }
        // Without neighbours there is nothing to prefer it for.
        finite(sum / count)
    };
    let weights: Vec<f32> = (0..noted.len()).into_par_iter().map(weight).collect();
    let least = [0, 1].map(|colour| {
        let mean = (LEAST_WEIGHT * mean_of(&weights, width, colour)) as f32;
        if mean > 0.0 { mean } else { 1.0 }
    });
    weights.iter().enumerate().map(|(p, w)| w + least[colour_of(p, width)]).collect()
}

/// 0 for what is no number, as 0/0 in the dark.
fn finite(x: f32) -> f32 {
    if x.is_finite() { x } else { 0.0 }
}

#[cfg(test)]
mod tests;
