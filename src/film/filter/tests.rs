//! Each filter is a density, its tail is its integral, and both inverse distributions give the tail back.

use super::*;

fn filters() -> impl Iterator<Item = PixelFilter> {
    let radii = [0.1, 0.5, 1.5, 3.0];
    FilterKind::ALL.iter().flat_map(move |&kind| radii.map(|radius| PixelFilter { kind, radius }))
}

#[test]
fn a_filter_integrates_to_one_and_its_tail_is_its_integral() {
    for f in filters() {
        // Simpson's rule on 2000 pieces: h^4/180 of the fourth derivative is below 1e-9 for all of them.
        let n = 2000;
        for from in [-1.0, -0.3, 0.0, 0.4, 0.95] {
            let a = from * f.radius;
            let h = (f.radius - a) / f64::from(n);
            let weight = |i: i32| if i == 0 || i == n { 1.0 } else { f64::from(2 + 2 * (i % 2)) };
            let mass: f64 = (0..=n).map(|i| weight(i) * f.density(a + h * f64::from(i))).sum::<f64>() * h / 3.0;
            let wanted = 1.0 - f.distribution(a);
            assert!((mass - wanted).abs() < 1e-9, "{f:?} from {a}: {mass} {wanted}");
        }
        assert_eq!((f.distribution(-2.0 * f.radius), f.density(1.01 * f.radius)), (0.0, 0.0));
    }
}

#[test]
fn blackman_harris_has_the_standard_deviation_it_says() {
    let f = PixelFilter::new(FilterKind::BlackmanHarris, Some(1.0)).unwrap();
    let n = 4000;
    let variance: f64 =
        (0..n).map(|i| f.offset((f64::from(i) + 0.5) / f64::from(n)).powi(2)).sum::<f64>() / f64::from(n);
    assert!((variance.sqrt() - 0.277).abs() < 5e-4, "{}", variance.sqrt());
}

#[test]
fn inverse_distributions_give_back_the_share() {
    for f in filters() {
        let rows = f.rows();
        let mut below = f64::NEG_INFINITY;
        for i in 0..(1u32 << 24) / 4099 {
            let u = f64::from(4099 * i) / f64::from(1u32 << 24);
            let exact = f.offset(u);
            assert!((f.distribution(exact) - u).abs() < 1e-12, "{f:?} {u}");
            // The table: 2e-6 of the tail's mass from the cubic, 2^-25 at u = 0, 1e-7 from f32 coefficients near the middle.
            let read = offset_from_rows(&rows, u);
            let off = (f.distribution(read) - u).abs();
            assert!(off <= 2e-6 * u.min(1.0 - u) + 1.3e-7, "{f:?} {u}: {off:e}");
            assert!(read >= below - 1e-6 * f.radius && read.abs() <= f.radius, "{f:?} {u}");
            below = read;
        }
    }
}

#[test]
fn a_radius_that_is_none_is_refused() {
    for radius in [0.0, -1.0, f64::NAN, f64::INFINITY, 33.0] {
        assert!(PixelFilter::new(FilterKind::Gaussian, Some(radius)).unwrap_err().contains("at most 32"), "{radius}");
    }
    assert_eq!(PixelFilter::new(FilterKind::Box, None), Ok(PixelFilter::BOX));
}

/// Independent of the sampling: a step edge filtered by drawing offsets against the convolution of the step with the filter in f64.
#[test]
fn a_step_edge_becomes_the_filters_integral() {
    for f in filters() {
        for edge in [-1.2f64, -0.4, 0.0, 0.3, 0.9] {
            let n = 4000;
            let lit = (0..n).filter(|&i| f.offset((f64::from(i) + 0.5) / f64::from(n)) < edge).count();
            // Midpoints of equal shares: the count is right to one of them.
            let steps = 4000;
            let h = (edge + f.radius) / f64::from(steps);
            let convolved: f64 = (0..steps).map(|i| f.density(h * (f64::from(i) + 0.5) - f.radius)).sum::<f64>() * h;
            let wanted = convolved.clamp(0.0, 1.0);
            let wanted = if edge <= -f.radius { 0.0 } else { wanted };
            assert!((lit as f64 / f64::from(n) - wanted).abs() < 1e-3, "{f:?} {edge}: {lit} {wanted}");
        }
    }
}
