//! Known values from printed tables, and the level of the tests on data that satisfy them.

use super::*;

#[track_caller]
fn close(got: f64, want: f64, relative: f64) {
    assert!((got - want).abs() <= relative * want.abs(), "got {got:e}, want {want:e}");
}

/// A small congruential generator: the tests of the tests must not rest on the renderer's own sampler.
struct Lcg(u64);

impl Lcg {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        ((self.0 >> 11) as f64 + 0.5) / (1u64 << 53) as f64
    }
}

#[test]
fn normal_at_known_values() {
    close(normal_quantile(0.975), 1.959_963_984_540_054, 1e-13);
    close(normal_quantile(1e-12), -7.034_483_825_301_131, 1e-12);
    close(normal_sf(6.0), 9.865_876_450_376_946e-10, 1e-12);
    close(normal_cdf(1.0), 0.841_344_746_068_542_9, 1e-14);
    assert_eq!(normal_quantile(0.5), 0.0);
    assert!(normal_quantile(1.0).is_infinite() && normal_quantile(2.0).is_nan());
}

#[test]
fn student_t_at_known_values() {
    close(student_t_quantile(0.975, 1.0), (0.475 * std::f64::consts::PI).tan(), 1e-11);
    close(student_t_quantile(0.975, 15.0), 2.131_449_545_559_323, 1e-11);
    close(student_t_quantile(0.995, 30.0), 2.749_995_653_567_229, 1e-10);
    // One degree of freedom is Cauchy: P(T > t) = 1/2 - atan(t)/pi.
    close(student_t_sf(3.0, 1.0), 0.5 - 3f64.atan() / std::f64::consts::PI, 1e-13);
    close(student_t_cdf(-1.0, 1.0), 0.25, 1e-13);
    close(student_t_sf(2.0, 1e9), normal_sf(2.0), 1e-6);
    close(student_t_sf(1e-9, 7.0), 0.5, 1e-8);
}

#[test]
fn chi_square_at_known_values() {
    close(chi2_quantile(0.95, 1.0), 3.841_458_820_694_124, 1e-12);
    close(chi2_quantile(0.99, 10.0), 23.209_251_158_954_356, 1e-12);
    close(chi2_quantile(0.05, 100.0), 77.929_465_165, 1e-9);
    close(chi2_sf(20.0, 2.0), (-10f64).exp(), 1e-12);
}

#[test]
fn sidak_at_known_values() {
    close(sidak(0.05, 10), 0.005_116_196_891_823_7, 1e-12);
    close(sidak(0.01, 1), 0.01, 1e-14);
    close(sidak(0.01, 1_000_000), 1.005_033_6e-8, 1e-6);
}

#[test]
fn welch_at_a_worked_example() {
    // Textbook pair with unequal variances; t and dof by hand from the formulas.
    let a = Moments { count: 25.0, mean: 20.0, variance: 4.0 };
    let b = Moments { count: 16.0, mean: 18.5, variance: 9.0 };
    let result = welch_t(a, b);
    close(result.statistic, 1.5 / (4.0f64 / 25.0 + 9.0 / 16.0).sqrt(), 1e-14);
    close(result.dof, 0.7225f64.powi(2) / (0.16f64.powi(2) / 24.0 + 0.5625f64.powi(2) / 15.0), 1e-12);
    assert!(result.p > 0.08 && result.p < 0.1, "{result:?}");
    let constant = Moments { count: 4.0, mean: 1.0, variance: 0.0 };
    assert_eq!(welch_t(constant, constant).p, 1.0);
    assert_eq!(welch_t(constant, Moments { mean: 2.0, ..constant }).p, 0.0);
}

#[test]
fn tests_hold_their_level() {
    // 400 repetitions at 5 %: the number of rejections is binomial with standard deviation 4.4; five of them each way.
    let mut rng = Lcg(7);
    let mut rejected = [0; 3];
    for _ in 0..400 {
        let draw = |rng: &mut Lcg| Moments::of((0..20).map(|_| rng.next()).collect::<Vec<_>>().into_iter());
        rejected[0] += (welch_t(draw(&mut rng), draw(&mut rng)).p < 0.05) as i32;
        let mut cells = [0.0; 16];
        for _ in 0..600 {
            cells[(rng.next() * 16.0) as usize] += 1.0;
        }
        rejected[1] += (chi_square_test(&cells, &[37.5; 16], 5.0).p < 0.05) as i32;
        let mut values: Vec<f64> = (0..50).map(|_| rng.next()).collect();
        values.sort_by(f64::total_cmp);
        rejected[2] += (ks_test(&values, |x| x).p < 0.05) as i32;
    }
    for (name, count) in ["welch", "chi-square", "ks"].iter().zip(rejected) {
        assert!((4..=42).contains(&count), "{name}: {count} rejections of 400 at the 5 % level");
    }
}

#[test]
fn chi_square_pools_thin_cells_and_sees_the_impossible() {
    let expected = [100.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.0];
    let fair = chi_square_test(&[100.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.0], &expected, 5.0);
    assert_eq!((fair.statistic, fair.dof), (0.0, 1.0));
    let impossible = chi_square_test(&[100.0, 1.0, 1.0, 1.0, 1.0, 0.0, 1.0], &expected, 5.0);
    assert_eq!(impossible.p, 0.0);
    let wrong = chi_square_test(&[60.0, 1.0, 1.0, 1.0, 1.0, 41.0, 0.0], &expected, 5.0);
    assert!(wrong.p < 1e-10, "{wrong:?}");
    // A thin tail joins the last full cell instead of standing alone.
    assert_eq!(chi_square_test(&[3.0, 30.0], &[3.0, 30.0], 5.0).dof, 0.0);
}

#[test]
fn kolmogorov_at_known_values() {
    close(kolmogorov_sf(1.358_1), 0.05, 1e-4);
    close(kolmogorov_sf(1.627_6), 0.01, 1e-3);
}

/// Newcombe 1998, table 1: 81 of 263 gives 0.2553 to 0.3662, 0 of 20 gives 0 to 0.1611.
#[test]
fn shares_have_wilson_intervals() {
    for (successes, count, low, high) in [(81, 263, 0.2553, 0.3662), (0, 20, 0.0, 0.1611)] {
        let found = wilson(successes, count, 0.95);
        assert!((found[0] - low).abs() < 5e-5 && (found[1] - high).abs() < 5e-5, "{found:?}");
    }
}
