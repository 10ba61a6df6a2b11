//! What rough dielectric facets lose: the deficit 1 - R - T of single scattering (Walter et al. 2007), from either side, and its
//! hemispherical averages, for the reciprocal lobe that gives it back (Kulla and Conty 2017, Revisiting physically based shading).
//!
//! A table over three numbers: the index n > 1 of the denser side over the other, through sqrt((n-1)/(n+1)), dense near 1;
//! sqrt(alpha); and x = mu (1+alpha)/(mu+alpha), whose nodes are squares, as in src/bsdf/ggx_albedo.rs. Where the interpolant would
//! lie above the deficit (checked at the middle of every cell and face) the nodes around are lowered: what is given back is at most
//! 0.004 too much (near n = 1.1 from inside, found by the test below) and 0.02 too little.
//! The table is part of the model: device and f64 read the same committed values, and a test integrates them again.

use std::sync::OnceLock;

use glam::DVec3;
use rayon::prelude::*;

use super::fresnel;
use super::ggx::{Ggx, reflect};
use super::ggx_albedo::gauss_legendre;

/// The device's lookup.
pub(super) const SHARED: super::Shared = super::Shared {
    file: "bsdf/dielectric_albedo.glsl",
    table: Some("dielectric_deficit"),
    only_with: Some("DIELECTRIC_COMPENSATION"),
};

/// Nodes, also constants in shaders/bsdf/dielectric_albedo.glsl. The index 1.5 is node 8.
pub const INDEX_COUNT: usize = 17;
pub const ALPHA_COUNT: usize = 16;
pub const X_COUNT: usize = 24;
/// Octaves of alpha below 1 and linear steps in each, of the averages.
pub const OCTAVES: usize = 10;
pub const STEPS: usize = 8;
/// sqrt(1/5) / 8, where 1/5 = (1.5 - 1)/(1.5 + 1).
const INDEX_STEP: f64 = 0.055_901_699_437_494_74;
/// Square root of the least alpha, that of `ggx::SMOOTH_ALPHA`.
const MIN_ROOT: f64 = 0.031_622_776_601_683_79;
/// Of the quadrature.
const ORDER: usize = 72;

/// On the side of the lower index, and of the higher.
pub type Deficits = [f64; 2];

pub struct Table {
    /// `values[(e * ALPHA_COUNT + j) * X_COUNT + i]`.
    values: Vec<Deficits>,
    /// `averages[e * (OCTAVES * STEPS + 1) + n]`, over alpha^2.
    averages: Vec<Deficits>,
}

impl Default for Table {
    fn default() -> Self {
        Self::new()
    }
}

impl Table {
    /// Integrates every node.
    pub fn new() -> Self {
        let nodes = gauss_legendre(ORDER);
        let count = INDEX_COUNT * ALPHA_COUNT * X_COUNT;
        let values: Vec<Deficits> = (0..count)
            .into_par_iter()
            .map(|k| {
                let (e, j, i) = (k / (ALPHA_COUNT * X_COUNT), k / X_COUNT % ALPHA_COUNT, k % X_COUNT);
                integrate_at([e as f64, j as f64, i as f64], &nodes)
            })
            .collect();
        let mut table = Self { values, averages: Vec::new() };
        table.lower(&nodes);
        let fine = gauss_legendre(8);
        for e in 0..INDEX_COUNT {
            for n in 0..=OCTAVES * STEPS {
                table.averages.push(table.average_at(e as f64, average_alpha(n), &fine));
            }
        }
        table
    }

    /// Takes from the corners of each cell by how much the interpolant exceeds the deficit in its middle, and in the middle of its
    /// two faces across x.
    fn lower(&mut self, nodes: &[(f64, f64)]) {
        let (ne, nj, ni) = (INDEX_COUNT - 1, ALPHA_COUNT - 1, 2 * X_COUNT - 1);
        let excess: Vec<Deficits> = (0..ne * nj * ni)
            .into_par_iter()
            .map(|k| {
                let (e, j, i) = (k / (nj * ni), k / ni % nj, k % ni);
                let place = [e as f64 + 0.5, j as f64 + 0.5, 0.5 * i as f64];
                let exact = integrate_at(place, nodes);
                let [index, alpha, mu] = coordinates(place);
                let there = self.at(mu, alpha, index_place(index));
                [0, 1].map(|s| (there[s] - exact[s]).max(0.0))
            })
            .collect();
        let mut less = vec![[0.0f64; 2]; self.values.len()];
        for (k, excess) in excess.iter().enumerate() {
            let (e, j, i) = (k / (nj * ni), k / ni % nj, k % ni);
            for corner in 0..8 {
                let (e, j, i) = (e + corner / 4, j + corner / 2 % 2, (i + corner % 2) / 2);
                let l = &mut less[(e * ALPHA_COUNT + j) * X_COUNT + i];
                *l = [0, 1].map(|s| l[s].max(excess[s]));
            }
        }
        for (value, less) in self.values.iter_mut().zip(less) {
            *value = [0, 1].map(|s| (value[s] - less[s]).max(0.0));
        }
    }

    /// Deficits at `mu` in (0,1], trilinear. `index`: of `index_place`.
    pub fn at(&self, mu: f64, alpha: f64, index: f64) -> Deficits {
        let alpha = alpha.clamp(MIN_ROOT * MIN_ROOT, 1.0);
        let x = (mu * (1.0 + alpha) / (mu + alpha)).min(1.0) * ((X_COUNT - 1) as f64).powi(2);
        let y = (alpha.sqrt() - MIN_ROOT) * ((ALPHA_COUNT - 1) as f64 / (1.0 - MIN_ROOT));
        let (i, j) = ((x.sqrt() as usize).min(X_COUNT - 2), (y as usize).min(ALPHA_COUNT - 2));
        let e = (index as usize).min(INDEX_COUNT - 2);
        let (fx, fy, fe) = ((x - (i * i) as f64) / (2 * i + 1) as f64, y - j as f64, index - e as f64);
        let mut sum = [0.0; 2];
        for corner in 0..8 {
            let (de, dj, di) = (corner / 4, corner / 2 % 2, corner % 2);
            let part = |d: usize, f: f64| if d == 1 { f } else { 1.0 - f };
            let value = self.values[((e + de) * ALPHA_COUNT + j + dj) * X_COUNT + i + di];
            let weight = part(de, fe) * part(dj, fy) * part(di, fx);
            sum = [0, 1].map(|s| sum[s] + weight * value[s]);
        }
        sum
    }

    /// Averages of `at`, linear in the index and in alpha between 8 nodes an octave, as multiples of alpha^2.
    pub fn average(&self, alpha: f64, index: f64) -> Deficits {
        let alpha = alpha.clamp(MIN_ROOT * MIN_ROOT, 1.0);
        let octave = alpha.log2().floor().min(-1.0);
        let t = (alpha / octave.exp2() - 1.0) * STEPS as f64 + (octave + OCTAVES as f64) * STEPS as f64;
        let n = (t as usize).min(OCTAVES * STEPS - 1);
        let e = (index as usize).min(INDEX_COUNT - 2);
        let (f, fe) = (t - n as f64, index - e as f64);
        let value = |e: usize, n: usize, s: usize| self.averages[e * (OCTAVES * STEPS + 1) + n][s];
        [0, 1].map(|s| {
            let row = |e: usize| value(e, n, s) * (1.0 - f) + value(e, n + 1, s) * f;
            (row(e) * (1.0 - fe) + row(e + 1) * fe) * alpha * alpha
        })
    }

    /// 2 int d mu dmu of the interpolant over alpha^2, cell by cell in x.
    fn average_at(&self, index: f64, alpha: f64, nodes: &[(f64, f64)]) -> Deficits {
        let cells = (X_COUNT - 1) as f64;
        let mut sum = [0.0; 2];
        for i in 0..X_COUNT - 1 {
            // Near x = 1 and small alpha, mu runs over decades inside a cell: sixteen sub-cells in log(1 + alpha - x).
            let node = |i: usize| 1.0 + alpha - (i as f64 / cells).powi(2);
            let (a, b) = (node(i), node(i + 1));
            let sub = if i + 2 == X_COUNT { 16 } else { 1 };
            for s in 0..sub {
                let edge = |s: usize| a * (b / a).powf(s as f64 / sub as f64);
                let (low, high) = (edge(s), edge(s + 1));
                for (t, w) in nodes {
                    let y = low + (high - low) * t;
                    let mu = ((1.0 + alpha - y) * alpha / y).clamp(0.0, 1.0);
                    let measure = 2.0 * mu * w * (low - high) * (1.0 + alpha) / (y * y * alpha);
                    let d = self.at(mu, alpha, index);
                    sum = [0, 1].map(|s| sum[s] + d[s] * measure);
                }
            }
        }
        sum
    }

    /// Values, then averages: what the file holds.
    pub fn numbers(&self) -> Vec<f32> {
        self.values.iter().chain(&self.averages).flatten().map(|v| *v as f32).collect()
    }

    fn from_numbers(numbers: &[f32]) -> Self {
        let pairs: Vec<Deficits> = numbers.chunks_exact(2).map(|p| [f64::from(p[0]), f64::from(p[1])]).collect();
        let (values, averages) = pairs.split_at(INDEX_COUNT * ALPHA_COUNT * X_COUNT);
        Self { values: values.to_vec(), averages: averages.to_vec() }
    }

    /// The device's rows: for index e, alpha interval j, node i the two deficits at j and at j + 1; then for index e and interval n of
    /// the averages the two of them at n and at n + 1.
    fn rows(&self) -> Vec<[f32; 4]> {
        let pair = |a: Deficits, b: Deficits| [a[0] as f32, a[1] as f32, b[0] as f32, b[1] as f32];
        let mut rows = Vec::new();
        for e in 0..INDEX_COUNT {
            for j in 0..ALPHA_COUNT - 1 {
                let at = (e * ALPHA_COUNT + j) * X_COUNT;
                rows.extend((at..at + X_COUNT).map(|k| pair(self.values[k], self.values[k + X_COUNT])));
            }
        }
        for e in 0..INDEX_COUNT {
            let at = e * (OCTAVES * STEPS + 1);
            rows.extend((at..at + OCTAVES * STEPS).map(|k| pair(self.averages[k], self.averages[k + 1])));
        }
        rows
    }
}

/// The committed table, made by `the_committed_table_is_what_the_quadrature_gives` (see there).
static FILE: &[u8] = include_bytes!("dielectric_albedo.f32");

/// The committed table: the same f32 values that the device reads.
pub fn table() -> &'static Table {
    static TABLE: OnceLock<Table> = OnceLock::new();
    TABLE.get_or_init(|| {
        let numbers = FILE.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]));
        Table::from_numbers(&numbers.collect::<Vec<_>>())
    })
}

pub fn rows() -> Vec<[f32; 4]> {
    table().rows()
}

/// Place of an index among the nodes; an index below 1 is that of the other side.
pub fn index_place(eta: f64) -> f64 {
    let n = eta.max(1.0 / eta);
    (((n - 1.0) / (n + 1.0)).sqrt() / INDEX_STEP).min((INDEX_COUNT - 1) as f64)
}

/// Index, alpha and cosine at fractional node numbers. Node 0 is not the index 1 itself, where the refracting facet is 0/0.
fn coordinates([e, j, i]: [f64; 3]) -> [f64; 3] {
    let f = (e * INDEX_STEP).powi(2);
    let n = ((1.0 + f) / (1.0 - f)).max(1.0 + 2e-4);
    let alpha = (MIN_ROOT + (1.0 - MIN_ROOT) * j / (ALPHA_COUNT - 1) as f64).powi(2);
    // Cells are linear in x between squares; at mu = 0 itself the quadrature has no outgoing side.
    let low = i.floor();
    let x = (low * low + (i - low) * (2.0 * low + 1.0)) / ((X_COUNT - 1) as f64).powi(2);
    [n, alpha, (x.max(1e-7) * alpha / (1.0 + alpha - x)).min(1.0)]
}

fn integrate_at(place: [f64; 3], nodes: &[(f64, f64)]) -> Deficits {
    let [n, alpha, mu] = coordinates(place);
    [integrate(mu, alpha, n, nodes), integrate(mu, alpha, 1.0 / n, nodes)]
}

fn average_alpha(n: usize) -> f64 {
    (1.0 + (n % STEPS) as f64 / STEPS as f64) * 2f64.powi((n / STEPS) as i32 - OCTAVES as i32)
}

/// 1 - R - T by quadrature over the square that visible normals are sampled from. `eta`: index beyond over index here.
fn integrate(mu: f64, alpha: f64, eta: f64, nodes: &[(f64, f64)]) -> f64 {
    let ggx = Ggx { alpha_x: alpha, alpha_y: alpha, is_smooth: false };
    let o = DVec3::new((1.0 - mu * mu).max(0.0).sqrt(), 0.0, mu);
    let mut lost = 0.0;
    for &(s, ws) in nodes {
        for &(t, wt) in nodes {
            // Half of the azimuths: the other half is its mirror image. Steep facets are near t = 1, more points there.
            let t2 = 1.0 - (1.0 - t) * (1.0 - t);
            let wt = wt * 2.0 * (1.0 - t);
            let h = ggx.sample_visible(o, [0.5 * s, t2]);
            let cos = o.dot(h);
            let (f, cos_t) = fresnel::dielectric(cos.clamp(0.0, 1.0), eta);
            let seen = |w: DVec3| ggx.g2(o, w) / ggx.g1(o);
            let (up, down) = (reflect(o, h), -o / eta + h * (cos / eta - cos_t));
            let reflected = if up.z > 0.0 { f * seen(up) } else { 0.0 };
            let refracted = if down.z < 0.0 { (1.0 - f) * seen(down) } else { 0.0 };
            lost += ws * wt * (1.0 - reflected - refracted);
        }
    }
    lost.max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// With STERADIAN_BLESS=1 it writes the file:
    /// `STERADIAN_BLESS=1 cargo test --lib dielectric_albedo::tests::the_committed_table`. Otherwise every 7th value is integrated again.
    #[test]
    fn the_committed_table_is_what_the_quadrature_gives() {
        if std::env::var_os("STERADIAN_BLESS").is_some() {
            let bytes: Vec<u8> = Table::new().numbers().iter().flat_map(|v| v.to_le_bytes()).collect();
            std::fs::write(concat!(env!("CARGO_MANIFEST_DIR"), "/src/bsdf/dielectric_albedo.f32"), bytes).unwrap();
            return;
        }
        let (table, nodes, fine) = (table(), gauss_legendre(ORDER), gauss_legendre(8));
        for k in (0..table.values.len()).step_by(7) {
            let (e, j, i) = (k / (ALPHA_COUNT * X_COUNT), k / X_COUNT % ALPHA_COUNT, k % X_COUNT);
            let exact = integrate_at([e as f64, j as f64, i as f64], &nodes);
            for s in [0, 1] {
                let less = exact[s] - table.values[k][s];
                assert!((-1e-6..0.1).contains(&less), "index {e} alpha {j} x {i} side {s}: {less} taken off");
            }
        }
        for (e, n) in [(0, 3), (5, 40), (8, 77), (16, 80)] {
            let made = table.average_at(e as f64, average_alpha(n), &fine);
            let held = table.averages[e * (OCTAVES * STEPS + 1) + n];
            for s in [0, 1] {
                assert!((made[s] - held[s]).abs() < 1e-5 * made[s], "average {e} {n} {s}: {made:?} {held:?}");
            }
        }
    }

    #[test]
    fn the_table_stays_below_the_deficit_and_near_it() {
        let nodes = gauss_legendre(96);
        let (mut above, mut below) = ((0.0, [0.0; 4]), (0.0, [0.0; 4]));
        for n in [1.1, 1.2, 1.333, 1.5, 1.76, 2.4] {
            for j in 0..10 {
                let alpha = (0.0317 * 1.44f64.powi(j)).powi(2).min(1.0);
                for i in 1..=12 {
                    let mu = (i as f64 / 12.0f64).powi(2);
                    let there = table().at(mu, alpha, index_place(n));
                    for (s, eta) in [(0, n), (1, 1.0 / n)] {
                        let error = there[s] - integrate(mu, alpha, eta, &nodes);
                        if error > above.0 {
                            above = (error, [mu, alpha, n, s as f64]);
                        }
                        if error < below.0 {
                            below = (error, [mu, alpha, n, s as f64]);
                        }
                    }
                }
            }
        }
        println!("largest errors; mu, alpha, n, side: above {above:?} below {below:?}");
        assert!(above.0 < 4e-3 && below.0 > -0.03);
    }
}
