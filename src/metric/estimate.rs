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
    if film.min_block_count() < 2 || film.pixel_count() == 0 {
        return None;
    }
    let image_mean = film.image_mean().iter().sum::<f64>() / 3.0;
    let of_mean = (EPSILON_OF_MEAN * image_mean).powi(2);
    let epsilon_exposure = if of_mean > 0.0 { of_mean } else { EPSILON };
    let dof: Vec<f64> = (0..film.pixel_count()).map(|pixel| f64::from(film.block_count(pixel)) - 1.0).collect();
    let known: Vec<Known> =
        (0..film.pixel_count()).into_par_iter().map(|p| (film.mean(p), film.variance_of_mean(p))).collect();
    let scales = scales(film, &known);
    let mut terms: Vec<f64> = pixel_terms(&known, &scales, EPSILON);
    let relmse = with_interval(&terms, &dof);
    let relmse_exposure = with_interval(&pixel_terms(&known, &scales, epsilon_exposure), &dof);
    let effective_pixels = terms.iter().sum::<f64>().powi(2) / terms.iter().map(|e| e * e).sum::<f64>().max(1e-300);
    let effective_blocks = effective_blocks(&known, &terms, &dof);
    let total: f64 = terms.iter().sum();
    let kept = terms.len() - trimmed_count(terms.len());
    if kept < terms.len() {
        terms.select_nth_unstable_by(kept, f64::total_cmp);
    }
    terms.truncate(kept);
    let kept: f64 = terms.iter().sum();
    Some(FilmError {
        relmse,
        relmse_exposure,
        relmse_trimmed: kept / terms.len().max(1) as f64,
        is_heavy_tailed: total > 0.0 && (total - kept > HEAVY_TAIL_SHARE * total || effective_pixels < EFFECTIVE_MIN),
        effective_pixels,
        effective_blocks,
    })
}

/// The relMSE of an image from those of its parts, with their numbers of pixels. Parts are independent of each other: the squares of
/// their half widths add.
pub fn joined(parts: &[(usize, Estimate)]) -> Option<Estimate> {
    let pixels: f64 = parts.iter().map(|p| p.0 as f64).sum();
    if pixels == 0.0 {
        return None;
    }
    let value = parts.iter().map(|(n, e)| *n as f64 * e.value).sum::<f64>() / pixels;
    let half_width = |(n, e): &(usize, Estimate)| (*n as f64 * (e.high - e.value)).powi(2);
    let half_width = parts.iter().map(half_width).sum::<f64>().sqrt() / pixels;
    Some(Estimate { value, low: (value - half_width).max(0.0), high: value + half_width })
}

/// Mean of a pixel and the variance of that.
type Known = ([f64; 3], [f64; 3]);

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

/// Mean of the terms and its interval. A pixel's channels move together, so a term e counts as one value, with as many degrees of
/// freedom nu as its blocks leave. Those of the sum are (sum e)^2 / sum (e^2 / nu) (Satterthwaite 1946): where all nu are equal, nu times
/// the number of pixels that carry the sum.
fn with_interval(terms: &[f64], dof: &[f64]) -> Estimate {
    let count = terms.len() as f64;
    let total: f64 = terms.iter().sum();
    let value = total / count;
    if total <= 0.0 {
        return Estimate { value, low: 0.0, high: value };
    }
    let (mut variance, mut carried) = (0.0, 0.0);
    for (e, nu) in terms.iter().zip(dof) {
        // E[e_hat^2] = e^2 (1 + 2/nu) overstates e^2; divided out.
        variance += e * e / (1.0 + 2.0 / nu) * (2.0 + 2.0 / nu);
        carried += e * e / nu;
    }
    let standard_error = variance.sqrt() / count;
    let factor =
        (student_t_quantile(0.975, total * total / carried) * standard_error / value).hypot(SCALE_UNSURE).exp();
    Estimate { value, low: value / factor, high: value * factor }
}
