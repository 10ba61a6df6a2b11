//! Rows of the pixel filters: the device's inverse distribution (gate 3), its samples by chi-square (gate 4), and a step edge
//! seen through each filter, whose picture is the filter's integral (gate 7).

use glam::{DAffine3, DVec3};

use super::images;
use super::inputs::Inputs;
use super::probe::Probe;
use super::report::{Gate, GateRow, is_wanted};
use super::subject::Subject;
use crate::error::Error;
use crate::film::filter::{self, FilterKind, PixelFilter};
use crate::film::slot::BLOCK_SAMPLES;
use crate::gpu::Device;
use crate::integrator::Estimator;
use crate::metric::stats::{Moments, chi_square_test, normal_quantile, sidak};
use crate::reference::known::{self, lamp, place};
use crate::scene::{Film, Scene, Shape};

/// Chance of a false alarm over all rows of a gate here.
const LEVEL: f64 = 1e-4;

fn filters() -> Vec<PixelFilter> {
    let of = |kind, radius| PixelFilter { kind, radius };
    vec![
        of(FilterKind::Box, 1.25),
        of(FilterKind::Gaussian, 1.5),
        of(FilterKind::BlackmanHarris, 1.5),
        of(FilterKind::BlackmanHarris, 0.01),
    ]
}

fn name(f: &PixelFilter) -> String {
    format!("{} {}", f.kind.keyword(), f.radius)
}

fn with_table(probe: Probe, f: &PixelFilter) -> Probe {
    probe.prelude(&filter::glsl()).table("filter_cells", f.cells()).files(&["film/filter.glsl"])
}

/// Gate 3. A filter is judged by the share of offsets below the result: what the share is off by bounds the error of any filtered
/// picture, whatever the slope there.
pub fn probes() -> Vec<Probe> {
    let row = |f: PixelFilter| {
        let judge = move |x: &[f32], y: &[f32]| {
            let (u, offset) = (f64::from(x[0]), f64::from(y[0]));
            let allowed = 2e-6 * u.min(1.0 - u) + 2.5e-7;
            let is_there = offset.abs() <= f.radius * (1.0 + 1e-6);
            if is_there { (f.distribution(offset) - u).abs() / allowed } else { f64::INFINITY }
        };
        let probe =
            Probe::judged(&format!("filter_offset {}", name(&f)), "y0 = filter_offset(x0);", 1, |r| [r.unit()], judge);
        with_table(probe, &f)
            .because("share of offsets below: 2e-6 of the tail (cubic), 2^-22 (f32 arithmetic at the radius)")
    };
    filters().into_iter().map(row).collect()
}

/// Gate 4.
pub fn rows(device: &Device, filter: &str, count: usize) -> Vec<GateRow> {
    const CELLS: usize = 64;
    let level = sidak(LEVEL, filters().len());
    let row = |f: PixelFilter| {
        let name = format!("filter {}", name(&f));
        if !is_wanted(Gate::Scattering, &name, filter) {
            return None;
        }
        let bound = format!("chi-square p > {level:.1e} (Sidak)");
        let unit = |r: &mut Inputs| [(r.word() >> 8) as f32 / 16_777_216.0];
        let probe = with_table(Probe::judged(&name, "y0 = filter_offset(x0);", 1, unit, |_, _| 0.0), &f);
        let results = match probe.outputs(device, count) {
            Ok(words) => words,
            Err(message) => return Some(GateRow::new(Gate::Scattering, name, false, message, bound)),
        };
        let edge = |i: usize| f.radius * (2.0 * i as f64 / CELLS as f64 - 1.0);
        let expected: Vec<f64> =
            (0..CELLS).map(|i| (f.distribution(edge(i + 1)) - f.distribution(edge(i))) * count as f64).collect();
        let mut observed = vec![0.0; CELLS];
        for word in results {
            let t = f64::from(f32::from_bits(word)) / f.radius;
            observed[((0.5 * (t + 1.0) * CELLS as f64) as usize).min(CELLS - 1)] += 1.0;
        }
        let test = chi_square_test(&observed, &expected, 5.0);
        let evidence = format!("p = {:.3e}, {CELLS} cells, {count} samples", test.p);
        Some(GateRow::new(Gate::Scattering, name, test.p > level, evidence, bound))
    };
    filters().into_iter().filter_map(row).collect()
}

/// A lamp of radiance 1 left of film column `edge`, black elsewhere: column x shows the share of offsets below edge - (x + 0.5).
fn step(f: PixelFilter, edge: f64) -> Scene {
    const SIZE: u32 = 8;
    let mut scene = Scene {
        name: format!("step {}", name(&f)),
        camera: known::camera(DVec3::Z, DVec3::ZERO, 2.0 * 0.5f64.atan()),
        film: Film { filter: f, ..Film::sized(SIZE, SIZE) },
        ..Scene::default()
    };
    // The picture spans [-0.5, 0.5]^2 in the plane z = 0, and the lamp reaches far beyond it above, below and left.
    let right = edge / f64::from(SIZE) - 0.5;
    let to_world =
        DAffine3::from_scale_rotation_translation(DVec3::splat(4.0), glam::DQuat::IDENTITY, DVec3::X * (right - 4.0));
    place(&mut scene, "lamp", Shape::Rectangle, to_world, lamp(DVec3::ONE));
    scene
}

/// Gate 7: the step through one filter, column by column, against the filter's integral.
pub fn step_edge(subject: &Subject, f: PixelFilter, spp: u32) -> Result<GateRow, Error> {
    let edge = 4.3;
    let scene = step(f, edge);
    let film = subject.film(&scene, &images::settings(Estimator::Bsdf), u64::from(spp.div_ceil(BLOCK_SAMPLES)))?;
    let (width, height) = (film.width() as usize, film.height() as usize);
    let z = normal_quantile(1.0 - 0.5 * sidak(LEVEL, width * filters().len()));
    let (mut worst, mut at) = (0.0, String::new());
    for x in 0..width {
        let wanted = f.distribution(edge - (x as f64 + 0.5));
        let column = Moments::of((0..height).map(|y| film.mean(y * width + x)[0]));
        // Each sample is lit or not: its variance is known. 2e-6 is the place of the edge in f32.
        let samples = height as f64 * f64::from(film.min_block_count() * BLOCK_SAMPLES);
        let bound = z * (wanted * (1.0 - wanted) / samples).sqrt() + 2e-6 / f.radius;
        let ratio = (column.mean - wanted).abs() / bound;
        if ratio >= worst {
            (worst, at) = (ratio, format!("column {x}: {:.5} for {wanted:.5}", column.mean));
        }
    }
    Ok(GateRow::new(
        Gate::Images,
        format!("step edge {}", name(&f)),
        worst <= 1.0,
        format!("{at}, {worst:.2} of the bound"),
        format!("the filter's integral within {z:.1} standard errors of {} samples a column", height as u32 * spp),
    ))
}

/// The filters whose pictures gate 7 looks at.
pub fn step_edges() -> Vec<(String, PixelFilter)> {
    filters().into_iter().map(|f| (format!("step edge {}", name(&f)), f)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::integrator::{SamplerKind, Settings};
    use crate::reference::independent::Independent;
    use crate::reference::{render, replay::Replay};

    /// By hand: `cargo test --lib conform::film -- --ignored --nocapture`.
    #[test]
    #[ignore = "prints the rows of the filters on the first Vulkan device"]
    fn print_rows() {
        let device = Device::open(&crate::gpu::Choice::Auto, &crate::gpu::Options::default()).unwrap();
        let mut all = super::super::probe::run_all(&device, &probes(), "", 1 << 20);
        all.extend(rows(&device, "", 1 << 20));
        all.extend(step_edges().into_iter().map(|(_, f)| step_edge(&Subject::new(&device), f, 4096).unwrap()));
        for r in &all {
            println!("{:?} gate {} {}: {}  [{}]", r.verdict, r.gate.number(), r.name, r.evidence, r.bound);
        }
    }

    /// Both modes of the oracle against the integral.
    #[test]
    fn the_oracle_sees_the_filters_integral() {
        for f in filters() {
            let scene = step(f, 4.3);
            let settings = Settings { sampler: SamplerKind::Sobol, ..Settings::default() };
            let prepared = std::sync::Arc::new(crate::prepare::prepare(&scene, &settings).unwrap());
            let films = [
                render::film(Replay::new(prepared, &settings), settings, 16),
                render::film(Independent::new(&scene), settings, 16),
            ];
            for film in films {
                for x in 0..8 {
                    let wanted = f.distribution(4.3 - (x as f64 + 0.5));
                    let mean = (0..8).map(|y| film.mean(y * 8 + x)[0]).sum::<f64>() / 8.0;
                    // 2048 samples a column: five standard errors.
                    let bound = 5.0 * (wanted * (1.0 - wanted) / 2048.0).sqrt() + 2e-6 / f.radius;
                    assert!((mean - wanted).abs() <= bound, "{f:?} column {x}: {mean} for {wanted}");
                }
            }
        }
    }
}
