//! Error of a render without a reference, from the difference of its own two halves.
//!
//! relMSE of the image = mean over pixels and channels of (x-r)^2 / (r^2 + eps), whose expectation is
//! mean of var(x) / (r^2 + eps). The variance of each mean comes from the difference of the means of its even and odd blocks, which share no
//! random numbers (`Film::variance_by_halves`): blocks of one Sobol sequence complete each other, and their spread alone says up to 80 times
//! too much on smooth scenes. r comes from the pixel and those of its neighbours that could be the same (`scales`). The interval is for the
//! relMSE that this very image has: of a pixel's term e both the true square and the estimate scatter, by 2 e^2 each for normal errors. It is
//! one of the logarithm: sums that a few pixels carry are wrong by factors. Who carries a sum is seen in the spread of the blocks, which
//! scatters less. Below 2 blocks there is no estimate. What no sample has met is not in it. Coverage: src/render/tests.rs, and on real scenes
//! `bench --filter coverage`.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::error::{EPSILON, EPSILON_OF_MEAN, trimmed_count};
use super::stats::student_t_quantile;
use crate::film::Film;

/// Share of the estimate in the worst 0.1 % of pixels above which the tails are too heavy to trust the interval.
const HEAVY_TAIL_SHARE: f64 = 0.5;

/// Fewest effective pixels of a sum that can be trusted: with 16 the true relMSE alone scatters by a third, sqrt(2/16), around its mean.
const EFFECTIVE_MIN: f64 = 16.0;

/// A neighbourhood counts as flat where all means lie within so many of its standard errors (root mean square) of the median. Of nine
/// pixels a single one that holds all the variance may then be 4/3 of its own error away: one bright path is 1 away however many blocks
/// there are, the rim of a small bright lamp that k samples met about the root of k. Seen with 4 and 6 (64 pixels high, 64 spp, Sobol
/// and independent): `metals` 0.88 and 0.95, 0.93 and 0.99 of the truth; 0.82 and 0.90 where none counts as flat, 1.00 with the true r.
/// But with 6 a coarse texture under noise (src/render/tests.rs) is 1.13.
const NEAR_ERRORS: f64 = 4.0;

/// How far the scale r may put the estimate off, as a share: it and the variance come from the same samples. Without it the interval of a
/// large image, whose sum over pixels scatters by a hundredth, would claim what is not known. `bench --filter coverage` sees 1 to 5 % in
/// `cornell` and in `metals` with independent samples; 12 % in `metals` with Sobol samples, of whose intervals 86 % hold the truth.
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
    /// How many pixels carry the estimate: (sum e)^2 / sum e^2 of terms from the spread of the blocks, whose own scatter makes it up to
    /// 3 times less (two blocks).
    pub effective_pixels: f64,
    /// How many blocks carry a pixel's sum, (sum b)^2 / sum b^2 over the number of blocks, averaged with the weights e: 1 where blocks are
    /// alike, one over their number where the error is that of single bright blocks.
    pub effective_blocks: f64,
}

/// The estimate; None while some pixel has fewer than two blocks.
pub fn from_film(film: &Film) -> Option<FilmError> {
    let seen = Seen::of(film)?;
    let image_mean = film.image_mean().iter().sum::<f64>() / 3.0;
    let of_mean = (EPSILON_OF_MEAN * image_mean).powi(2);
    let epsilon_exposure = if of_mean > 0.0 { of_mean } else { EPSILON };
    let mut by_blocks = seen.terms(&seen.by_blocks, EPSILON);
    let carried = Sums::of(&by_blocks);
    let effective_blocks = seen.effective_blocks(film, &by_blocks);
    let count = trimmed_count(film.pixel_count());
    let worst = split_worst(&mut by_blocks, count);
    let mut terms = seen.terms(&seen.by_halves, EPSILON);
    let sums = Sums::of(&terms);
    split_worst(&mut terms, count);
    Some(FilmError {
        relmse: sums.estimate(),
        relmse_exposure: Sums::of(&seen.terms(&seen.by_halves, epsilon_exposure)).estimate(),
        relmse_trimmed: terms.iter().sum::<f64>() / terms.len().max(1) as f64,
        is_heavy_tailed: carried.is_heavy_tailed(&worst),
        effective_pixels: carried.effective_pixels(),
        effective_blocks,
    })
}

/// The relMSE of an image whose film comes in bands that are forgotten one by one: their sums, and the terms of the worst pixels so far.
pub struct Banded {
    by_halves: Sums,
    by_blocks: Sums,
    worst: Vec<f64>,
    /// How many of the worst are kept: 0.1 % of the image's pixels.
    kept: usize,
}

impl Banded {
    /// Of an image of `pixels`.
    pub fn new(pixels: usize) -> Self {
        let none = Sums::default();
        Self { by_halves: none, by_blocks: none, worst: Vec::new(), kept: trimmed_count(pixels) }
    }

    /// Counts in a band. One with fewer than two blocks somewhere says nothing.
    pub fn add(&mut self, band: &Film) {
        let Some(seen) = Seen::of(band) else { return };
        self.by_halves.add(&Sums::of(&seen.terms(&seen.by_halves, EPSILON)));
        let mut terms = seen.terms(&seen.by_blocks, EPSILON);
        self.by_blocks.add(&Sums::of(&terms));
        self.worst.extend(split_worst(&mut terms, self.kept));
        self.worst = split_worst(&mut self.worst, self.kept);
    }

    /// The estimate, and whether its tails are too heavy to trust the interval (`FilmError::is_heavy_tailed`).
    pub fn estimate(mut self) -> Option<(Estimate, bool)> {
        if self.by_halves.pixels == 0.0 {
            return None;
        }
        // After an interrupt there are fewer pixels than were to be.
        let worst = split_worst(&mut self.worst, trimmed_count(self.by_halves.pixels as usize));
        Some((self.by_halves.estimate(), self.by_blocks.is_heavy_tailed(&worst)))
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

/// What is read of a film, once, pixel by pixel.
struct Seen {
    means: Vec<[f64; 3]>,
    /// Variance of the mean.
    by_halves: Vec<[f64; 3]>,
    /// The same from the spread of all blocks: too much where blocks complete each other.
    by_blocks: Vec<[f64; 3]>,
    /// r.
    scales: Vec<[f64; 3]>,
}

impl Seen {
    /// None while some pixel has fewer than two blocks.
    fn of(film: &Film) -> Option<Self> {
        if film.min_block_count() < 2 || film.pixel_count() == 0 {
            return None;
        }
        let each = |value: &(dyn Fn(usize) -> [f64; 3] + Sync)| -> Vec<[f64; 3]> {
            (0..film.pixel_count()).into_par_iter().map(value).collect()
        };
        let (means, by_blocks) = (each(&|p| film.mean(p)), each(&|p| film.variance_of_mean(p)));
        let scales = scales(film, &means, &by_blocks);
        Some(Self { means, by_halves: each(&|p| film.variance_by_halves(p)), by_blocks, scales })
    }

    /// Each pixel's var / (r^2 + eps), averaged over its channels.
    fn terms(&self, variances: &[[f64; 3]], epsilon: f64) -> Vec<f64> {
        let term = |(variance, r): (&[f64; 3], &[f64; 3])| {
            (0..3).map(|c| variance[c] / (r[c] * r[c] + epsilon)).sum::<f64>() / 3.0
        };
        variances.par_iter().zip(&self.scales).map(term).collect()
    }

    /// See `FilmError::effective_blocks`. With the relative variance v of a mean of n blocks, (sum b)^2 / sum b^2 is n / (1 + (n-1) v).
    fn effective_blocks(&self, film: &Film, terms: &[f64]) -> f64 {
        let mut weighted = 0.0;
        for (pixel, term) in terms.iter().enumerate() {
            let rest = f64::from(film.block_count(pixel)) - 1.0;
            let of_channel = |c: usize| {
                let relative = self.by_blocks[pixel][c] / self.means[pixel][c].powi(2);
                if relative.is_finite() { 1.0 / (1.0 + rest * relative) } else { 1.0 }
            };
            weighted += term * (0..3).map(of_channel).sum::<f64>() / 3.0;
        }
        let total: f64 = terms.iter().sum();
        if total > 0.0 { weighted / total } else { 1.0 }
    }
}

/// What stands for r in every pixel and channel: see `scale_of`.
fn scales(film: &Film, means: &[[f64; 3]], variances: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let (width, height) = (film.width() as usize, film.height() as usize);
    let scale = |pixel: usize| -> [f64; 3] {
        let (x, y) = (pixel % width, pixel / width);
        let (mut around, mut count) = ([0; 8], 0);
        for j in y.saturating_sub(1)..(y + 2).min(height) {
            for i in (x.saturating_sub(1)..(x + 2).min(width)).filter(|&i| (i, j) != (x, y)) {
                around[count] = j * width + i;
                count += 1;
            }
        }
        std::array::from_fn(|c| {
            let known = |p: usize| Known { mean: means[p][c], variance: variances[p][c] };
            scale_of(known(pixel), &around.map(known)[..count])
        })
    };
    (0..film.pixel_count()).into_par_iter().map(scale).collect()
}

/// One channel of a pixel's mean, and its variance from the spread of the blocks.
#[derive(Clone, Copy)]
struct Known {
    mean: f64,
    variance: f64,
}

/// r of a pixel with these neighbours. Means and variances rise together: the own mean of a pixel that just met a rare bright path is as
/// wrong as its variance is large, and would hide the error it causes. So r is the mean over the neighbourhood where that is flat: where
/// noise alone could make its means differ from their median as they do. Elsewhere there may be an edge, across which neighbours say
/// nothing (the rim of a lamp divided by the dark beside it would be hundreds of times the truth): only those count whose means differ
/// from the own by no more than a standard error of the difference. The own mean has the weight 1 - v, with v its relative variance,
/// which is 1 where a single block holds all.
fn scale_of(own: Known, around: &[Known]) -> f64 {
    let mut means = [0.0; 8];
    let means = &mut means[..around.len()];
    means.iter_mut().zip(around).for_each(|(mean, o)| *mean = o.mean);
    means.sort_unstable_by(f64::total_cmp);
    let median = means.get(means.len() / 2).copied().unwrap_or(own.mean);
    let everyone = || around.iter().chain([&own]);
    let square = everyone().map(|o| o.variance).sum::<f64>() / (around.len() + 1) as f64;
    let is_flat = everyone().all(|o| (o.mean - median).abs() <= NEAR_ERRORS * square.sqrt());
    let mut weight = if own.mean == 0.0 { 1.0 } else { (1.0 - own.variance / (own.mean * own.mean)).max(0.0) };
    let mut sum = weight * own.mean;
    for o in around {
        if is_flat || (o.mean - own.mean).powi(2) <= own.variance + o.variance {
            weight += 1.0;
            sum += o.mean;
        }
    }
    if weight > 1e-9 { sum / weight } else { own.mean }
}

/// Sums over pixels' terms e; those of parts of an image add.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    pixels: f64,
    /// Of e and of e^2.
    total: f64,
    squares: f64,
}

impl Sums {
    /// A pixel's channels move together, so a term counts as one value.
    fn of(terms: &[f64]) -> Self {
        let (total, squares) = terms.iter().fold((0.0, 0.0), |(total, squares), e| (total + e, squares + e * e));
        Self { pixels: terms.len() as f64, total, squares }
    }

    fn add(&mut self, other: &Self) {
        self.pixels += other.pixels;
        self.total += other.total;
        self.squares += other.squares;
    }

    /// Mean of terms of one degree of freedom, and its interval. The estimates' squares are on average three times the true
    /// terms' squares. The total and the truth scatter by four of those; the degrees of freedom of the sum are (sum e)^2 / sum e^2
    /// (Satterthwaite 1946), the number of pixels that carry it. What the scale leaves unsure is common to all pixels, and counts once
    /// however many parts there are.
    fn estimate(&self) -> Estimate {
        let value = self.total / self.pixels;
        if self.total <= 0.0 {
            return Estimate { value, low: 0.0, high: value };
        }
        let squares = self.squares / 3.0;
        let relative = (4.0 * squares).sqrt() / self.total;
        let quantile = student_t_quantile(0.975, self.total * self.total / squares);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::aov::Aovs;
    use crate::film::noise::hash;
    use crate::film::slot::{BLOCK_SAMPLES, SlotRecord};
    use crate::prepare::records::NONE;

    /// Uniform, of mean 0 and variance 1.
    fn noise(keys: [u64; 3]) -> f64 {
        ((hash(keys) >> 11) as f64 / (1u64 << 53) as f64 - 0.5) * 12f64.sqrt()
    }

    /// Blocks of a sequence complete each other: their deviations of 0.3 cancel in pairs, up to 0.03 common to the sequence.
    fn value(pixel: u64, block: u64) -> f64 {
        let (sequence, k) = (block % 2, block / 2);
        let own = noise([pixel, sequence, k / 2]) * if k.is_multiple_of(2) { 0.3 } else { -0.3 };
        1.0 + own + 0.03 * noise([pixel, sequence, 1000])
    }

    #[test]
    fn scales_are_of_the_neighbourhood_where_it_is_flat_and_own_at_edges() {
        let known = |mean: f64, error: f64| Known { mean, variance: error * error };
        let around = |list: &[(f64, f64)]| list.iter().map(|&(m, e)| known(m, e)).collect::<Vec<_>>();
        // One bright path in the pixel: its mean tells nothing.
        let flat =
            around(&[(1.0, 0.2), (0.9, 0.2), (1.1, 0.2), (1.0, 0.2), (1.2, 0.3), (0.8, 0.1), (1.0, 0.2), (1.0, 0.2)]);
        let r = scale_of(known(4.0, 3.0), &flat);
        assert!((r - 1.0).abs() < 0.2, "{r}");
        // The rim of a lamp, whose neighbours are the lamp and the dark.
        let edge = around(&[(10.0, 0.0), (10.0, 0.0), (0.1, 0.02), (0.1, 0.02), (0.1, 0.02), (0.1, 0.02), (0.1, 0.02)]);
        assert_eq!(scale_of(known(4.0, 0.5), &edge), 4.0);
        // A thin bright line, seen without doubt; a pixel without neighbours, and one where nothing is.
        let dark = around(&[(0.1, 0.02); 8]);
        assert_eq!(scale_of(known(4.0, 0.5), &dark), 4.0);
        assert_eq!(scale_of(known(4.0, 0.5), &[]), 4.0);
        assert_eq!(scale_of(known(0.0, 0.0), &around(&[(0.0, 0.0); 3])), 0.0);
    }

    #[test]
    fn blocks_that_complete_each_other_are_seen_through() {
        let mut film = Film::new(64, 64, Aovs::NONE, 0);
        let blocks = 16;
        for pixel in 0..film.pixel_count() {
            for block in 0..blocks {
                let sum = [(value(pixel as u64, block) * f64::from(BLOCK_SAMPLES)) as f32; 3];
                film.add_block(pixel, block, &SlotRecord { sum, first_bad: NONE, ..Default::default() });
            }
        }
        let found = from_film(&film).unwrap();
        let truth = (0..film.pixel_count()).map(|p| (film.mean(p)[0] - 1.0).powi(2)).sum::<f64>() / 4096.0 / 1.01;
        // Of 4096 pixels both scatter by sqrt(2 / 4096), 2 %, or less, as uniform deviations have lighter tails than normal ones.
        assert!((found.relmse.value / truth - 1.0).abs() < 0.1, "{found:?} {truth}");
        assert!(found.relmse.low < truth && truth < found.relmse.high);
        let by_blocks = (0..film.pixel_count()).map(|p| film.variance_of_mean(p)[0]).sum::<f64>() / 4096.0 / 1.01;
        assert!(by_blocks > 8.0 * truth, "the spread of the blocks says too much: {by_blocks} {truth}");
        let mut banded = Banded::new(film.pixel_count());
        banded.add(&film);
        assert_eq!(banded.estimate(), Some((found.relmse, false)));
    }

    /// Bands are other films: sums add, and the worst pixels are those of the whole image.
    #[test]
    fn bands_add_up_and_a_tail_in_one_of_them_is_seen() {
        let band = |outlier: f64| {
            let mut film = Film::new(64, 32, Aovs::NONE, 0);
            for pixel in 0..film.pixel_count() {
                for block in 0..8 {
                    let rare = if pixel == 700 && block == 3 { outlier } else { 0.0 };
                    let sum = [((value(pixel as u64, block) + rare) * f64::from(BLOCK_SAMPLES)) as f32; 3];
                    film.add_block(pixel, block, &SlotRecord { sum, first_bad: NONE, ..Default::default() });
                }
            }
            film
        };
        let estimate = |outliers: [f64; 3]| {
            let mut banded = Banded::new(3 * 64 * 32);
            outliers.iter().for_each(|&o| banded.add(&band(o)));
            banded.estimate().unwrap()
        };
        let one = from_film(&band(0.0)).unwrap();
        let (calm, is_heavy) = estimate([0.0; 3]);
        assert!((calm.value / one.relmse.value - 1.0).abs() < 1e-12 && !is_heavy);
        let (wild, is_heavy) = estimate([0.0, 0.0, 100.0]);
        assert!(wild.value > 2.0 * calm.value && is_heavy, "{wild:?} {calm:?}");
    }
}
