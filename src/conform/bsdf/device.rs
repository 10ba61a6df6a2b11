//! Gate 3 rows of a model, `eval` with `pdf` and `sample`, and its furnace on the device.
//!
//! The bound is backward: a result passes if it lies within K eps of what f64 gives, or of what f64's differences say
//! that relative changes of K eps of the inputs do. Where a choice, a horizon or total reflection is that close, f64 may
//! fall on either side, and the result must fit one of them.

use glam::DVec3;

use rayon::prelude::*;

use super::super::inputs::Inputs;
use super::super::probe::{EPS, Probe};
use super::super::report::{Gate, GateRow, is_wanted};
use super::properties::{INTEGRAL_ERROR, albedo_and_cells, directions};
use super::{Case, Domain, ROWS, Row, cases};
use crate::bsdf::{InputKind, MODELS, Model, Params, SAMPLE_DELTA, SAMPLE_TRANSMISSION};
use crate::gpu::Device;
use crate::metric::stats::{Moments, normal_quantile, sidak};

/// Words of an input row: a model's inputs (colours take three), then two directions, or one, a choice and u.
const WORDS: usize = 28;
/// Step of the differences, 16 eps.
const STEP: f64 = 1.0 / 1_048_576.0;
/// A direction whose z is this small may be on either side after rounding: 2 (o.h) h.z - o.z cancels.
const HORIZON: f64 = 64.0 * EPS;
/// Below this a result may be flushed to 0.
const FLOOR: f64 = 1e-30;

/// A GLSL expression for each of the model's inputs, and the word after them.
fn arguments(model: &Model) -> (String, usize) {
    let mut word = 0;
    let mut text = Vec::new();
    for input in model.inputs {
        match input.kind {
            InputKind::Scalar => text.push(format!("x{word}")),
            InputKind::Color => text.push(format!("Spectrum(x{word}, x{}, x{})", word + 1, word + 2)),
        }
        word += if input.kind == InputKind::Color { 3 } else { 1 };
    }
    (text.join(", "), word)
}

fn base(name: &str, text: &str, model: &'static Model, probe: impl FnOnce(&str, &str) -> Probe) -> Probe {
    let (arguments, _) = arguments(model);
    let text = format!("{} b = {}_params({arguments}); {text}", model.glsl_type, model.keyword);
    let mut probe = probe(name, &text).files(&["bsdf/common.glsl"]);
    for (define, _) in model.macros {
        probe = probe.define(define, 1);
    }
    for shared in model.shared_with(|_| true) {
        probe = probe.files(&[shared.file]);
        if let Some(table) = shared.table {
            let rows = crate::bsdf::table_rows(table).unwrap_or_default();
            probe = probe.table(table, rows.iter().map(|r| r.map(f32::to_bits)).collect());
        }
    }
    let file = crate::shader::source::paths().find(|p| *p == format!("bsdf/{}.glsl", model.keyword));
    probe.files(file.as_slice())
}

/// The two rows of a model.
pub fn probes(row: &'static Row) -> Vec<Probe> {
    probes_of(row).into()
}

/// `eval`, `sample`.
fn probes_of(row: &'static Row) -> [Probe; 2] {
    let index = MODELS.iter().position(|m| m.keyword == row.keyword).expect("a row names a model");
    let model = &MODELS[index];
    let (k, at) = (model.keyword, arguments(model).1);
    let eval = format!(
        "vec3 wo = vec3(x{}, x{}, x{}), wi = vec3(x{}, x{}, x{}); Spectrum f = {k}_eval(b, wo, wi); y0 = f.x; y1 = f.y; \
         y2 = f.z; y3 = {k}_pdf(b, wo, wi); Spectrum a = {k}_albedo(b); y4 = a.x; y5 = a.y; y6 = a.z; \
         y7 = {k}_is_delta(b) ? 1.0 : 0.0;",
        at,
        at + 1,
        at + 2,
        at + 3,
        at + 4,
        at + 5
    );
    let sample = format!(
        "BsdfSample s = {k}_sample(b, vec3(x{}, x{}, x{}), n{}, vec2(x{}, x{})); y0 = s.wi.x; y1 = s.wi.y; y2 = s.wi.z; \
         y3 = s.weight.x; y4 = s.weight.y; y5 = s.weight.z; y6 = s.pdf; y7 = s.eta_scale; y8 = float(s.flags);",
        at,
        at + 1,
        at + 2,
        at + 3,
        at + 4,
        at + 5
    );
    let why = |k: f64, more: &str| format!("{k} eps (|y| + sum|x dy/dx|), finite, >= 0{more}");
    let [k_eval, k_sample] = row.k;
    [
        base(&format!("{k}_eval"), &eval, model, |name, text| {
            let generate = move |r: &mut Inputs| inputs(r, row, index, false);
            Probe::judged(name, text, 8, generate, move |x, y| judge_eval(index, k_eval, x, y))
        })
        .covers(row.covers)
        .because(&why(k_eval, "")),
        base(&format!("{k}_sample"), &sample, model, |name, text| {
            let generate = move |r: &mut Inputs| inputs(r, row, index, true);
            Probe::judged(name, text, 9, generate, move |x, y| judge_sample(index, k_sample, x, y))
        })
        .because(&why(k_sample, "; 4 eps / |wi.z| besides; either side of a choice within 2^-16")),
    ]
}

fn draw(r: &mut Inputs, domain: Domain) -> f32 {
    match domain {
        Domain::Unit => r.range(0.0, 1.0),
        Domain::Roughness if r.once_in(8) => r.pick(&[0.0, 0.03, 0.0317, 1.0]),
        Domain::Roughness => r.range(0.0317, 1.0),
        Domain::RoughnessY if r.once_in(2) => -1.0,
        Domain::RoughnessY => draw(r, Domain::Roughness),
        Domain::Index if r.once_in(8) => r.pick(&[1.0, 1.000_000_1, 0.999_999_9, 1.001, 0.999]),
        Domain::Index => r.log(0.3, 3.0),
        Domain::Coat => r.range(1.0, 3.0),
        Domain::Metal => r.range(0.0, 8.0),
        Domain::Switch => r.pick(&[0.0, 1.0]),
        Domain::Turn => r.range(-7.0, 7.0),
        Domain::Off if r.once_in(2) => 0.0,
        Domain::Off => r.range(0.0, 1.0),
        Domain::RoughnessOff if r.once_in(2) => 0.0,
        Domain::RoughnessOff => draw(r, Domain::Roughness),
    }
}

/// A row of inputs; half of the directions of an eval row are where the model itself samples.
fn inputs(r: &mut Inputs, row: &Row, index: usize, is_sample: bool) -> [f32; WORDS] {
    let mut x = [0.0f32; WORDS];
    let mut at = 0;
    for (input, &domain) in MODELS[index].inputs.iter().zip(row.domains) {
        for _ in 0..if input.kind == InputKind::Color { 3 } else { 1 } {
            x[at] = draw(r, domain);
            at += 1;
        }
    }
    let direction = |r: &mut Inputs| if MODELS[index].transmits { r.direction() } else { r.upper_direction() };
    x[at..at + 3].copy_from_slice(&direction(r));
    x[at + 3..at + 6].copy_from_slice(&direction(r));
    let (choice, u) = (r.word_or_edge(), [r.unit(), r.unit()]);
    if is_sample {
        x[at + 3..at + 6].copy_from_slice(&[f32::from_bits(choice), u[0], u[1]]);
    } else if r.once_in(2) {
        let wide = widen(&x);
        let wo = DVec3::new(wide[at], wide[at + 1], wide[at + 2]);
        let u = u.map(|u| f64::from(u) * 0.999);
        if let Some(s) = params(index, &wide).bsdf().sample(wo, choice, u) {
            x[at + 3..at + 6].copy_from_slice(&s.wi.as_vec3().to_array());
        }
    }
    x
}

fn widen(x: &[f32]) -> [f64; WORDS] {
    std::array::from_fn(|i| f64::from(x[i]))
}

fn params(index: usize, x: &[f64; WORDS]) -> Params {
    let mut at = 0;
    let inputs: Vec<DVec3> = MODELS[index]
        .inputs
        .iter()
        .map(|input| {
            let is_color = input.kind == InputKind::Color;
            let value = if is_color { DVec3::new(x[at], x[at + 1], x[at + 2]) } else { DVec3::splat(x[at]) };
            at += if is_color { 3 } else { 1 };
            value
        })
        .collect();
    Params::from_inputs(index, &inputs)
}

fn eval_reference(index: usize, x: &[f64; WORDS]) -> [f64; 8] {
    let at = arguments(&MODELS[index]).1;
    let p = params(index, x);
    let (wo, wi) = (DVec3::new(x[at], x[at + 1], x[at + 2]), DVec3::new(x[at + 3], x[at + 4], x[at + 5]));
    let (f, a) = (p.bsdf().eval(wo, wi), p.bsdf().albedo());
    [f.x, f.y, f.z, p.bsdf().pdf(wo, wi), a.x, a.y, a.z, f64::from(u8::from(p.bsdf().is_delta()))]
}

/// wi, weight, pdf, eta_scale, flags; None: absorbed.
fn sample_reference(index: usize, x: &[f64; WORDS], choice: u32) -> Option<[f64; 9]> {
    let at = arguments(&MODELS[index]).1;
    let s = params(index, x).bsdf().sample(DVec3::new(x[at], x[at + 1], x[at + 2]), choice, [x[at + 4], x[at + 5]])?;
    let (d, w) = (s.wi, s.weight);
    Some([d.x, d.y, d.z, w.x, w.y, w.z, s.pdf, s.eta_scale, f64::from(s.flags & (SAMPLE_DELTA | SAMPLE_TRANSMISSION))])
}

/// Sum over the continuous inputs of |x dy/dx|, for each output, by the larger one-sided difference: near degenerate half
/// vectors f is even in its inputs, and a central difference would see nothing.
fn conditioning<const M: usize>(x: &[f64; WORDS], f: impl Fn(&[f64; WORDS]) -> [f64; M]) -> [f64; M] {
    let mut sum = [0.0; M];
    let here = f(x);
    for i in (0..WORDS).filter(|&i| x[i] != 0.0) {
        let mut moved = *x;
        moved[i] = x[i] * (1.0 + STEP);
        let up = f(&moved);
        moved[i] = x[i] * (1.0 - STEP);
        let down = f(&moved);
        for m in 0..M {
            let slope = (up[m] - here[m]).abs().max((down[m] - here[m]).abs()) / STEP;
            sum[m] += if slope.is_finite() { slope } else { 0.0 };
        }
    }
    sum
}

fn judge_eval(index: usize, k: f64, x: &[f32], y: &[f32]) -> f64 {
    if !y.iter().all(|v| v.is_finite() && *v >= 0.0) {
        return f64::INFINITY;
    }
    let x = widen(x);
    let wanted = eval_reference(index, &x);
    // Shares of light are differences from 1: f |cos wi| of the cosine lobe is held to |cos wi|.
    let floor = FLOOR + EPS * x[arguments(&MODELS[index]).1 + 5].abs();
    let over =
        |m: usize, moved: f64| (f64::from(y[m]) - wanted[m]).abs() / (k * EPS * (wanted[m].abs() + moved) + k * floor);
    if (0..8).all(|m| over(m, 0.0) <= 1.0) {
        return (0..8).map(|m| over(m, 0.0)).fold(0.0, f64::max);
    }
    let moved = conditioning(&x, |x| eval_reference(index, x));
    (0..8).map(|m| over(m, moved[m])).fold(0.0, f64::max)
}

fn judge_sample(index: usize, k: f64, x: &[f32], y: &[f32]) -> f64 {
    if !(y.iter().all(|v| v.is_finite()) && y[3..].iter().all(|v| *v >= 0.0)) {
        return f64::INFINITY;
    }
    let at = arguments(&MODELS[index]).1;
    let choice = x[at + 3].to_bits();
    let mut x = widen(x);
    x[at + 3] = 0.0;
    let fits = |x: &[f64; WORDS], choice: u32| fit_of_sample(index, k, x, choice, y);
    let first = fits(&x, choice);
    if first <= 1.0 {
        return first;
    }
    // Either side of a choice, of the horizon, of total reflection.
    let mut best = first;
    for step in (0..=16).chain(-16..0i32) {
        let away = if step == 0 { 0 } else { 1 << step.unsigned_abs() };
        let choice = if step < 0 { choice.saturating_sub(away) } else { choice.saturating_add(away) };
        best = best.min(fits(&x, choice));
        for i in (0..WORDS).filter(|&i| x[i] != 0.0) {
            for step in [-STEP, STEP] {
                if best <= 1.0 {
                    return best;
                }
                let mut moved = x;
                moved[i] *= 1.0 + step;
                best = best.min(fits(&moved, choice));
            }
        }
    }
    best
}

/// Error over bound if f64 had these inputs.
fn fit_of_sample(index: usize, k: f64, x: &[f64; WORDS], choice: u32, y: &[f32]) -> f64 {
    let is_absorbed = y[6] == 0.0;
    let Some(wanted) = sample_reference(index, x, choice) else {
        return if is_absorbed || f64::from(y[2]).abs() < HORIZON { 0.0 } else { f64::INFINITY };
    };
    if is_absorbed && wanted[2].abs() < HORIZON {
        return 0.0;
    }
    if is_absorbed || wanted[8] != f64::from(y[8]) {
        return f64::INFINITY;
    }
    // The direction is one vector; weight and pdf each have their own scale. A direction's z is known to eps, so what is
    // proportional to it is known to eps / z.
    let grazing = 4.0 * EPS / wanted[2].abs().max(EPS);
    let over = |m: usize, moved: f64| {
        let scale = if m < 3 { 1.0 } else { wanted[m].abs() };
        (f64::from(y[m]) - wanted[m]).abs() / (k * EPS * (scale + moved) + grazing * scale + FLOOR)
    };
    let plain = (0..8).map(|m| over(m, 0.0)).fold(0.0, f64::max);
    if plain <= 1.0 {
        return plain;
    }
    let moved = conditioning(x, |x| sample_reference(index, x, choice).unwrap_or([f64::NAN; 9]));
    (0..8).map(|m| over(m, moved[m])).fold(0.0, f64::max)
}

/// Samples of a case in the device's furnace.
const FURNACE_SAMPLES: usize = 1 << 14;
/// Bytes of the inputs of one dispatch: devices need bind no more than 128 MiB at once.
const FURNACE_BYTES: usize = 96 << 20;

/// Furnace on the device: mean weight over uniform random numbers against the quadrature of f64, within 3 sigma widened for
/// the number of cases (Sidak); one row a model. `stride` takes every so many-th case.
pub fn furnace_rows(device: &Device, filter: &str, stride: usize) -> Vec<GateRow> {
    ROWS.iter()
        .filter(|r| is_wanted(Gate::Scattering, r.keyword, filter))
        .map(|r| furnace_row(device, r, stride))
        .collect()
}

/// Samples of each try, from the device.
fn furnace_results(device: &Device, row: &'static Row, tries: &[(&Case, DVec3)]) -> Result<Vec<u32>, String> {
    let [_, probe] = probes_of(row);
    let mut words = Vec::with_capacity(tries.len() * FURNACE_SAMPLES * WORDS);
    for (case, wo) in tries {
        let mut head: Vec<f32> = Vec::new();
        for (input, value) in case.model.inputs.iter().zip(&case.inputs) {
            head.extend(&value.as_vec3().to_array()[..if input.kind == InputKind::Color { 3 } else { 1 }]);
        }
        head.extend(wo.as_vec3().to_array());
        for n in 0..FURNACE_SAMPLES {
            let mut r = Inputs::new("furnace", n as u32);
            let mut x: Vec<u32> = head.iter().map(|v| v.to_bits()).collect();
            let unit = |word: u32| ((word >> 8) as f32 / 16_777_216.0).to_bits();
            x.extend([r.word(), unit(r.word()), unit(r.word())]);
            x.resize(WORDS, 0);
            words.extend(x);
        }
    }
    probe.results(device, &words, tries.len() * FURNACE_SAMPLES)
}

fn furnace_row(device: &Device, row: &'static Row, stride: usize) -> GateRow {
    let name = format!("{} furnace on the device", row.keyword);
    let every = cases(row);
    let tries: Vec<(&Case, DVec3)> =
        every.iter().step_by(stride).flat_map(|c| directions(c).into_iter().map(move |w| (c, w))).collect();
    let mut results = Vec::with_capacity(tries.len() * FURNACE_SAMPLES * 9);
    for part in tries.chunks(FURNACE_BYTES / (FURNACE_SAMPLES * WORDS * 4)) {
        match furnace_results(device, row, part) {
            Ok(part) => results.extend(part),
            Err(message) => return GateRow::new(Gate::Scattering, &name, false, message, ""),
        }
    }
    // 3 sigma, two-sided, for all tries together.
    let sigmas = normal_quantile(1.0 - 0.5 * sidak(0.0027, tries.len()));
    let worst = tries
        .par_iter()
        .zip(results.par_chunks(9 * FURNACE_SAMPLES))
        .map(|(&(case, wo), y)| {
            let wanted = albedo_and_cells(case, wo).0;
            let energy = y.chunks(9).map(|s| {
                let [w, pdf, scale] = [s[3], s[6], s[7]].map(|b| f64::from(f32::from_bits(b)));
                if pdf > 0.0 { w / scale } else { 0.0 }
            });
            let m = Moments::of(energy);
            // The quadrature's own error is not chance.
            let away = ((m.mean - wanted.x).abs() - INTEGRAL_ERROR).max(0.0);
            let z = if away > 0.0 { away / m.variance_of_mean().sqrt().max(1e-6) } else { 0.0 };
            (if z.is_nan() { f64::INFINITY } else { z }, case.label.clone(), wo.z, m.mean, wanted.x)
        })
        .max_by(|a, b| a.0.total_cmp(&b.0));
    let Some((z, label, cos, mean, wanted)) = worst else {
        return GateRow::new(Gate::Scattering, &name, false, "no case".into(), "");
    };
    let evidence =
        format!("{} tries; worst {label} at cos {cos}: {mean:.5}, quadrature {wanted:.5}, {z:.2} sigma", tries.len());
    let bound = format!("{sigmas:.2} sigma (3 for one try, Sidak for all) beyond the quadrature's {INTEGRAL_ERROR}");
    GateRow::new(Gate::Scattering, &name, z <= sigmas, evidence, bound)
}

#[cfg(test)]
mod tests {
    /// The rows themselves run in tests/conformance.
    #[test]
    fn every_function_of_the_models_has_a_row() {
        let probes = super::super::probes();
        let coverage = &crate::conform::coverage::rows(&probes)[0];
        let without: Vec<&str> = coverage.evidence.split(&[';', ':']).filter(|part| part.contains(" bsdf/")).collect();
        assert!(without.is_empty(), "name in `covers` of the model's row in src/conform/bsdf.rs:{}", without.join(","));
    }

    /// By hand, gates 2 to 4 of what the filter names, over fewer inputs on wish:
    /// `INPUTS=65536 FILTER="dielectric" cargo test --lib by_hand_rows -- --ignored --nocapture`.
    #[test]
    #[ignore = "a tool, not a test"]
    fn by_hand_rows() {
        let device = crate::gpu::Device::open(&crate::gpu::Choice::Auto, &crate::gpu::Options::default()).unwrap();
        let filter = std::env::var("FILTER").unwrap_or_default();
        let inputs = std::env::var("INPUTS").map_or(1 << 20, |n| n.parse().expect("INPUTS is a count"));
        let mut rows = crate::conform::probe::run_all(&device, &super::super::probes(), &filter, inputs);
        rows.extend(super::furnace_rows(&device, &filter, 7));
        rows.iter().for_each(|r| println!("{:?} {}: {} (bound: {})", r.verdict, r.name, r.evidence, r.bound));
    }
}
