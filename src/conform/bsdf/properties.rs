//! Gate 4 of a surface model, in f64: what must hold whatever the formulas are.
//!
//! Lobes that are not delta lobes are integrated over cells (`chart`); delta lobes and absorbed samples, which integrals do
//! not see, are counted over a low-discrepancy set of random numbers.

use glam::DVec3;

use super::chart::Chart;
use super::{Case, Furnace};
use crate::bsdf::{BsdfSample, SAMPLE_DELTA, SAMPLE_TRANSMISSION};
use crate::metric::stats::chi_square_test;

/// Cosines of the outgoing directions tried.
pub const COSINES: &[f64] = &[1.0, 0.5, 0.04];
/// Samples of a chi-square test, and of the count of delta lobes.
const CHI_SQUARE_SAMPLES: u32 = 15_000;
const DELTA_SAMPLES: u32 = 1 << 14;
/// Error of the quadrature and of the count of delta lobes, measured by doubling both.
pub const INTEGRAL_ERROR: f64 = 3e-3;

/// What was measured for one case and one outgoing direction.
#[derive(Clone, Debug)]
pub struct Finding {
    /// Fraction of uniform light that leaves towards wo, largest channel; by quadrature and counted delta lobes.
    pub albedo: f64,
    /// Integral of the pdf, probabilities of delta lobes, and of absorption: 1.
    pub mass: f64,
    /// p of the chi-square test; 1 where every lobe is a delta lobe.
    pub p: f64,
    /// Largest relative difference between a sample's weight and eval/pdf, and between its pdf and `pdf`.
    pub weight_error: f64,
    /// Sentences about what does not hold.
    pub failures: Vec<String>,
}

/// Outgoing directions of a case: off the axes, on both sides where light passes.
pub fn directions(case: &Case) -> Vec<DVec3> {
    let (s, c) = 0.7f64.sin_cos();
    let above = COSINES.iter().map(|&z| {
        let r = (1.0 - z * z).sqrt();
        DVec3::new(r * c, r * s, z)
    });
    let sides: &[f64] = if case.transmits { &[1.0, -1.0] } else { &[1.0] };
    above.flat_map(|w| sides.iter().map(move |&side| DVec3::new(w.x, w.y, w.z * side))).collect()
}

/// Everything that is found from one outgoing direction. `level`: of the chi-square test.
pub fn examine(case: &Case, wo: DVec3, level: f64) -> Finding {
    let bsdf = case.bsdf();
    let mut failures = Vec::new();
    let (albedo, mass, expected, charts) = albedo_and_cells(case, wo);
    let albedo = albedo.max_element();
    if (mass - 1.0).abs() > INTEGRAL_ERROR {
        failures.push(format!("pdf has mass {mass:.5}, not 1"));
    }
    let is_kept = match case.furnace {
        Furnace::Unity => (0.99..=1.001).contains(&albedo),
        Furnace::AtMostOne => (0.0..=1.001).contains(&albedo),
        Furnace::Exempt => albedo.is_finite(),
    };
    if !is_kept {
        failures.push(format!("of uniform light {albedo:.5} leaves, promised {:?}", case.furnace));
    }

    // Samples against cells, and each against eval and pdf.
    let mut observed = vec![0.0; expected.len()];
    let (mut weight_error, mut is_any) = (0.0f64, false);
    for n in 0..CHI_SQUARE_SAMPLES {
        let words = random(n);
        let Some(s) = bsdf.sample(wo, words[0], [unit(words[1]), unit(words[2])]) else { continue };
        if s.flags & SAMPLE_DELTA != 0 {
            continue;
        }
        is_any = true;
        weight_error = weight_error.max(disagreement(case, wo, &s));
        let cell = charts[0].cell_of(s.wi).or_else(|| charts[1].cell_of(s.wi).map(|c| charts[0].cell_count() + c));
        match cell {
            Some(cell) => observed[cell] += 1.0,
            None => failures.push(format!("sampled {} on the horizon", s.wi)),
        }
    }
    if weight_error > 1e-5 {
        failures.push(format!("weight or pdf of a sample off by {weight_error:e} from eval / pdf"));
    }
    let total = f64::from(CHI_SQUARE_SAMPLES);
    let scaled: Vec<f64> = expected.iter().map(|e| e * total).collect();
    let p = if is_any { goodness(&observed, &scaled, total) } else { 1.0 };
    if p < level {
        failures.push(format!("chi-square p = {p:e}"));
    }
    Finding { albedo, mass, p, weight_error, failures }
}

/// Light that leaves towards wo under a uniform sky, the mass of the pdf, its integral over each cell, and the cells of both
/// hemispheres.
pub fn albedo_and_cells(case: &Case, wo: DVec3) -> (DVec3, f64, Vec<f64>, [Chart; 2]) {
    let bsdf = case.bsdf();
    let side = wo.z.signum();
    let eta = if side > 0.0 { case.eta } else { 1.0 / case.eta };
    let charts = [Chart::new(DVec3::new(-wo.x, -wo.y, wo.z), side, 4), Chart::new(refracted(wo, eta), -side, 4)];

    // Integrals of eval (without the scale of refracted radiance) and of pdf.
    let mut albedo = DVec3::ZERO;
    let mut expected = Vec::new();
    for (chart, scale) in charts.iter().zip([1.0, eta * eta]) {
        let cells = chart.integrals(|wi| (bsdf.eval(wo, wi) * scale).extend(bsdf.pdf(wo, wi)));
        albedo += cells.iter().map(|v| v.truncate()).sum::<DVec3>();
        expected.extend(cells.iter().map(|v| v.w));
    }
    let mut mass: f64 = expected.iter().sum();

    // Delta lobes, absorbed samples.
    for n in 0..DELTA_SAMPLES {
        let share = 1.0 / f64::from(DELTA_SAMPLES);
        match bsdf.sample(wo, lattice(n, 0), [unit(lattice(n, 1)), unit(lattice(n, 2))]) {
            None => mass += share,
            Some(s) if s.flags & SAMPLE_DELTA != 0 => {
                mass += share;
                albedo += s.weight / s.eta_scale * share;
            }
            Some(_) => {}
        }
    }
    (albedo, mass, expected, charts)
}

/// Largest relative departure from f(i->o)/eta_o^2 = f(o->i)/eta_i^2 over random pairs of directions.
pub fn reciprocity_error(case: &Case) -> f64 {
    let bsdf = case.bsdf();
    let mut worst = 0.0f64;
    for n in 0..2000 {
        let [a, b, c] = random(n).map(unit);
        let d = unit(random(n + 7919)[0]);
        let direction = |u: f64, v: f64| {
            let z = 2.0 * u - 1.0;
            let (s, c) = (std::f64::consts::TAU * v).sin_cos();
            let r = (1.0 - z * z).sqrt();
            DVec3::new(r * c, r * s, if case.transmits { z } else { z.abs() })
        };
        let (o, i) = (direction(a, b), direction(c, d));
        let eta2 = |w: DVec3| if w.z < 0.0 { case.eta * case.eta } else { 1.0 };
        let forward = bsdf.eval(o, i) / (i.z.abs() * eta2(o));
        let backward = bsdf.eval(i, o) / (o.z.abs() * eta2(i));
        let scale = forward.max(backward).max_element();
        if scale > 1e-20 {
            worst = worst.max((forward - backward).abs().max_element() / scale);
        }
    }
    worst
}

/// Outputs that are not finite or negative over the edges of every argument.
pub fn edge_failures(case: &Case) -> Vec<String> {
    let bsdf = case.bsdf();
    let mut failures = Vec::new();
    let is_good = |v: f64| v.is_finite() && v >= 0.0;
    let edges = edge_directions();
    for &wo in &edges {
        for choice in EDGE_CHOICES {
            for u in EDGE_U.iter().flat_map(|&a| EDGE_U.iter().map(move |&b| [a, b])) {
                let Some(s) = bsdf.sample(wo, choice, u) else { continue };
                if !(is_good(s.pdf) && s.pdf > 0.0 && s.weight.to_array().into_iter().all(is_good) && s.wi.is_finite())
                {
                    failures.push(format!("sample({wo}, {choice:#x}, {u:?}) gives {s:?}"));
                }
            }
        }
        for &wi in &edges {
            let (f, pdf) = (bsdf.eval(wo, wi), bsdf.pdf(wo, wi));
            if !(is_good(pdf) && f.to_array().into_iter().all(is_good)) {
                failures.push(format!("eval, pdf({wo}, {wi}) = {f}, {pdf}"));
            }
        }
    }
    failures
}

pub const EDGE_U: [f64; 4] = [0.0, 5.960_464_477_539_063e-8, 0.5, 1.0 - 5.960_464_477_539_063e-8];
pub const EDGE_CHOICES: [u32; 5] = [0, 1, 1 << 31, u32::MAX - 1, u32::MAX];

/// Poles, horizon, grazing, generic, and the opposite of each.
pub fn edge_directions() -> Vec<DVec3> {
    let mut all = Vec::new();
    for z in [1.0, 0.999_999_9, 0.5, 1e-3, 1e-8, 1e-20, 0.0] {
        let r = (1.0f64 - z * z).max(0.0).sqrt();
        for (x, y) in [(1.0, 0.0), (0.0, 1.0), (0.6, -0.8)] {
            let w = DVec3::new(r * x, r * y, z);
            all.extend([w, -w, DVec3::new(-w.x, -w.y, w.z)]);
        }
    }
    all
}

/// Relative difference of a sample's weight and pdf from `eval` and `pdf`; 1 where its flag names the wrong side.
fn disagreement(case: &Case, wo: DVec3, s: &BsdfSample) -> f64 {
    let (value, pdf) = (case.bsdf().eval(wo, s.wi), case.bsdf().pdf(wo, s.wi));
    if (s.flags & SAMPLE_TRANSMISSION != 0) != (wo.z * s.wi.z < 0.0) {
        return 1.0;
    }
    let scale = s.weight.max_element().max(1e-12);
    ((value / pdf - s.weight).abs().max_element() / scale).max((pdf - s.pdf).abs() / s.pdf)
}

/// p of the observed cells; what is expected nowhere (delta lobes, absorption) is one more cell.
fn goodness(observed: &[f64], expected: &[f64], total: f64) -> f64 {
    let (mut o, mut e) = (observed.to_vec(), expected.to_vec());
    o.push(total - observed.iter().sum::<f64>());
    e.push((total - expected.iter().sum::<f64>()).max(0.0));
    // Where nothing but rounding is left, it is no cell of its own.
    if e[e.len() - 1] < total * 1e-3 && o[o.len() - 1] < total * 1e-3 {
        o.pop();
        e.pop();
    }
    // A direction at the edge of a lobe's support may fall into a cell of rounding's expectation.
    let floor: Vec<f64> = e.iter().map(|v| v.max(1e-9)).collect();
    chi_square_test(&o, &floor, 10.0).p
}

/// Where a smooth boundary would send the light: the peak of the far side's lobe.
fn refracted(wo: DVec3, eta: f64) -> DVec3 {
    let (x, y) = (-wo.x / eta, -wo.y / eta);
    let s2 = x * x + y * y;
    let z = (1.0 - s2).max(0.0).sqrt();
    DVec3::new(x, y, -wo.z.signum() * z)
}

fn unit(word: u32) -> f64 {
    f64::from(word >> 8) * 5.960_464_477_539_063e-8
}

/// Component `d` of point n of DELTA_SAMPLES (Hammersley 1960): the choice in base 2, u in base 3 and in order.
fn lattice(n: u32, d: usize) -> u32 {
    match d {
        0 => n.reverse_bits(),
        1 => {
            let (mut rest, mut scale, mut x) = (n, 1.0 / 3.0, 0.0);
            while rest > 0 {
                x += f64::from(rest % 3) * scale;
                (rest, scale) = (rest / 3, scale / 3.0);
            }
            (x * 4_294_967_296.0) as u32
        }
        _ => (2 * n + 1) << (31 - DELTA_SAMPLES.trailing_zeros()),
    }
}

/// Three independent words for sample n (pcg, O'Neill 2014).
fn random(n: u32) -> [u32; 3] {
    let pcg = |v: u32| {
        let s = v.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        let w = ((s >> ((s >> 28) + 4)) ^ s).wrapping_mul(277_803_737);
        (w >> 22) ^ w
    };
    let a = pcg(n);
    let b = pcg(a ^ 0x9e37_79b9);
    [a, b, pcg(b.wrapping_add(n))]
}

#[cfg(test)]
mod tests {
    use rayon::prelude::*;

    use super::super::{ROWS, cases};
    use super::*;
    use crate::metric::stats::sidak;

    fn all_cases() -> Vec<Case> {
        ROWS.iter().flat_map(cases).collect()
    }

    #[test]
    fn samples_follow_the_pdf_and_no_light_is_made() {
        let cases = all_cases();
        let tests: Vec<(usize, DVec3)> =
            cases.iter().enumerate().flat_map(|(i, c)| directions(c).into_iter().map(move |w| (i, w))).collect();
        let level = sidak(1e-3, tests.len());
        let failures: Vec<String> = tests
            .par_iter()
            .flat_map_iter(|&(i, wo)| {
                let found = examine(&cases[i], wo, level);
                let head = format!("{} at cos {}", cases[i].label, wo.z);
                found.failures.into_iter().map(move |f| format!("{head}: {f}"))
            })
            .collect();
        println!("{} tests at level {level:.1e}", tests.len());
        assert!(failures.is_empty(), "{} failures:\n{}", failures.len(), failures.join("\n"));
    }

    #[test]
    fn light_may_travel_either_way() {
        for case in all_cases() {
            let error = reciprocity_error(&case);
            assert!(error < 1e-6, "{}: reciprocity off by {error:e}", case.label);
        }
    }

    #[test]
    fn edge_inputs_give_finite_numbers() {
        for case in all_cases() {
            let failures = edge_failures(&case);
            assert!(failures.is_empty(), "{}: {} failures, first {}", case.label, failures.len(), failures[0]);
        }
    }
}
