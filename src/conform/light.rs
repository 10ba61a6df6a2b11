//! Rows of shaders/light: choosing, triangles, spheres, the sky, against src/light in f64; and their densities by chi-square.
//!
//! Sizes and distances sweep from 1e-12 sr to a hemisphere and beyond, points on the light's plane and edge-on included.
//! Where a result is ill-conditioned its bound says by how much, from the formula or by moving the input.

mod chi_square;
mod choose;
mod disc;
mod lamp;
mod sky;
mod sphere;
mod triangle;

use glam::DVec3;

use super::inputs::Inputs;
use super::probe::Probe;

pub use chi_square::rows;

/// Gate 2 and 3.
pub fn probes() -> Vec<Probe> {
    [choose::probes(), triangle::probes(), sphere::probes(), disc::probes(), sky::probes(), lamp::probes()]
        .into_iter()
        .flatten()
        .collect()
}

fn vector(x: &[f32]) -> DVec3 {
    DVec3::new(x[0].into(), x[1].into(), x[2].into())
}

fn direction(r: &mut Inputs) -> DVec3 {
    vector(&r.direction())
}

/// Error over bound, where both may be 0.
fn ratio(error: f64, bound: f64) -> f64 {
    if error == 0.0 { 0.0 } else { error / bound }
}
