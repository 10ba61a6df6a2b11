//! Cells of a hemisphere that crowd around a lobe's peak, with quadrature points: integrals of narrow lobes, and bins for
//! chi-square, from the same division.
//!
//! Coordinates are the polar angle from the hemisphere's pole and the azimuth, each divided on both sides of the peak at
//! exponentially growing distances. The horizon is an edge of cells, so what ends there is integrated to full order.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::{DVec3, DVec4};

use crate::bsdf::ggx_albedo::gauss_legendre;

/// Cells on each side of the peak, in each coordinate.
const PANELS: usize = 10;
/// A cell is divided in four while that changes its integral by more, to this depth.
const TOLERANCE: f64 = 2e-6;
const MAX_DEPTH: u32 = 8;
/// Width of the innermost cells, radian: a tenth of the narrowest lobe that is not a delta lobe.
const INNERMOST: f64 = 1e-4;

/// Division of the hemisphere about `pole` (+1 or -1 along z).
pub struct Chart {
    pole: f64,
    /// Edges of the polar angle and of the azimuth relative to `azimuth`.
    theta: Vec<f64>,
    phi: Vec<f64>,
    azimuth: f64,
    nodes: Vec<(f64, f64)>,
}

impl Chart {
    /// `peak` is where the lobe of that hemisphere stands; `order` Gauss points a cell and coordinate.
    pub fn new(peak: DVec3, pole: f64, order: usize) -> Self {
        let theta0 = (peak.z * pole).clamp(0.0, 1.0).acos();
        Self {
            pole,
            theta: graded(0.0, theta0, FRAC_PI_2),
            phi: graded(-PI, 0.0, PI),
            azimuth: peak.y.atan2(peak.x),
            nodes: gauss_legendre(order),
        }
    }

    pub fn cell_count(&self) -> usize {
        (self.theta.len() - 1) * (self.phi.len() - 1)
    }

    /// Integral over the solid angle of each cell.
    pub fn integrals(&self, f: impl Fn(DVec3) -> DVec4) -> Vec<DVec4> {
        let mut cells = Vec::with_capacity(self.cell_count());
        for t in self.theta.windows(2) {
            for p in self.phi.windows(2) {
                let (t, p) = ([t[0], t[1]], [p[0], p[1]]);
                cells.push(self.refine(&f, t, p, self.integral(&f, t, p), MAX_DEPTH));
            }
        }
        cells
    }

    fn integral(&self, f: &impl Fn(DVec3) -> DVec4, t: [f64; 2], p: [f64; 2]) -> DVec4 {
        let mut sum = DVec4::ZERO;
        for &(a, wa) in &self.nodes {
            let (sin, cos) = (t[0] + (t[1] - t[0]) * a).sin_cos();
            for &(b, wb) in &self.nodes {
                let (s, c) = (self.azimuth + p[0] + (p[1] - p[0]) * b).sin_cos();
                sum += f(DVec3::new(sin * c, sin * s, cos * self.pole)) * (wa * wb * sin);
            }
        }
        sum * ((t[1] - t[0]) * (p[1] - p[0]))
    }

    fn refine(&self, f: &impl Fn(DVec3) -> DVec4, t: [f64; 2], p: [f64; 2], whole: DVec4, depth: u32) -> DVec4 {
        let (tm, pm) = (0.5 * (t[0] + t[1]), 0.5 * (p[0] + p[1]));
        let quarters =
            [([t[0], tm], [p[0], pm]), ([t[0], tm], [pm, p[1]]), ([tm, t[1]], [p[0], pm]), ([tm, t[1]], [pm, p[1]])];
        let parts = quarters.map(|(t, p)| self.integral(f, t, p));
        let sum = parts[0] + parts[1] + parts[2] + parts[3];
        if depth == 0 || (sum - whole).abs().max_element() < TOLERANCE {
            return sum;
        }
        quarters.iter().zip(parts).map(|(&(t, p), part)| self.refine(f, t, p, part, depth - 1)).sum()
    }

    /// Cell that holds `w`; None in the other hemisphere.
    pub fn cell_of(&self, w: DVec3) -> Option<usize> {
        if w.z * self.pole <= 0.0 {
            return None;
        }
        let theta = (w.x * w.x + w.y * w.y).sqrt().atan2(w.z * self.pole);
        let turn = w.y.atan2(w.x) - self.azimuth;
        let phi = turn - (turn / TAU).round() * TAU;
        let place = |edges: &[f64], v: f64| (edges.partition_point(|&e| e <= v).max(1) - 1).min(edges.len() - 2);
        Some(place(&self.theta, theta) * (self.phi.len() - 1) + place(&self.phi, phi))
    }
}

/// Edges from `low` to `high`, crowded around `center`.
fn graded(low: f64, center: f64, high: f64) -> Vec<f64> {
    let side = |extent: f64| -> Vec<f64> {
        let rate = (extent / INNERMOST).ln_1p();
        (1..=PANELS).map(|k| INNERMOST * (rate * k as f64 / PANELS as f64).exp_m1()).collect()
    };
    let mut edges = vec![center];
    if center - low > 1e-12 {
        edges.extend(side(center - low).iter().map(|d| center - d));
    }
    edges.reverse();
    if high - center > 1e-12 {
        edges.extend(side(high - center).iter().map(|d| center + d));
    }
    let last = edges.len() - 1;
    (edges[0], edges[last]) = (low, high);
    edges
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_cover_the_hemisphere_once() {
        for peak in [DVec3::Z, DVec3::new(0.6, 0.0, 0.8), DVec3::new(0.0, -1.0, 0.0), DVec3::new(0.3, 0.4, -0.5)] {
            for pole in [1.0, -1.0] {
                let chart = Chart::new(peak, pole, 4);
                let area: DVec4 = chart.integrals(|w| DVec4::new(1.0, w.z * pole, w.x, 0.0)).into_iter().sum();
                let expected = DVec4::new(TAU, PI, 0.0, 0.0);
                assert!((area - expected).length() < 1e-6, "peak {peak} pole {pole}: {area}");
            }
        }
    }
}
