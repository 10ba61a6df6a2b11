//! FLIP: how much of a difference a viewer sees who flips between two images; 0 (none) to 1, a pixel and on average.
//!
//! LDR-FLIP: Andersson, Nilsson, Akenine-Moller, Oskarsson, Astrom, Fairchild 2020, "FLIP: A Difference Evaluator for Alternating
//! Images". HDR-FLIP: Andersson, Nilsson, Shirley, Akenine-Moller 2021, "Visualizing Errors in Rendered High Dynamic Range Images":
//! the largest LDR-FLIP of the pair over exposures that show the reference's highlights up to its median, by the ACES fit of
//! Narkowicz 2015. Equations are numbered as in the 2020 paper. f64 throughout. tests/flip.py holds it against the authors' package.

use rayon::prelude::*;

/// Pixels a degree of visual angle: 0.7 m before a screen of 3840 pixels on 0.7 m.
pub const PIXELS_PER_DEGREE: f64 = 3840.0 * std::f64::consts::PI / 180.0;

/// Contrast sensitivity as sums of Gaussians (a, b), eq. 3 and table 1: achromatic, red-green, blue-yellow.
const SENSITIVITY: [&[(f64, f64)]; 3] = [&[(1.0, 0.0047)], &[(1.0, 0.0053)], &[(34.1, 0.04), (13.5, 0.025)]];
/// Width of the feature detectors, degrees (section 4.2.1).
const FEATURE_WIDTH_DEG: f64 = 0.082;
/// Exponents of the colour and the feature difference, and the knee of the colour map (sections 4.1.3, 4.2.2).
const COLOR_EXPONENT: f64 = 0.7;
const FEATURE_EXPONENT: f64 = 0.5;
const KNEE: (f64, f64) = (0.4, 0.95);
/// CIE D65, and linear Rec.709 to XYZ (IEC 61966-2-1, rounded nowhere: white is the sum of the columns).
const TO_XYZ: [[f64; 3]; 3] = [
    [10135552.0 / 24577794.0, 8788810.0 / 24577794.0, 4435075.0 / 24577794.0],
    [2613072.0 / 12288897.0, 8788810.0 / 12288897.0, 887015.0 / 12288897.0],
    [1425312.0 / 73733382.0, 8788810.0 / 73733382.0, 70074185.0 / 73733382.0],
];
/// Narkowicz 2015, ACES fit with the pre-exposure 0.6: (a x^2 + b x) / (c x^2 + d x + e).
const ACES: [f64; 5] = [0.6 * 0.6 * 2.51, 0.6 * 0.03, 0.6 * 0.6 * 2.43, 0.6 * 0.59, 0.14];
/// Tone-mapped value that the brightest (first exposure) and the median luminance (last) get (2021, section 4).
const SHOWN: f64 = 0.85;

/// One value a pixel, row-major.
type Plane = Vec<f64>;

/// LDR-FLIP of each pixel; both images linear RGB, row-major, cut to [0, 1] as a screen does.
pub fn ldr(image: &[[f32; 3]], reference: &[[f32; 3]], width: usize) -> Vec<f64> {
    let cut = |p: &[[f32; 3]]| p.iter().map(|c| c.map(|v| f64::from(v).clamp(0.0, 1.0))).collect::<Vec<_>>();
    flip(&cut(image), &cut(reference), width)
}

/// HDR-FLIP of each pixel; both images linear RGB, negative values count as 0. All finite.
pub fn hdr(image: &[[f32; 3]], reference: &[[f32; 3]], width: usize) -> Vec<f64> {
    let (first, last) = exposures(reference);
    let count = ((last - first).ceil() as usize).max(2);
    let mut worst = vec![0.0f64; image.len()];
    for i in 0..count {
        let scale = (first + (last - first) * i as f64 / (count - 1) as f64).exp2();
        let shown =
            |p: &[[f32; 3]]| p.iter().map(|c| c.map(|v| aces(f64::from(v).max(0.0) * scale))).collect::<Vec<_>>();
        let errors = flip(&shown(image), &shown(reference), width);
        worst.iter_mut().zip(errors).for_each(|(w, e)| *w = w.max(e));
    }
    worst
}

/// Mean over the pixels.
pub fn mean(errors: &[f64]) -> f64 {
    errors.iter().sum::<f64>() / errors.len().max(1) as f64
}

fn aces(x: f64) -> f64 {
    let [a, b, c, d, e] = ACES;
    ((a * x * x + b * x) / (c * x * x + d * x + e)).clamp(0.0, 1.0)
}

/// First and last exposure in stops: the largest, and the median luminance of the reference shown as `SHOWN`.
fn exposures(reference: &[[f32; 3]]) -> (f64, f64) {
    let [a, b, c, d, e] = ACES;
    let (qa, qb, qc) = (a - SHOWN * c, b - SHOWN * d, -SHOWN * e);
    let white = (-qb + (qb * qb - 4.0 * qa * qc).sqrt()) / (2.0 * qa);
    let mut luminance: Vec<f64> = reference.iter().map(|c| dot(TO_XYZ[1], c.map(|v| f64::from(v).max(0.0)))).collect();
    luminance.sort_by(f64::total_cmp);
    let n = luminance.len();
    // Of an even number the upper one, as the authors' program has it.
    let median = luminance[n / 2];
    // A black image, or one that is half black, has no such exposure: 1e-10 stands for the darkest.
    let stops = |y: f64| (white / y.max(1e-10)).log2();
    (stops(luminance[n - 1]), stops(median))
}

fn flip(image: &[[f64; 3]], reference: &[[f64; 3]], width: usize) -> Vec<f64> {
    let seen = |pixels: &[[f64; 3]]| {
        let opponent: Vec<[f64; 3]> = pixels.par_iter().map(|&c| to_opponent(c)).collect();
        (perceived(&opponent, width), features(&opponent, width))
    };
    let ((color_a, feature_a), (color_b, feature_b)) = (seen(image), seen(reference));
    let largest = hyab(hunt([0.0, 1.0, 0.0]), hunt([0.0, 0.0, 1.0])).powf(COLOR_EXPONENT);
    (0..image.len())
        .into_par_iter()
        .map(|i| {
            let color = stretched(hyab(color_a[i], color_b[i]).powf(COLOR_EXPONENT), largest);
            let apart = (0..2).map(|k| (feature_a[i][k] - feature_b[i][k]).abs()).fold(0.0, f64::max);
            let feature = (apart * std::f64::consts::FRAC_1_SQRT_2).powf(FEATURE_EXPONENT);
            color.powf(1.0 - feature)
        })
        .collect()
}

/// Eq. 8 to 10: large colour differences share the last twentieth of the range.
fn stretched(difference: f64, largest: f64) -> f64 {
    let knee = KNEE.0 * largest;
    if difference < knee {
        KNEE.1 / knee * difference
    } else {
        KNEE.1 + (difference - knee) / (largest - knee) * (1.0 - KNEE.1)
    }
}

/// Filtered by the eye's contrast sensitivity, then in the Hunt-adjusted L*a*b*.
fn perceived(opponent: &[[f64; 3]], width: usize) -> Vec<[f64; 3]> {
    let widest = SENSITIVITY.iter().flat_map(|s| s.iter()).fold(0.0f64, |w, s| w.max(s.1));
    let sigma_deg = (widest / (2.0 * std::f64::consts::PI.powi(2))).sqrt();
    let radius = (3.0 * sigma_deg * PIXELS_PER_DEGREE).ceil() as i64;
    let mut filtered = vec![[0.0; 3]; opponent.len()];
    for (channel, gaussians) in SENSITIVITY.iter().enumerate() {
        let plane: Plane = opponent.iter().map(|c| c[channel]).collect();
        let kernels: Vec<(f64, Vec<f64>)> = gaussians.iter().map(|&(a, b)| sensitivity_kernel(a, b, radius)).collect();
        let total: f64 = kernels.iter().map(|k| k.0).sum();
        for (weight, kernel) in kernels {
            let smooth = convolve(&plane, width, &kernel, &kernel);
            filtered.iter_mut().zip(smooth).for_each(|(f, s)| f[channel] += s * weight / total);
        }
    }
    filtered.par_iter().map(|&c| hunt(from_opponent(c).map(|v| v.clamp(0.0, 1.0)))).collect()
}

/// A Gaussian of eq. 3 along one axis, of sum 1, and the weight of its two-dimensional product.
fn sensitivity_kernel(a: f64, b: f64, radius: i64) -> (f64, Vec<f64>) {
    let pi = std::f64::consts::PI;
    let value = |i: i64| (-(pi * i as f64 / PIXELS_PER_DEGREE).powi(2) / b).exp();
    let kernel: Vec<f64> = (-radius..=radius).map(value).collect();
    let sum: f64 = kernel.iter().sum();
    (a * (pi / b).sqrt() * sum * sum, kernel.iter().map(|k| k / sum).collect())
}

/// Strength of edges and of points at each pixel: derivatives of a Gaussian on the achromatic channel, eq. 11 to 13.
fn features(opponent: &[[f64; 3]], width: usize) -> Vec<[f64; 2]> {
    let plane: Plane = opponent.iter().map(|c| (c[0] + 16.0) / 116.0).collect();
    let sigma = 0.5 * FEATURE_WIDTH_DEG * PIXELS_PER_DEGREE;
    let radius = (3.0 * sigma).ceil() as i64;
    let at = |f: &dyn Fn(f64) -> f64| (-radius..=radius).map(|i| f(i as f64)).collect::<Vec<f64>>();
    let bell = |x: f64| (-x * x / (2.0 * sigma * sigma)).exp();
    let gaussian = at(&bell);
    let across: f64 = gaussian.iter().sum();
    let smooth: Vec<f64> = gaussian.iter().map(|g| g / across).collect();
    // Positive and negative weights each sum to 1.
    let balanced = |kernel: Vec<f64>| -> Vec<f64> {
        let (up, down) = kernel.iter().fold((0.0, 0.0), |(u, d), &k| if k > 0.0 { (u + k, d) } else { (u, d - k) });
        kernel.iter().map(|&k| if k > 0.0 { k / up } else { k / down }).collect()
    };
    let edge = balanced(at(&|x| -x * bell(x)));
    let point = balanced(at(&|x| (x * x / (sigma * sigma) - 1.0) * bell(x)));
    let strength = |kernel: &[f64]| -> Plane {
        let (x, y) = (convolve(&plane, width, kernel, &smooth), convolve(&plane, width, &smooth, kernel));
        x.iter().zip(&y).map(|(x, y)| x.hypot(*y)).collect()
    };
    let (edges, points) = (strength(&edge), strength(&point));
    edges.into_iter().zip(points).map(|(e, p)| [e, p]).collect()
}

/// Correlates with `along_x` times `along_y`; the border pixel goes on outside.
fn convolve(plane: &[f64], width: usize, along_x: &[f64], along_y: &[f64]) -> Plane {
    let height = plane.len() / width;
    let (rx, ry) = (along_x.len() / 2, along_y.len() / 2);
    let mut rows = vec![0.0; plane.len()];
    rows.par_chunks_mut(width).zip(plane.par_chunks(width)).for_each(|(out, row)| {
        for (x, o) in out.iter_mut().enumerate() {
            *o = (along_x.iter().enumerate()).map(|(k, w)| w * row[(x + k).saturating_sub(rx).min(width - 1)]).sum();
        }
    });
    let mut result = vec![0.0; plane.len()];
    result.par_chunks_mut(width).enumerate().for_each(|(y, out)| {
        for (k, w) in along_y.iter().enumerate() {
            let from = (y + k).saturating_sub(ry).min(height - 1) * width;
            out.iter_mut().zip(&rows[from..from + width]).for_each(|(o, r)| *o += w * r);
        }
    });
    result
}

fn dot(row: [f64; 3], v: [f64; 3]) -> f64 {
    row[0] * v[0] + row[1] * v[1] + row[2] * v[2]
}

fn white() -> [f64; 3] {
    TO_XYZ.map(|row| row.iter().sum())
}

/// Linear RGB to YCxCz (eq. 1): L*a*b* without its cube root.
fn to_opponent(rgb: [f64; 3]) -> [f64; 3] {
    let w = white();
    let xyz: [f64; 3] = std::array::from_fn(|i| dot(TO_XYZ[i], rgb) / w[i]);
    [116.0 * xyz[1] - 16.0, 500.0 * (xyz[0] - xyz[1]), 200.0 * (xyz[1] - xyz[2])]
}

fn from_opponent(c: [f64; 3]) -> [f64; 3] {
    let w = white();
    let y = (c[0] + 16.0) / 116.0;
    let xyz = [(y + c[1] / 500.0) * w[0], y * w[1], (y - c[2] / 200.0) * w[2]];
    let inverse = glam::DMat3::from_cols_array_2d(&TO_XYZ).transpose().inverse();
    (inverse * glam::DVec3::from(xyz)).to_array()
}

/// Linear RGB to L*a*b*, with a and b scaled by L* (Hunt 1952): chroma shows less in the dark.
fn hunt(rgb: [f64; 3]) -> [f64; 3] {
    let delta: f64 = 6.0 / 29.0;
    let root = |t: f64| if t > delta.powi(3) { t.cbrt() } else { t / (3.0 * delta * delta) + 4.0 / 29.0 };
    let w = white();
    let f: [f64; 3] = std::array::from_fn(|i| root(dot(TO_XYZ[i], rgb) / w[i]));
    let lightness = 116.0 * f[1] - 16.0;
    [lightness, 0.01 * lightness * 500.0 * (f[0] - f[1]), 0.01 * lightness * 200.0 * (f[1] - f[2])]
}

/// Abasi, Amani Tehran, Fairchild 2020: city block in lightness, Euclid in chroma.
fn hyab(a: [f64; 3], b: [f64; 3]) -> f64 {
    (a[0] - b[0]).abs() + (a[1] - b[1]).hypot(a[2] - b[2])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn checker(width: usize, height: usize, a: f32, b: f32) -> Vec<[f32; 3]> {
        (0..width * height)
            .map(|i| if ((i % width + i / width) / 8).is_multiple_of(2) { [a; 3] } else { [b, a, b] })
            .collect()
    }

    #[test]
    fn an_image_does_not_differ_from_itself() {
        let image = checker(40, 30, 0.2, 0.9);
        assert_eq!(mean(&ldr(&image, &image, 40)), 0.0);
        assert_eq!(mean(&hdr(&image, &image, 40)), 0.0);
    }

    #[test]
    fn green_against_blue_is_the_largest_colour_difference() {
        let of = |c: [f32; 3]| vec![c; 400];
        let errors = ldr(&of([0.0, 1.0, 0.0]), &of([0.0, 0.0, 1.0]), 20);
        assert!(errors.iter().all(|e| (e - 1.0).abs() < 1e-12), "{}", errors[0]);
        assert!(mean(&ldr(&of([0.0; 3]), &of([1.0; 3]), 20)) < 1.0);
    }

    #[test]
    fn hdr_flip_does_not_depend_on_exposure() {
        let reference = checker(40, 30, 0.3, 4.0);
        let mut image = reference.clone();
        image[40 * 15 + 20] = [9.0, 1.0, 0.5];
        let scaled = |v: &[[f32; 3]]| v.iter().map(|c| c.map(|x| x * 256.0)).collect::<Vec<_>>();
        let (a, b) = (mean(&hdr(&image, &reference, 40)), mean(&hdr(&scaled(&image), &scaled(&reference), 40)));
        assert!(a > 0.0 && (a / b - 1.0).abs() < 1e-9, "{a} {b}");
    }

    #[test]
    fn black_and_tiny_images_are_survived() {
        assert_eq!(mean(&hdr(&[[0.0; 3]], &[[0.0; 3]], 1)), 0.0);
        assert!(mean(&hdr(&[[1.0; 3]; 6], &[[0.0; 3]; 6], 2)).is_finite());
    }
}
