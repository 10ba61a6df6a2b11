//! Error of a render without a reference, from the spread of its own blocks.
//!
//! relMSE of the image = mean over pixels and channels of (x-r)^2 / (r^2 + eps), whose expectation is
//! mean of var(x) / (r^2 + eps). The variance of each mean comes from its n block means (n may differ from pixel to pixel), r from the mean itself or, where that
//! is not well known, from the mean of the 24 pixels around. The interval is
//! for the relMSE that this very image has: of a pixel's term e both the true square (variance 2 e^2 for normal errors) and the
//! estimate (2 e^2/(n-1)) scatter. Blocks of one scramble are not quite independent; the estimate is usually conservative
//! then. Below 2 blocks there is none. Coverage is tested in src/render/tests.rs.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::error::{EPSILON, EPSILON_OF_MEAN, trimmed_count};
use super::stats::student_t_quantile;
use crate::film::Film;

/// Share of the estimate in the worst 0.1 % of pixels above which the tails are too heavy to trust the interval.
const HEAVY_TAIL_SHARE: f64 = 0.5;

/// Relative standard error up to which a pixel's own mean stands for r.
const WELL_KNOWN: f64 = 0.25;

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
    /// The worst 0.1 % of pixels hold more than half of the estimate: the interval is not to be trusted.
    pub is_heavy_tailed: bool,
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
    let scales = scales(film);
    let mut terms: Vec<f64> = pixel_terms(film, &scales, EPSILON);
    let relmse = with_interval(&terms, &dof);
    let relmse_exposure = with_interval(&pixel_terms(film, &scales, epsilon_exposure), &dof);
    terms.sort_by(f64::total_cmp);
    let total: f64 = terms.iter().sum();
    terms.truncate(terms.len() - trimmed_count(terms.len()));
    let kept: f64 = terms.iter().sum();
    Some(FilmError {
        relmse,
        relmse_exposure,
        relmse_trimmed: kept / terms.len().max(1) as f64,
        is_heavy_tailed: total > 0.0 && total - kept > HEAVY_TAIL_SHARE * total,
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

/// Each pixel's var / (r^2 + eps), averaged over its channels.
fn pixel_terms(film: &Film, scales: &[[f64; 3]], epsilon: f64) -> Vec<f64> {
    let term = |pixel: usize| {
        let variance = film.variance_of_mean(pixel);
        let r = scales[pixel];
        (0..3).map(|c| variance[c] / (r[c] * r[c] + epsilon)).sum::<f64>() / 3.0
    };
    (0..film.pixel_count()).into_par_iter().map(term).collect()
}

/// What stands for r: the pixel's own mean where that is well known, else the mean of the 24 around. The own mean of a
/// pixel that just met a rare bright path is as wrong as its variance is large, and would hide the error it causes: with
/// the showcase at 64 spp the estimate was a third of the true relMSE.
fn scales(film: &Film) -> Vec<[f64; 3]> {
    let (width, height) = (film.width() as i64, film.height() as i64);
    let means: Vec<[f64; 3]> = (0..film.pixel_count()).into_par_iter().map(|pixel| film.mean(pixel)).collect();
    let scale = |pixel: usize| -> [f64; 3] {
        let variance = film.variance_of_mean(pixel);
        let (x, y) = (pixel as i64 % width, pixel as i64 / width);
        std::array::from_fn(|c| {
            let own = means[pixel][c];
            if variance[c] <= (WELL_KNOWN * own).powi(2) {
                return own;
            }
            let (mut sum, mut count) = (0.0, 0.0);
            for j in (y - 2).max(0)..(y + 3).min(height) {
                for i in (x - 2).max(0)..(x + 3).min(width) {
                    if (i, j) != (x, y) {
                        sum += means[(j * width + i) as usize][c];
                        count += 1.0;
                    }
                }
            }
            if count > 0.0 { sum / count } else { own }
        })
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
    let half_width = student_t_quantile(0.975, total * total / carried) * variance.sqrt() / count;
    Estimate { value, low: (value - half_width).max(0.0), high: value + half_width }
}
