//! The sampling table of a lat-long sky: one cell a texel, weight = the exact integral of the bilinear luminance over the cell.
//!
//! Over a cell the bilinear lookup blends the texel with its eight neighbours. In u the hat functions integrate to 1/8, 6/8, 1/8;
//! in v they carry sin(theta), integrated in closed form (`RowWeights`). So a cell's weight is 0 only where the lookup is 0
//! in all of it: the density covers the function (pbrt-v3 issues 62 and 63 are the half-texel and pole faults of tables that do not).
//! MIS compensation (Karlik et al. 2019, "MIS compensation: optimizing sampling techniques in multiple importance sampling",
//! section 5): the mean luminance is taken off, so that light sampling goes where BSDF sampling cannot find the light.

use std::f64::consts::PI;

use super::alias::AliasTable;

/// Y of linear Rec.709.
pub fn luminance(rgb: [f64; 3]) -> f64 {
    0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2]
}

/// What a cell table needs of the image and says of it.
#[derive(Clone, Debug)]
pub struct CellTable {
    pub alias: AliasTable,
    /// Density of each cell, 1/sr, row-major.
    pub cell_pdf: Vec<f64>,
    /// Integral of the luminance over the sphere, W/m2 before the sky's scale.
    pub luminance_integral: f64,
    /// The table is the compensated one.
    pub is_compensated: bool,
}

/// Integrals over row `row` of `height` of sin(theta) times the hat functions of the rows above, at and below, in theta.
#[derive(Clone, Copy, Debug, PartialEq)]
struct RowWeights([f64; 3]);

impl RowWeights {
    fn new(row: usize, height: usize) -> Self {
        // Half a row; the cell's middle is its own centre, its ends lie half way to the neighbours.
        let h = 0.5 * PI / height as f64;
        let upper = falling(2 * row, 2 * height, h);
        let upper_rising = rising(2 * row, 2 * height, h);
        let lower = falling(2 * row + 1, 2 * height, h);
        let lower_rising = rising(2 * row + 1, 2 * height, h);
        // Upper half: the neighbour falls from 1/2 to 0 while the row rises from 1/2 to 1.
        let above = 0.5 * upper;
        let below = 0.5 * lower_rising;
        let own = 0.5 * upper + upper_rising + lower + 0.5 * lower_rising;
        Self([above, own, below])
    }
}

/// Integral over the half row that starts at `step` half rows from the pole of (1 - t) sin(theta) d theta, t from 0 to 1.
/// = h (sin(theta0) (1 - cos h)/h^2 + cos(theta0) (h - sin h)/h^2), from the addition theorem.
fn falling(step: usize, steps: usize, h: f64) -> f64 {
    let (sin0, cos0) = sin_cos_of_half_turn(step, steps);
    let half = (0.5 * h).sin() / (0.5 * h);
    let h2 = h * h;
    // (h - sin h)/h^2 cancels for small h; the series is good to 1e-17 below 0.5.
    let odd = if h < 0.5 {
        h * (1.0 / 6.0
            - h2 * (1.0 / 120.0
                - h2 * (1.0 / 5040.0 - h2 * (1.0 / 362880.0 - h2 * (1.0 / 39916800.0 - h2 / 6227020800.0)))))
    } else {
        (h - h.sin()) / h2
    };
    h * (sin0 * 0.5 * half * half + cos0 * odd)
}

/// The same with t in place of 1 - t: the mirror image from the other pole.
fn rising(step: usize, steps: usize, h: f64) -> f64 {
    falling(steps - step - 1, steps, h)
}

/// sin and cos of pi step/steps; from the nearer pole, for sin near pi would lose its digits.
fn sin_cos_of_half_turn(step: usize, steps: usize) -> (f64, f64) {
    let is_lower = 2 * step > steps;
    let (sin, cos) = (PI * (if is_lower { steps - step } else { step }) as f64 / steps as f64).sin_cos();
    (sin, if is_lower { -cos } else { cos })
}

/// Solid angle of a cell of row `row`, sr: (2 pi/W) (cos(theta0) - cos(theta1)).
pub fn cell_solid_angle(row: usize, width: usize, height: usize) -> f64 {
    let (sin_middle, _) = sin_cos_of_half_turn(2 * row + 1, 2 * height);
    4.0 * PI / width as f64 * sin_middle * (0.5 * PI / height as f64).sin()
}

/// Table over the cells of a `width` x `height` image with luminance `luminance(column, row)`, which must be finite and >= 0.
/// None when the image is black or has no texel.
pub fn build(
    width: usize,
    height: usize,
    luminance: impl Fn(usize, usize) -> f64,
    compensate: bool,
) -> Option<CellTable> {
    let mut weights = vec![0.0; width * height];
    for row in 0..height {
        let RowWeights(in_v) = RowWeights::new(row, height);
        let rows = [row.saturating_sub(1), row, (row + 1).min(height - 1)];
        // Blended over rows first, then over columns.
        let column = |i: usize| (0..3).map(|k| in_v[k] * luminance(i, rows[k])).sum::<f64>();
        let line: Vec<f64> = (0..width).map(column).collect();
        let du = 2.0 * PI / width as f64;
        for i in 0..width {
            let (left, right) = (line[(i + width - 1) % width], line[(i + 1) % width]);
            weights[row * width + i] = du * (0.125 * left + 0.75 * line[i] + 0.125 * right);
        }
    }
    // Row sums first: keeps the rounding of 2^25 terms below 1e-12.
    let luminance_integral: f64 = weights.chunks(width.max(1)).map(|line| line.iter().sum::<f64>()).sum();
    let solid_angle = |cell: usize| cell_solid_angle(cell / width, width, height);
    let mut is_compensated = false;
    if compensate && luminance_integral > 0.0 {
        let mean = luminance_integral / (4.0 * PI);
        let rest = |cell: usize, w: f64| (w - mean * solid_angle(cell)).max(0.0);
        let left: f64 = weights.iter().enumerate().map(|(cell, &w)| rest(cell, w)).sum();
        // A uniform map leaves rounding only.
        is_compensated = left > 1e-6 * luminance_integral;
        if is_compensated {
            weights.iter_mut().enumerate().for_each(|(cell, w)| *w = rest(cell, *w));
        }
    }
    let alias = AliasTable::new(&weights)?;
    drop(weights);
    let cell_pdf = alias.pmf.iter().enumerate().map(|(cell, p)| p / solid_angle(cell)).collect();
    Some(CellTable { alias, cell_pdf, luminance_integral, is_compensated })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn row_weights_are_the_integrals() {
        for (row, height) in
            [(0, 1), (0, 2), (1, 2), (0, 7), (3, 7), (6, 7), (0, 4096), (1, 4096), (2000, 4096), (4095, 4096)]
        {
            let RowWeights(w) = RowWeights::new(row, height);
            let n = 20_000;
            let mut sum = [0.0; 3];
            for k in 0..n {
                let t = (k as f64 + 0.5) / n as f64;
                let sin = (PI * (row as f64 + t) / height as f64).sin() * PI / height as f64 / n as f64;
                sum[0] += (0.5 - t).max(0.0) * sin;
                sum[1] += (1.0 - (t - 0.5).abs()) * sin;
                sum[2] += (t - 0.5).max(0.0) * sin;
            }
            for k in 0..3 {
                assert!((w[k] / sum[k] - 1.0).abs() < 2e-8, "row {row} of {height}, {k}: {} {}", w[k], sum[k]);
            }
            let exact = cell_solid_angle(row, 1, height) / (2.0 * PI);
            assert!((w.iter().sum::<f64>() / exact - 1.0).abs() < 1e-13, "row {row} of {height}");
        }
    }

    #[test]
    fn a_constant_image_integrates_to_four_pi() {
        for (w, h) in [(1, 1), (2, 1), (3, 5), (64, 32), (1024, 512)] {
            let t = build(w, h, |_, _| 1.0, false).unwrap();
            assert!((t.luminance_integral / (4.0 * PI) - 1.0).abs() < 1e-13, "{w} {h}");
            let quantised = 1e-6;
            assert!(t.cell_pdf.iter().all(|p| (p * 4.0 * PI - 1.0).abs() < quantised), "{w} {h}");
            // Nothing is left to compensate: the plain table stays.
            let c = build(w, h, |_, _| 1.0, true).unwrap();
            assert!(!c.is_compensated && c.cell_pdf == t.cell_pdf);
        }
        assert!(build(8, 4, |_, _| 0.0, true).is_none());
        assert!(build(0, 0, |_, _| 1.0, false).is_none());
    }

    #[test]
    fn one_hot_texel_in_8k_reaches_its_neighbours_only() {
        let (w, h) = (8192, 64);
        for row in [0, 1, 33, 63] {
            let t = build(w, h, |i, j| if (i, j) == (0, row) { 1e6 } else { 0.0 }, false).unwrap();
            let reached = t.cell_pdf.iter().filter(|&&p| p > 0.0).count();
            assert_eq!(reached, if row == 0 || row == 63 { 6 } else { 9 });
            assert!(t.cell_pdf[row * w] > t.cell_pdf[row * w + 1] && t.cell_pdf[row * w + w - 1] > 0.0);
        }
        // A sun of 1e5 : 1 holds its share.
        let t = build(w, h, |i, j| if (i, j) == (4000, 30) { 1e5 } else { 1.0 }, true).unwrap();
        assert!(t.is_compensated && (t.alias.pmf.iter().sum::<f64>() - 1.0).abs() < 1e-12);
    }
}
