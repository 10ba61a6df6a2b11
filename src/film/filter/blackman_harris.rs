//! Blackman-Harris: the four-term window of least side lobes (Harris 1978, "On the use of windows for harmonic analysis with the
//! discrete Fourier transform", table 1, 4-sample, -92 dB). Keyword `blackman-harris`; narrower than a Gaussian of the same radius:
//! its standard deviation is 0.277 radii.

use std::f64::consts::PI;

use super::Shape;

/// a0 + a1 cos(pi t) + a2 cos(2 pi t) + a3 cos(3 pi t), the signs for a window about 0.
const A: [f64; 4] = [0.35875, 0.48829, 0.14128, 0.01168];

pub const SHAPE: Shape = Shape { doc: "four-term window of least side lobes", radius: 1.5, density, tail };

fn density(t: f64) -> f64 {
    (0..4).map(|k| A[k] * (PI * k as f64 * t).cos()).sum::<f64>() / (2.0 * A[0])
}

fn tail(t: f64) -> f64 {
    let waves: f64 = (1..4).map(|k| A[k] * (PI * k as f64 * t).sin() / (PI * k as f64)).sum();
    0.5 - 0.5 * (t + waves / A[0])
}
