//! Gaussian, cut at its radius of three standard deviations (0.27 % of the mass lies beyond and is given back to the rest).
//! Keyword `gaussian`; the default of 1.5 pixels is a standard deviation of half a pixel.

use std::f64::consts::{FRAC_1_SQRT_2, FRAC_2_SQRT_PI};

use super::Shape;
use crate::metric::special::erfc;

/// Radius in standard deviations.
const CUT: f64 = 3.0;
/// Share of a normal variable within `CUT` standard deviations: erf(CUT/sqrt(2)).
const KEPT: f64 = 0.997_300_203_936_739_8;

pub const SHAPE: Shape = Shape { doc: "normal, cut at three standard deviations", radius: 1.5, density, tail };

fn density(t: f64) -> f64 {
    let z = CUT * t;
    // 1/sqrt(2 pi) = (2/sqrt(pi)) (1/sqrt(2))/2.
    0.5 * CUT * FRAC_2_SQRT_PI * FRAC_1_SQRT_2 * (-0.5 * z * z).exp() / KEPT
}

fn tail(t: f64) -> f64 {
    let beyond = |t: f64| erfc(CUT * t * FRAC_1_SQRT_2);
    (beyond(t) - beyond(1.0)) / (2.0 * KEPT)
}
