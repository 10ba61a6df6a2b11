//! Distributions and tests in f64: what the gates and the error bars are judged by.
//!
//! Normal, Student's t and chi-square from the incomplete gamma and beta functions of `special`; quantiles by bisection on
//! the tail that is small, so that they are as accurate as the tail itself. Welch (1947) t test, Sidak (1967) correction,
//! Pearson's chi-square with pooling of thin cells, Kolmogorov-Smirnov (Stephens 1970 for finite n).

use super::special::{beta_pq, erfc, gamma_pq};

/// P(Z > z) of the standard normal distribution.
pub fn normal_sf(z: f64) -> f64 {
    0.5 * erfc(z * std::f64::consts::FRAC_1_SQRT_2)
}

/// P(Z <= z).
pub fn normal_cdf(z: f64) -> f64 {
    normal_sf(-z)
}

/// z with P(Z <= z) = p.
pub fn normal_quantile(p: f64) -> f64 {
    symmetric_quantile(p, normal_sf)
}

/// P(T > t) for Student's t with `dof` > 0 degrees of freedom (may be infinite or fractional).
pub fn student_t_sf(t: f64, dof: f64) -> f64 {
    if dof.is_infinite() {
        return normal_sf(t);
    }
    if t.is_infinite() {
        return if t > 0.0 { 0.0 } else { 1.0 };
    }
    // I_x(dof/2, 1/2) with x = dof/(dof + t^2); the complement keeps the centre accurate.
    let half_tail = 0.5 * beta_pq(0.5, 0.5 * dof, t * t / (dof + t * t)).1;
    if t >= 0.0 { half_tail } else { 1.0 - half_tail }
}

/// P(T <= t).
pub fn student_t_cdf(t: f64, dof: f64) -> f64 {
    student_t_sf(-t, dof)
}

/// t with P(T <= t) = p.
pub fn student_t_quantile(p: f64, dof: f64) -> f64 {
    symmetric_quantile(p, |t| student_t_sf(t, dof))
}

/// P(X > x) for chi-square with `dof` > 0.
pub fn chi2_sf(x: f64, dof: f64) -> f64 {
    gamma_pq(0.5 * dof, 0.5 * x.max(0.0)).1
}

/// P(X <= x).
pub fn chi2_cdf(x: f64, dof: f64) -> f64 {
    gamma_pq(0.5 * dof, 0.5 * x.max(0.0)).0
}

/// x with P(X <= x) = p.
pub fn chi2_quantile(p: f64, dof: f64) -> f64 {
    if !(0.0..=1.0).contains(&p) || dof.is_nan() || dof <= 0.0 {
        return f64::NAN;
    }
    if p == 1.0 {
        return f64::INFINITY;
    }
    let mut high = dof.max(1.0);
    while chi2_cdf(high, dof) < p {
        high *= 2.0;
    }
    bisect(0.0, high, |x| if p < 0.5 { chi2_cdf(x, dof) < p } else { chi2_sf(x, dof) > 1.0 - p })
}

/// Two-sided level of each of `count` independent tests so that all hold with probability 1 - `level` (Sidak 1967).
pub fn sidak(level: f64, count: usize) -> f64 {
    -((-level).ln_1p() / count.max(1) as f64).exp_m1()
}

/// Interval of a share seen as `successes` of `count`, at `confidence` (Wilson 1927): it holds near 0 and 1 too.
pub fn wilson(successes: u64, count: u64, confidence: f64) -> [f64; 2] {
    if count == 0 {
        return [0.0, 1.0];
    }
    let (n, z) = (count as f64, normal_quantile(0.5 + 0.5 * confidence));
    let share = successes as f64 / n;
    let middle = (share + z * z / (2.0 * n)) / (1.0 + z * z / n);
    let half = z / (1.0 + z * z / n) * (share * (1.0 - share) / n + z * z / (4.0 * n * n)).sqrt();
    [(middle - half).max(0.0), (middle + half).min(1.0)]
}

/// Mean, unbiased variance and number of a sample.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moments {
    pub count: f64,
    pub mean: f64,
    /// Unbiased sample variance (divided by count - 1); 0 below two values.
    pub variance: f64,
}

impl Moments {
    /// Two passes: the mean first, so that the variance does not cancel.
    pub fn of(values: impl Iterator<Item = f64> + Clone) -> Self {
        let (count, sum) = values.clone().fold((0.0, 0.0), |(n, s), v| (n + 1.0, s + v));
        let mean = if count > 0.0 { sum / count } else { 0.0 };
        let squares: f64 = values.map(|v| (v - mean) * (v - mean)).sum();
        Self { count, mean, variance: if count > 1.0 { squares / (count - 1.0) } else { 0.0 } }
    }
    pub fn variance_of_mean(&self) -> f64 {
        if self.count > 0.0 { self.variance / self.count } else { 0.0 }
    }
    /// Half width of the two-sided interval of the mean at `confidence` (0.95), by Student's t.
    pub fn half_width(&self, confidence: f64) -> f64 {
        if self.count < 2.0 {
            return f64::INFINITY;
        }
        student_t_quantile(0.5 + 0.5 * confidence, self.count - 1.0) * self.variance_of_mean().sqrt()
    }
}

/// A test's outcome: the statistic, its degrees of freedom, and the p-value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TestResult {
    pub statistic: f64,
    pub dof: f64,
    pub p: f64,
}

/// Do two samples have the same mean? Two-sided, unequal variances (Welch 1947).
/// With no variance on either side the means must be equal: p is then 1 or 0.
pub fn welch_t(a: Moments, b: Moments) -> TestResult {
    let (va, vb) = (a.variance_of_mean(), b.variance_of_mean());
    let difference = a.mean - b.mean;
    if va + vb <= 0.0 {
        let p = if difference == 0.0 { 1.0 } else { 0.0 };
        return TestResult { statistic: if p == 1.0 { 0.0 } else { f64::INFINITY }, dof: f64::INFINITY, p };
    }
    // Scaled by the larger so that squares of tiny variances do not underflow.
    let scale = va.max(vb);
    let (wa, wb) = (va / scale, vb / scale);
    let dof = (wa + wb).powi(2) / (wa * wa / (a.count - 1.0).max(1.0) + wb * wb / (b.count - 1.0).max(1.0));
    let statistic = difference / (va + vb).sqrt();
    TestResult { statistic, dof, p: (2.0 * student_t_sf(statistic.abs(), dof)).min(1.0) }
}

/// Pearson's chi-square of counts against expected counts. Cells below `min_expected` (5 is usual) are pooled, smallest
/// first, until the pool is large enough; samples in cells that expect exactly 0 make p = 0.
pub fn chi_square_test(observed: &[f64], expected: &[f64], min_expected: f64) -> TestResult {
    assert_eq!(observed.len(), expected.len(), "one expectation for every cell");
    let impossible = observed.iter().zip(expected).any(|(&o, &e)| o > 0.0 && (e <= 0.0 || e.is_nan()));
    if impossible {
        return TestResult { statistic: f64::INFINITY, dof: 0.0, p: 0.0 };
    }
    let mut order: Vec<usize> = (0..expected.len()).filter(|&i| expected[i] > 0.0).collect();
    order.sort_by(|&i, &j| expected[i].total_cmp(&expected[j]));
    let (mut statistic, mut cells) = (0.0, 0usize);
    let (mut pool_observed, mut pool_expected) = (0.0, 0.0);
    let mut rest_expected: f64 = expected.iter().filter(|&&e| e > 0.0).sum();
    for (k, &i) in order.iter().enumerate() {
        pool_observed += observed[i];
        pool_expected += expected[i];
        rest_expected -= expected[i];
        // A rest too thin to stand alone stays in this pool.
        let is_last = k + 1 == order.len();
        if is_last || (pool_expected >= min_expected && rest_expected >= min_expected) {
            statistic += (pool_observed - pool_expected).powi(2) / pool_expected;
            cells += 1;
            (pool_observed, pool_expected) = (0.0, 0.0);
        }
    }
    let dof = cells.saturating_sub(1) as f64;
    TestResult { statistic, dof, p: if dof > 0.0 { chi2_sf(statistic, dof) } else { 1.0 } }
}

/// Kolmogorov-Smirnov: were `sorted` values drawn from `cdf`? The p-value uses Stephens's (1970) finite-n form.
pub fn ks_test(sorted: &[f64], cdf: impl Fn(f64) -> f64) -> TestResult {
    let n = sorted.len() as f64;
    let distance = sorted.iter().enumerate().fold(0.0f64, |d, (i, &x)| {
        let f = cdf(x);
        d.max(f - i as f64 / n).max((i as f64 + 1.0) / n - f)
    });
    TestResult { statistic: distance, dof: n, p: kolmogorov_sf((n.sqrt() + 0.12 + 0.11 / n.sqrt()) * distance) }
}

/// P(K > x) of Kolmogorov's distribution.
pub fn kolmogorov_sf(x: f64) -> f64 {
    if x < 0.3 {
        return 1.0; // 1 - 1e-5 at 0.3 and closer below; the alternating series does not converge there
    }
    let terms = (1..=100).map(|k| (-2.0 * (k * k) as f64 * x * x).exp() * if k % 2 == 1 { 2.0 } else { -2.0 });
    terms.sum::<f64>().clamp(0.0, 1.0)
}

/// Quantile of a distribution symmetric about 0 from its upper tail.
fn symmetric_quantile(p: f64, sf: impl Fn(f64) -> f64) -> f64 {
    if !(0.0..=1.0).contains(&p) {
        return f64::NAN;
    }
    if p == 0.5 {
        return 0.0;
    }
    let (tail, sign) = if p < 0.5 { (p, -1.0) } else { (1.0 - p, 1.0) };
    if tail == 0.0 {
        return sign * f64::INFINITY;
    }
    let mut high = 1.0;
    while sf(high) > tail && high < 1e300 {
        high *= 2.0;
    }
    sign * bisect(0.0, high, |x| sf(x) > tail)
}

/// The place where `is_left` turns false, to the last bit.
fn bisect(mut low: f64, mut high: f64, is_left: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..1100 {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            break;
        }
        if is_left(middle) { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

#[cfg(test)]
#[path = "stats_tests.rs"]
mod tests;
