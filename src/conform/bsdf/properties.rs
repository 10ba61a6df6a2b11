//! Gate 4 of a surface model, in f64: what must hold whatever the formulas are.
//!
//! Lobes that are not delta lobes are integrated over cells (`chart`); delta lobes and absorbed samples, which integrals do
//! not see, are counted over a low-discrepancy set of random numbers.

use glam::DVec3;
use rayon::prelude::*;

use super::chart::Chart;
use super::{Case, Furnace, ROWS, cases};
use crate::bsdf::{BsdfSample, SAMPLE_DELTA, SAMPLE_TRANSMISSION};
use crate::conform::report::{Gate, GateRow, is_wanted};
use crate::metric::stats::{chi_square_test, sidak};

/// Cosines of the outgoing directions tried. A lobe that creates energy may do so beyond 0.01 only.
pub const COSINES: &[f64] = &[1.0, 0.5, 0.04, 0.002];
/// Samples of a chi-square test, and of the count of delta lobes.
const CHI_SQUARE_SAMPLES: u32 = 15_000;
const DELTA_SAMPLES: u32 = 1 << 14;
/// Error of the quadrature and of the count of delta lobes, measured by doubling both.
pub const INTEGRAL_ERROR: f64 = 3e-3;

/// Largest relative difference of a sample's weight from eval/pdf; f64 through cosines near the horizon.
const WEIGHT_ERROR: f64 = 1e-5;

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
        Furnace::AtMost(limit) => (0.0..=limit).contains(&albedo),
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
    if weight_error > WEIGHT_ERROR {
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

/// Chance of a false alarm over the chi-square tests of all models.
const LEVEL: f64 = 1e-3;
/// Largest relative departure from reciprocity in f64.
const RECIPROCITY: f64 = 1e-6;

/// Three rows a model, all in f64: densities and energy, reciprocity, edge inputs.
pub fn rows(filter: &str) -> Vec<GateRow> {
    let all: Vec<(&str, Vec<Case>)> = ROWS.iter().map(|row| (row.keyword, cases(row))).collect();
    let tests: usize = all.iter().flat_map(|(_, cases)| cases).map(|c| directions(c).len()).sum();
    let level = sidak(LEVEL, tests);
    let mut rows = Vec::new();
    for (keyword, cases) in &all {
        let makers: [(&str, &dyn Fn(&str) -> GateRow); 3] = [
            ("density and energy", &|name| densities(name, cases, level)),
            ("reciprocity", &|name| reciprocity(name, cases)),
            ("edge inputs", &|name| edges(name, cases)),
        ];
        for (what, make) in makers {
            let name = format!("{keyword} {what}, f64");
            if is_wanted(Gate::Scattering, &name, filter) {
                rows.push(make(&name));
            }
        }
    }
    rows
}

fn densities(name: &str, cases: &[Case], level: f64) -> GateRow {
    let tests: Vec<(&Case, DVec3)> =
        cases.iter().flat_map(|c| directions(c).into_iter().map(move |w| (c, w))).collect();
    let found: Vec<Finding> = tests.par_iter().map(|(case, wo)| examine(case, *wo, level)).collect();
    let failures: Vec<String> = found
        .iter()
        .zip(&tests)
        .flat_map(|(f, (case, wo))| {
            f.failures.iter().map(move |text| format!("{} at cos {}: {text}", case.label, wo.z))
        })
        .collect();
    let largest = |value: &dyn Fn(&Finding) -> f64| found.iter().map(value).fold(0.0, f64::max);
    let range = found.iter().fold([f64::INFINITY, 0.0], |r, f| [f.albedo.min(r[0]), f.albedo.max(r[1])]);
    let evidence = if failures.is_empty() {
        format!(
            "{} tests: least p {:.1e}, mass off by {:.1e}, weights by {:.1e}, of uniform light {:.5} to {:.5} leaves",
            tests.len(),
            1.0 - largest(&|f| 1.0 - f.p),
            largest(&|f| (f.mass - 1.0).abs()),
            largest(&|f| f.weight_error),
            range[0],
            range[1]
        )
    } else {
        format!("{} failures, first {}", failures.len(), failures[0])
    };
    let bound = format!(
        "p > {level:.1e} (Sidak), mass 1 within {INTEGRAL_ERROR}, weight = eval/pdf to {WEIGHT_ERROR}, furnace in [0.99, 1.001] \
         where promised, else at most 1.001"
    );
    GateRow::new(Gate::Scattering, name, failures.is_empty() && !found.is_empty(), evidence, bound)
}

fn reciprocity(name: &str, cases: &[Case]) -> GateRow {
    let errors: Vec<f64> = cases.par_iter().map(reciprocity_error).collect();
    let (at, worst) =
        errors.iter().enumerate().fold((0, 0.0), |w, (i, &e)| if e > w.1 || e.is_nan() { (i, e) } else { w });
    let evidence = format!("{} cases; worst {}: off by {worst:.1e}", cases.len(), cases[at].label);
    let bound = format!("f(i->o)/eta_o^2 = f(o->i)/eta_i^2 to {RECIPROCITY:e}");
    GateRow::new(Gate::Scattering, name, worst < RECIPROCITY, evidence, bound)
}

fn edges(name: &str, cases: &[Case]) -> GateRow {
    let failures: Vec<String> = cases
        .par_iter()
        .flat_map_iter(|case| edge_failures(case).into_iter().map(move |f| format!("{}: {f}", case.label)))
        .collect();
    let evidence = match failures.first() {
        None => format!("{} cases, all finite and not negative", cases.len()),
        Some(first) => format!("{} failures, first {first}", failures.len()),
    };
    GateRow::new(
        Gate::Scattering,
        name,
        failures.is_empty(),
        evidence,
        "finite and not negative at poles, horizon, corners of u",
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::conform::report::Verdict;

    fn cases_of(keyword: &str) -> Vec<Case> {
        ROWS.iter().filter(|r| r.keyword == keyword).flat_map(cases).collect()
    }

    /// The rows of every model run in tests/conformance and in `steradian conform`.
    #[test]
    fn rows_pass_on_the_smallest_model() {
        let rows = rows("lambert");
        assert_eq!(rows.len(), 3);
        for row in rows {
            assert!(row.verdict == Verdict::Pass && row.is_wanted("gate 4"), "{row:?}");
        }
    }

    #[test]
    fn rows_fail_on_broken_promises() {
        let is_pass = |row: GateRow| row.verdict == Verdict::Pass;
        // Masking loses light, so without compensation unity does not hold.
        let mut lossy = cases_of("conductor");
        lossy.retain(|c| c.label.contains("roughness=1 ") && c.label.contains("compensation=0"));
        lossy.iter_mut().for_each(|c| c.furnace = Furnace::Unity);
        assert!(!lossy.is_empty() && !is_pass(densities("", &lossy, 1e-6)));
        // A boundary taken for one of another index.
        let mut refracting = cases_of("dielectric");
        refracting.retain(|c| c.eta == 1.5 && c.label.contains("roughness=0.5"));
        assert!(is_pass(reciprocity("", &refracting)));
        refracting.iter_mut().for_each(|c| c.eta = 1.4);
        assert!(!refracting.is_empty() && !is_pass(reciprocity("", &refracting)));
    }
}
