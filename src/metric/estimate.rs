//! Error of a render without a reference, from the spread of its own blocks.
//!
//! relMSE of the image = mean over pixels and channels of (x-r)^2 / (r^2 + eps), whose expectation is
//! mean of var(x) / (r^2 + eps). The variance of each mean comes from its n block means (n may differ from pixel to pixel), r from the pixel and those of its neighbours
//! that could be the same (`scales`). The interval is for the relMSE that this very image has: of a pixel's term e both the true square
//! (variance 2 e^2 for normal errors) and the estimate (2 e^2/(n-1)) scatter. It is one of the logarithm: sums that a few pixels carry are
//! wrong by factors. Blocks of one scramble are not quite independent; the estimate is usually conservative then. Below 2 blocks there is
//! none. What no sample has met is not in it. Coverage: src/render/tests.rs, and on real scenes `bench --filter coverage`.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::error::{EPSILON, EPSILON_OF_MEAN, trimmed_count};
use super::stats::student_t_quantile;
use crate::film::Film;

/// Share of the estimate in the worst 0.1 % of pixels above which the tails are too heavy to trust the interval.
const HEAVY_TAIL_SHARE: f64 = 0.5;

/// Fewest effective pixels of a sum that can be trusted: with 16 the true relMSE alone scatters by a third, sqrt(2/16), around its mean.
const EFFECTIVE_MIN: f64 = 16.0;

/// How far the scale r may put the estimate off, as a share: it and the variance come from the same samples. Seen by `bench --filter coverage`
/// with independent samples, where nothing else does: a tenth too little in `metals`. Without it the interval of a large image, whose sum over
/// pixels scatters by a hundredth, would claim what is not known.
const SCALE_UNSURE: f64 = 0.1;

/// An estimated error with its 95 % interval.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    pub value: f64,
    pub low: f64,
    pub high: f64,
}

/// What the film's blocks say of its error.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FilmError {
    pub relmse: Estimate,
    /// With epsilon (0.1 mean r)^2.
    pub relmse_exposure: Estimate,
    /// Without the worst 0.1 % of pixels.
    pub relmse_trimmed: f64,
    /// The worst 0.1 % of pixels hold more than half of the estimate, or it is carried by fewer than 16 pixels: the interval is not
    /// to be trusted.
    pub is_heavy_tailed: bool,
    /// How many pixels carry the estimate: (sum e)^2 / sum e^2.
    pub effective_pixels: f64,
    /// How many blocks carry a pixel's sum, (sum b)^2 / sum b^2 over the number of blocks, averaged with the weights e: 1 where blocks are
    /// alike, one over their number where the error is that of single bright blocks.
    pub effective_blocks: f64,
}

/// The estimate; None while some pixel has fewer than two blocks.
pub fn from_film(film: &Film) -> Option<FilmError> {
    let Seen { dof, known, scales } = Seen::of(film)?;
    let image_mean = film.image_mean().iter().sum::<f64>() / 3.0;
    let of_mean = (EPSILON_OF_MEAN * image_mean).powi(2);
    let epsilon_exposure = if of_mean > 0.0 { of_mean } else { EPSILON };
    let mut terms: Vec<f64> = pixel_terms(&known, &scales, EPSILON);
    let sums = Sums::of(&terms, &dof);
    let effective_blocks = effective_blocks(&known, &terms, &dof);
    let worst = split_worst(&mut terms, trimmed_count(film.pixel_count()));
    Some(FilmError {
        relmse: sums.estimate(),
        relmse_exposure: Sums::of(&pixel_terms(&known, &scales, epsilon_exposure), &dof).estimate(),
        relmse_trimmed: terms.iter().sum::<f64>() / terms.len().max(1) as f64,
        is_heavy_tailed: sums.is_heavy_tailed(&worst),
        effective_pixels: sums.effective_pixels(),
        effective_blocks,
    })
}

/// The relMSE of an image whose film comes in bands that are forgotten one by one: their sums, and the terms of the worst pixels so far.
pub struct Banded {
    sums: Sums,
    worst: Vec<f64>,
    /// How many of the worst are kept: 0.1 % of the image's pixels.
    kept: usize,
}

impl Banded {
    /// Of an image of `pixels`.
    pub fn new(pixels: usize) -> Self {
        Self { sums: Sums::default(), worst: Vec::new(), kept: trimmed_count(pixels) }
    }

    /// Counts in a band. One with fewer than two blocks somewhere says nothing.
    pub fn add(&mut self, band: &Film) {
        let Some(Seen { dof, known, scales }) = Seen::of(band) else { return };
        let mut terms = pixel_terms(&known, &scales, EPSILON);
        self.sums.add(&Sums::of(&terms, &dof));
        self.worst.extend(split_worst(&mut terms, self.kept));
        self.worst = split_worst(&mut self.worst, self.kept);
    }

    /// The estimate, and whether its tails are too heavy to trust the interval (`FilmError::is_heavy_tailed`).
    pub fn estimate(mut self) -> Option<(Estimate, bool)> {
        if self.sums.pixels == 0.0 {
            return None;
        }
        // After an interrupt there are fewer pixels than were to be.
        let worst = split_worst(&mut self.worst, trimmed_count(self.sums.pixels as usize));
        Some((self.sums.estimate(), self.sums.is_heavy_tailed(&worst)))
    }
}

/// Takes the `count` largest terms out of `terms`.
fn split_worst(terms: &mut Vec<f64>, count: usize) -> Vec<f64> {
    let rest = terms.len().saturating_sub(count);
    if (1..terms.len()).contains(&rest) {
        terms.select_nth_unstable_by(rest, f64::total_cmp);
    }
    terms.split_off(rest)
}

/// Mean of a pixel and the variance of that.
type Known = ([f64; 3], [f64; 3]);

/// What is read of a film, once, pixel by pixel.
struct Seen {
    /// Degrees of freedom of the variance.
    dof: Vec<f64>,
    known: Vec<Known>,
    /// r.
    scales: Vec<[f64; 3]>,
}

impl Seen {
    /// None while some pixel has fewer than two blocks.
    fn of(film: &Film) -> Option<Self> {
        if film.min_block_count() < 2 || film.pixel_count() == 0 {
            return None;
        }
        let dof = (0..film.pixel_count()).map(|pixel| f64::from(film.block_count(pixel)) - 1.0).collect();
        let known: Vec<Known> =
            (0..film.pixel_count()).into_par_iter().map(|p| (film.mean(p), film.variance_of_mean(p))).collect();
        let scales = scales(film, &known);
        Some(Self { dof, known, scales })
    }
}

/// Each pixel's var / (r^2 + eps), averaged over its channels.
fn pixel_terms(known: &[Known], scales: &[[f64; 3]], epsilon: f64) -> Vec<f64> {
    let term = |((_, variance), r): (&Known, &[f64; 3])| {
        (0..3).map(|c| variance[c] / (r[c] * r[c] + epsilon)).sum::<f64>() / 3.0
    };
    known.par_iter().zip(scales).map(term).collect()
}

/// See `FilmError::effective_blocks`. With the relative variance v of a mean of n blocks, (sum b)^2 / sum b^2 is n / (1 + (n-1) v).
fn effective_blocks(known: &[Known], terms: &[f64], dof: &[f64]) -> f64 {
    let mut weighted = 0.0;
    for (((mean, variance), term), nu) in known.iter().zip(terms).zip(dof) {
        let of_channel = |c: usize| {
            let relative = variance[c] / (mean[c] * mean[c]);
            if relative.is_finite() { 1.0 / (1.0 + nu * relative) } else { 1.0 }
        };
        weighted += term * (0..3).map(of_channel).sum::<f64>() / 3.0;
    }
    let total: f64 = terms.iter().sum();
    if total > 0.0 { weighted / total } else { 1.0 }
}

/// What stands for r: the mean over the pixel and those of its eight neighbours whose means differ from its own by no more than a standard
/// error of the difference. The own mean of a pixel that just met a rare bright path is as wrong as its variance is large, and would hide
/// the error it causes; its weight is 1 - v with the relative variance v of its mean, which is 1 where a single block holds all. Across an
/// edge neighbours say nothing: without the test, a lamp's rim was divided by the dark beside it, and the estimate was hundreds
/// of times the truth. Means and variances of a pixel rise together, so that its own mean alone makes var/r^2 a tenth too small.
fn scales(film: &Film, known: &[Known]) -> Vec<[f64; 3]> {
    let (width, height) = (film.width() as usize, film.height() as usize);
    let scale = |pixel: usize| -> [f64; 3] {
        let (mean, variance) = known[pixel];
        let (x, y) = (pixel % width, pixel / width);
        let own = |c: usize| if mean[c] == 0.0 { 1.0 } else { (1.0 - variance[c] / (mean[c] * mean[c])).max(0.0) };
        let mut weights: [f64; 3] = std::array::from_fn(own);
        let mut sums: [f64; 3] = std::array::from_fn(|c| weights[c] * mean[c]);
        for j in y.saturating_sub(1)..(y + 2).min(height) {
            for i in x.saturating_sub(1)..(x + 2).min(width) {
                let (other, its_variance) = known[j * width + i];
                for c in (0..3).filter(|_| (i, j) != (x, y)) {
                    if (other[c] - mean[c]).powi(2) <= variance[c] + its_variance[c] {
                        weights[c] += 1.0;
                        sums[c] += other[c];
                    }
                }
            }
        }
        std::array::from_fn(|c| if weights[c] > 1e-9 { sums[c] / weights[c] } else { mean[c] })
    };
    (0..film.pixel_count()).into_par_iter().map(scale).collect()
}

/// What the interval of a sum over pixels' terms e is made from; those of parts of an image add.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    pixels: f64,
    /// Of e and of e^2.
    total: f64,
    squares: f64,
    /// Of the total, and sum e^2 / nu.
    variance: f64,
    carried: f64,
}

impl Sums {
    /// A pixel's channels move together, so a term counts as one value, with as many degrees of freedom nu as its blocks leave.
    fn of(terms: &[f64], dof: &[f64]) -> Self {
        let mut sums = Self { pixels: terms.len() as f64, ..Self::default() };
        for (e, nu) in terms.iter().zip(dof) {
            sums.total += e;
            sums.squares += e * e;
            // E[e_hat^2] = e^2 (1 + 2/nu) overstates e^2; divided out.
            sums.variance += e * e / (1.0 + 2.0 / nu) * (2.0 + 2.0 / nu);
            sums.carried += e * e / nu;
        }
        sums
    }

    fn add(&mut self, other: &Self) {
        self.pixels += other.pixels;
        self.total += other.total;
        self.squares += other.squares;
        self.variance += other.variance;
        self.carried += other.carried;
    }

    /// Mean of the terms and its interval. The degrees of freedom of the sum are (sum e)^2 / sum (e^2 / nu) (Satterthwaite 1946): where
    /// all nu are equal, nu times the number of pixels that carry the sum. What the scale leaves unsure is common to all pixels, and
    /// counts once however many parts there are.
    fn estimate(&self) -> Estimate {
        let value = self.total / self.pixels;
        if self.total <= 0.0 {
            return Estimate { value, low: 0.0, high: value };
        }
        let relative = self.variance.sqrt() / self.total;
        let quantile = student_t_quantile(0.975, self.total * self.total / self.carried);
        let factor = (quantile * relative).hypot(SCALE_UNSURE).exp();
        Estimate { value, low: value / factor, high: value * factor }
    }

    /// How many pixels carry the total.
    fn effective_pixels(&self) -> f64 {
        self.total * self.total / self.squares.max(1e-300)
    }

    fn is_heavy_tailed(&self, worst: &[f64]) -> bool {
        let held: f64 = worst.iter().sum();
        self.total > 0.0 && (held > HEAVY_TAIL_SHARE * self.total || self.effective_pixels() < EFFECTIVE_MIN)
    }
}
