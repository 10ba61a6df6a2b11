//! The gates: what a device and the project's own mathematics must hold before a picture is believed (DESIGN, section 4).
//!
//! `run` checks a device and returns a `Report`; `steradian conform` prints it, tests only call it. A family of functions keeps
//! its rows in a file here: `math`, `warp`, `sampler`, `texture`, `light`, `bsdf`, `film`. Gate 3 compares every GLSL function free of
//! path state with f64 (`probe`); a function that no row names is listed in `coverage` with the gate that covers it, or fails.

pub mod aov;
pub mod bsdf;
pub mod camera;
pub mod coverage;
pub mod film;
pub mod images;
pub mod inputs;
pub mod ledger;
pub mod models;
pub mod mutations;
pub mod paths;
pub mod probe;
pub mod records;
pub mod replay;
pub mod report;
pub mod subject;
mod superposition;
pub mod traversal;

mod builtin;
mod cosine;
mod light;
mod math;
mod sampler;
mod texture;
mod warp;

pub use probe::Probe;
pub use report::{Gate, GateRow, Report, Verdict};

use crate::gpu::Device;

/// Inputs of a probe row: at least a million.
pub const PROBE_INPUTS: usize = 1 << 20;

/// Every probe row of gates 2 and 3.
pub fn probes() -> Vec<Probe> {
    [
        builtin::probes(),
        math::probes(),
        warp::probes(),
        sampler::probes(),
        texture::probes(),
        light::probes(),
        bsdf::probes(),
        film::probes(),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// Gates 1 to 5 on a device. A row runs when its name, or "gate N", contains `filter`; an empty filter is all.
pub fn run(device: &Device, filter: &str) -> Report {
    let mut report = Report::new(&device.info().name, &device.info().driver);
    let probes = probes();
    report.rows.extend(records::rows(device, filter));
    report.rows.extend(probe::run_all(device, &probes, filter, PROBE_INPUTS));
    report.rows.extend(light::rows(device, filter, PROBE_INPUTS));
    report.rows.extend(film::rows(device, filter, PROBE_INPUTS));
    report.rows.extend(bsdf::properties::rows(filter));
    report.rows.extend(bsdf::furnace_rows(device, filter, 7));
    report.rows.extend(traversal::run(device, filter));
    report.rows.extend(coverage::rows(&probes).into_iter().filter(|row| row.is_wanted(filter)));
    report
}
