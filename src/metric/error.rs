//! Error of an image x against a reference r, pixel by pixel. Defined here once.
//!
//! relMSE = mean over pixels and channels of (x-r)^2 / (r^2 + 0.01). With it go: the same with epsilon (0.1 mean r)^2, which
//! does not change when both images are scaled; the first without its worst 0.1 % of pixels (Figueiredo 2025 and others);
//! RMSE; the mean bias; and FLIP (`flip`). Pixels that are not finite in either image are counted and left out.

use serde::{Deserialize, Serialize};

use super::flip;

/// The epsilon of relMSE, (W/(m^2 sr))^2: that of most papers since Rousselle et al. 2011.
pub const EPSILON: f64 = 0.01;
/// The exposure-independent epsilon is (this times the reference's mean)^2.
pub const EPSILON_OF_MEAN: f64 = 0.1;
/// Share of pixels that the trimmed measure leaves out.
pub const TRIMMED_SHARE: f64 = 0.001;

/// All measures of one comparison.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Errors {
    pub relmse: f64,
    /// With epsilon (0.1 mean r)^2.
    pub relmse_exposure: f64,
    /// Without the worst 0.1 % of pixels.
    pub relmse_trimmed: f64,
    pub rmse: f64,
    /// Mean of x - r.
    pub bias: f64,
    /// Mean of r.
    pub reference_mean: f64,
    /// Mean LDR-FLIP of the two as a screen shows them, cut to [0, 1].
    pub flip: f64,
    /// Mean HDR-FLIP: the worst over exposures, pixel by pixel.
    pub flip_hdr: f64,
    /// Pixels left out because one of the images is NaN or infinite there.
    pub nonfinite: u64,
}

/// Squared error of one pixel over its scale, averaged over its channels: one term of relMSE.
pub fn relative_square(x: [f32; 3], r: [f32; 3], epsilon: f64) -> f64 {
    let term = |c: usize| {
        let (x, r) = (x[c] as f64, r[c] as f64);
        (x - r) * (x - r) / (r * r + epsilon)
    };
    (term(0) + term(1) + term(2)) / 3.0
}

/// Measures of `image` against `reference`, which have the same size: row-major, rows of `width` pixels.
pub fn compare(image: &[[f32; 3]], reference: &[[f32; 3]], width: usize) -> Errors {
    let (flip_ldr, flip_hdr) = flips(image, reference, width);
    Errors { flip: flip_ldr, flip_hdr, ..compare_values(image, reference) }
}

/// Mean LDR-FLIP and HDR-FLIP. A pixel that is not finite in either image is black in both.
fn flips(image: &[[f32; 3]], reference: &[[f32; 3]], width: usize) -> (f64, f64) {
    if image.is_empty() {
        return (0.0, 0.0);
    }
    let finite = |p: &[f32; 3]| p.iter().all(|v| v.is_finite());
    let (a, b): (Vec<[f32; 3]>, Vec<[f32; 3]>) = image
        .iter()
        .zip(reference)
        .map(|(x, r)| if finite(x) && finite(r) { (*x, *r) } else { ([0.0; 3], [0.0; 3]) })
        .unzip();
    (flip::mean(&flip::ldr(&a, &b, width)), flip::mean(&flip::hdr(&a, &b, width)))
}

/// `compare` without FLIP, which costs more than all the others together.
pub fn compare_values(image: &[[f32; 3]], reference: &[[f32; 3]]) -> Errors {
    assert_eq!(image.len(), reference.len(), "images of one size are compared");
    let finite = |p: &[f32; 3]| p.iter().all(|v| v.is_finite());
    let pairs: Vec<([f32; 3], [f32; 3])> =
        image.iter().zip(reference).filter(|(x, r)| finite(x) && finite(r)).map(|(x, r)| (*x, *r)).collect();
    let nonfinite = (image.len() - pairs.len()) as u64;
    if pairs.is_empty() {
        return Errors { nonfinite, ..Default::default() };
    }
    let count = pairs.len() as f64;
    let channels = |f: &dyn Fn(f64, f64) -> f64| {
        pairs.iter().flat_map(|(x, r)| (0..3).map(|c| f(x[c] as f64, r[c] as f64))).sum::<f64>() / (3.0 * count)
    };
    let reference_mean = channels(&|_, r| r);
    // A black reference has no exposure: the fixed epsilon stands in.
    let of_mean = (EPSILON_OF_MEAN * reference_mean).powi(2);
    let epsilon_exposure = if of_mean > 0.0 { of_mean } else { EPSILON };
    let mut terms: Vec<f64> = pairs.iter().map(|(x, r)| relative_square(*x, *r, EPSILON)).collect();
    let relmse = terms.iter().sum::<f64>() / count;
    terms.sort_by(f64::total_cmp);
    terms.truncate(terms.len() - trimmed_count(terms.len()));
    Errors {
        relmse,
        relmse_exposure: pairs.iter().map(|(x, r)| relative_square(*x, *r, epsilon_exposure)).sum::<f64>() / count,
        relmse_trimmed: terms.iter().sum::<f64>() / terms.len().max(1) as f64,
        rmse: channels(&|x, r| (x - r) * (x - r)).sqrt(),
        bias: channels(&|x, r| x - r),
        reference_mean,
        nonfinite,
        ..Default::default()
    }
}

/// Pixels that the trimmed measure leaves out of `count`: at least one of two.
pub fn trimmed_count(count: usize) -> usize {
    ((count as f64 * TRIMMED_SHARE).ceil() as usize).min(count.saturating_sub(1))
}

/// Four decades of relMSE from 1e-4 to 1 on [0, 1].
pub fn decades(relative_square: f64) -> f64 {
    if relative_square.is_finite() {
        ((relative_square.max(1e-30).log10() + 4.0) / 4.0).clamp(0.0, 1.0)
    } else {
        f64::NAN
    }
}

/// Colour of an error in [0, 1] as sRGB bytes: black, blue, magenta, orange, pale yellow; green where there is no number.
pub fn map_color(error: f64) -> [u8; 3] {
    const STOPS: [[f64; 3]; 5] =
        [[0.0, 0.0, 0.0], [40.0, 20.0, 120.0], [170.0, 40.0, 110.0], [245.0, 140.0, 30.0], [252.0, 250.0, 200.0]];
    if !error.is_finite() {
        return [0, 255, 0];
    }
    let place = 4.0 * error.clamp(0.0, 1.0);
    let first = (place as usize).min(3);
    let share = place - first as f64;
    std::array::from_fn(|c| (STOPS[first][c] * (1.0 - share) + STOPS[first + 1][c] * share).round() as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_values() {
        let reference = [[1.0, 2.0, 0.0], [1.0, 1.0, 1.0]];
        let image = [[1.5, 2.0, 0.1], [1.0, 1.0, 1.0]];
        let e = compare_values(&image, &reference);
        let dark = 0.1f32 as f64;
        let expected = (0.25 / 1.01 + dark * dark / 0.01) / 6.0;
        assert!((e.relmse - expected).abs() < 1e-15, "{e:?}");
        assert_eq!(e.relmse_trimmed, 0.0, "the worst pixel of two is left out");
        assert!((e.rmse - ((0.25 + dark * dark) / 6.0).sqrt()).abs() < 1e-15);
        assert!((e.bias - (0.5 + dark) / 6.0).abs() < 1e-15);
        assert_eq!((e.reference_mean, e.nonfinite), (1.0, 0));
        assert!((e.relmse_exposure - expected).abs() < 1e-15, "a mean of 1 gives the same epsilon");
    }

    #[test]
    fn exposure_does_not_change_the_second_measure() {
        let reference: Vec<[f32; 3]> = (0..50).map(|i| [i as f32, 0.25 * i as f32, 1.0]).collect();
        let image: Vec<[f32; 3]> = reference.iter().map(|p| p.map(|v| v * 1.125)).collect();
        let scaled = |v: &[[f32; 3]]| v.iter().map(|p| p.map(|v| v * 1024.0)).collect::<Vec<_>>();
        let (a, b) = (compare_values(&image, &reference), compare_values(&scaled(&image), &scaled(&reference)));
        assert!((a.relmse_exposure / b.relmse_exposure - 1.0).abs() < 1e-14);
        assert!((a.relmse / b.relmse - 1.0).abs() > 1e-4);
    }

    #[test]
    fn colours_run_from_black_to_pale() {
        let color = |e| map_color(decades(e));
        assert_eq!(
            [color(0.0), color(1e-4), color(1.0), color(9e9)],
            [[0; 3], [0; 3], [252, 250, 200], [252, 250, 200]]
        );
        assert_eq!((color(f64::NAN), color(1e-2)), ([0, 255, 0], [170, 40, 110]));
    }

    #[test]
    fn pixels_that_are_not_finite_are_counted() {
        let e = compare_values(&[[f32::NAN, 0.0, 0.0], [1.0; 3]], &[[0.0; 3], [1.0; 3]]);
        assert_eq!((e.relmse, e.nonfinite), (0.0, 1));
        assert_eq!(compare_values(&[[f32::INFINITY; 3]], &[[0.0; 3]]).nonfinite, 1);
        assert_eq!(compare_values(&[], &[]), Errors::default());
    }
}
