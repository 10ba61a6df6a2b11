//! Directional albedo of isotropic GGX facets: what single scattering loses, for Kulla and Conty 2017 and for layering.
//!
//! Two functions of mu = cos and alpha: the deficit A = 1 - E0, where E0 is the albedo with F = 1, and B, the albedo with
//! F = (1-cos)^5, so that Schlick facets have E = F0 E0 + (1-F0) B. Both change over mu ~ alpha when alpha is small, so the
//! table runs over x = mu (1+alpha)/(mu+alpha), its nodes at squares since A ~ x log x; and over sqrt(alpha) from the smooth
//! threshold to 1. B is kept as q = c/(mu+alpha), where (1-c)^5 E0 = B: c is the cosine at the facet on average, and q is
//! nearly linear in x. Deficits, not albedos: 1 - E of a smooth surface has no digits in f32.
//! Averages 2 int f mu dmu are taken of the interpolated table, so that the compensated lobe closes to rounding.
//! The table is part of the models: device and f64 read the same committed values, and a test integrates them again.

use std::f64::consts::PI;
use std::sync::OnceLock;

use glam::DVec3;
use rayon::prelude::*;

use super::ggx::{Ggx, reflect};

/// The device's lookup.
pub(super) const SHARED: super::Shared =
    super::Shared { file: "bsdf/ggx_albedo.glsl", table: Some("ggx_albedo"), only_with: None };

/// Nodes over x and alpha of the table, also constants in shaders/bsdf/ggx_albedo.glsl.
pub const X_COUNT: usize = 48;
pub const ALPHA_COUNT: usize = 40;
/// Octaves of alpha below 1 and linear steps in each, of the averages.
pub const OCTAVES: u32 = 10;
pub const STEPS: u32 = 8;

/// Square root of the least alpha in the table, that of `ggx::SMOOTH_ALPHA`; below, everything is a mirror.
const MIN_ROOT: f64 = 0.031_622_776_601_683_79;

/// A and B at one direction, or their hemispherical averages.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Albedo {
    pub deficit: f64,
    pub schlick: f64,
}

impl Albedo {
    /// Albedo of facets with Schlick's Fresnel term.
    pub fn with_f0(&self, f0: DVec3) -> DVec3 {
        f0 * (1.0 - self.deficit) + (DVec3::ONE - f0) * self.schlick
    }
}

/// (A, q) on nodes; `values[j * x_count + i]`.
pub struct Table {
    x_count: usize,
    alpha_count: usize,
    values: Vec<[f64; 2]>,
    averages: Vec<Albedo>,
}

impl Table {
    /// Integrates every node with `order`^2 Gauss points.
    pub fn new(x_count: usize, alpha_count: usize, order: usize) -> Self {
        let nodes = gauss_legendre(order);
        let values = (0..x_count * alpha_count)
            .into_par_iter()
            .map(|n| {
                let alpha = table_alpha(n / x_count, alpha_count);
                // At mu = 0 itself the quadrature has no outgoing side; A and q are continuous there.
                let x = ((n % x_count) as f64 / (x_count - 1) as f64).powi(2).max(1e-7);
                let mu = mu_of_x(x, alpha).min(1.0);
                let a = integrate(mu, alpha, &nodes);
                [a.deficit, facet_cosine(a) / (mu + alpha)]
            })
            .collect();
        let mut table = Self { x_count, alpha_count, values, averages: Vec::new() };
        table.fit_last_column(&nodes);
        let fine = gauss_legendre(8);
        table.averages = (0..=OCTAVES * STEPS).map(|n| table.average_at(average_alpha(n), &fine)).collect();
        table
    }

    /// Towards mu = 1 the fifth root of a vanishing B says nothing: q at x = 1 is set so that the last cell is right where B has
    /// weight, halfway to its other end and not beyond mu = 0.5 for small alpha.
    fn fit_last_column(&mut self, nodes: &[(f64, f64)]) {
        let n = self.x_count;
        let x0 = ((n - 2) as f64 / (n - 1) as f64).powi(2);
        for j in 0..self.alpha_count {
            let alpha = table_alpha(j, self.alpha_count);
            let mu = 0.5 * (mu_of_x(x0, alpha) + 1.0);
            let x = mu * (1.0 + alpha) / (mu + alpha);
            let (q0, q) = (self.values[j * n + n - 2][1], facet_cosine(integrate(mu, alpha, nodes)) / (mu + alpha));
            self.values[j * n + n - 1][1] = q0 + (q - q0) * (1.0 - x0) / (x - x0);
        }
    }

    /// A and B at `mu` in (0,1], bilinear.
    pub fn at(&self, mu: f64, alpha: f64) -> Albedo {
        let alpha = alpha.clamp(MIN_ROOT * MIN_ROOT, 1.0);
        let x = (mu * (1.0 + alpha) / (mu + alpha)).min(1.0) * ((self.x_count - 1) as f64).powi(2);
        let y = (alpha.sqrt() - MIN_ROOT) * ((self.alpha_count - 1) as f64 / (1.0 - MIN_ROOT));
        let (i, j) = ((x.sqrt() as usize).min(self.x_count - 2), (y as usize).min(self.alpha_count - 2));
        let (fx, fy) = ((x - (i * i) as f64) / (2 * i + 1) as f64, y - j as f64);
        let value = |k: usize| {
            let v = |di: usize, dj: usize| self.values[(j + dj) * self.x_count + i + di][k];
            (v(0, 0) * (1.0 - fx) + v(1, 0) * fx) * (1.0 - fy) + (v(0, 1) * (1.0 - fx) + v(1, 1) * fx) * fy
        };
        let deficit = value(0);
        Albedo { deficit, schlick: (1.0 - deficit) * (1.0 - value(1) * (mu + alpha)).max(0.0).powi(5) }
    }

    /// Averages of A and B, linear in alpha between 8 nodes an octave; A is interpolated as A/alpha^2.
    pub fn average(&self, alpha: f64) -> Albedo {
        let alpha = alpha.clamp(MIN_ROOT * MIN_ROOT, 1.0);
        let octave = alpha.log2().floor().min(-1.0);
        let t = (alpha / octave.exp2() - 1.0) * STEPS as f64 + (octave + OCTAVES as f64) * STEPS as f64;
        let n = (t as usize).min(self.averages.len() - 2);
        let (f, a, b) = (t - n as f64, self.averages[n], self.averages[n + 1]);
        Albedo {
            deficit: (a.deficit * (1.0 - f) + b.deficit * f) * alpha * alpha,
            schlick: a.schlick * (1.0 - f) + b.schlick * f,
        }
    }

    /// 2 int f mu dmu of the interpolant, cell by cell in x; A over alpha^2.
    fn average_at(&self, alpha: f64, nodes: &[(f64, f64)]) -> Albedo {
        let cells = (self.x_count - 1) as f64;
        let mut sum = Albedo { deficit: 0.0, schlick: 0.0 };
        for i in 0..self.x_count - 1 {
            // Near x = 1 and small alpha, mu runs over decades inside a cell: sixteen sub-cells in log(1 + alpha - x).
            let node = |i: usize| 1.0 + alpha - (i as f64 / cells).powi(2);
            let (a, b) = (node(i), node(i + 1));
            let sub = if i + 2 == self.x_count { 16 } else { 1 };
            for s in 0..sub {
                let edge = |s: usize| a * (b / a).powf(s as f64 / sub as f64);
                let (lo, hi) = (edge(s), edge(s + 1));
                for (t, w) in nodes {
                    let y = lo + (hi - lo) * t;
                    let mu = ((1.0 + alpha - y) * alpha / y).clamp(0.0, 1.0);
                    let measure = 2.0 * mu * w * (lo - hi) * alpha * (1.0 + alpha) / (y * y);
                    let f = self.at(mu, alpha);
                    sum.deficit += f.deficit * measure / (alpha * alpha);
                    sum.schlick += f.schlick * measure;
                }
            }
        }
        sum
    }

    fn from_rows(rows: &[[f32; 4]]) -> Self {
        let (nodes, averages) = rows.split_at(X_COUNT * (ALPHA_COUNT - 1));
        let low = |r: &[f32; 4]| [f64::from(r[0]), f64::from(r[1])];
        let high = |r: &[f32; 4]| [f64::from(r[2]), f64::from(r[3])];
        let values = nodes.iter().map(low).chain(nodes[nodes.len() - X_COUNT..].iter().map(high)).collect();
        let ends = averages.iter().map(low).chain(averages.last().map(high));
        let averages = ends.map(|[deficit, schlick]| Albedo { deficit, schlick }).collect();
        Self { x_count: X_COUNT, alpha_count: ALPHA_COUNT, values, averages }
    }

    /// The device's rows: per alpha interval j and node i (A, q)(i,j), (A, q)(i,j+1); then per interval of the averages
    /// (A/alpha^2, B) at its two ends.
    pub fn rows(&self) -> Vec<[f32; 4]> {
        let node = |i: usize, j: usize| self.values[j * self.x_count + i].map(|v| v as f32);
        let mut rows = Vec::new();
        for j in 0..self.alpha_count - 1 {
            for i in 0..self.x_count {
                let (a, b) = (node(i, j), node(i, j + 1));
                rows.push([a[0], a[1], b[0], b[1]]);
            }
        }
        let average = |n: usize| [self.averages[n].deficit as f32, self.averages[n].schlick as f32];
        for n in 0..self.averages.len() - 1 {
            let (a, b) = (average(n), average(n + 1));
            rows.push([a[0], a[1], b[0], b[1]]);
        }
        rows
    }
}

/// The committed table, made by `the_committed_table_is_what_the_quadrature_gives` (see there).
static FILE: &[u8] = include_bytes!("ggx_albedo.f32");

/// Rows of the committed table.
pub fn rows() -> Vec<[f32; 4]> {
    let words = FILE.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    let words: Vec<f32> = words.collect();
    words.chunks_exact(4).map(|r| [r[0], r[1], r[2], r[3]]).collect()
}

/// The committed table: the same f32 values that the device reads.
pub fn table() -> &'static Table {
    static TABLE: OnceLock<Table> = OnceLock::new();
    TABLE.get_or_init(|| Table::from_rows(&rows()))
}

fn mu_of_x(x: f64, alpha: f64) -> f64 {
    x * alpha / (1.0 + alpha - x)
}

/// Cosine c at the facet with (1-c)^5 E0 = B.
fn facet_cosine(a: Albedo) -> f64 {
    1.0 - (a.schlick / (1.0 - a.deficit)).max(0.0).powf(0.2)
}

/// Alpha of row j of a table of `count`.
fn table_alpha(j: usize, count: usize) -> f64 {
    (MIN_ROOT + (1.0 - MIN_ROOT) * j as f64 / (count - 1) as f64).powi(2)
}

/// Alpha of node n of the averages.
fn average_alpha(n: u32) -> f64 {
    (1.0 + (n % STEPS) as f64 / STEPS as f64) * 2f64.powi((n / STEPS) as i32 - OCTAVES as i32)
}

/// A and B by quadrature over the square that visible normals are sampled from: the integrand is then G2/G1, bounded and smooth
/// but for the facets that reflect below the horizon, where it reaches 0.
fn integrate(mu: f64, alpha: f64, nodes: &[(f64, f64)]) -> Albedo {
    let ggx = Ggx { alpha_x: alpha, alpha_y: alpha, is_smooth: false };
    let o = DVec3::new((1.0 - mu * mu).max(0.0).sqrt(), 0.0, mu);
    let (mut lost, mut schlick) = (0.0, 0.0);
    for &(s, ws) in nodes {
        for &(t, wt) in nodes {
            // Half of the azimuths: the other half is its mirror image. Steep facets are near t = 1, more points there.
            let t2 = 1.0 - (1.0 - t) * (1.0 - t);
            let wt = wt * 2.0 * (1.0 - t);
            let h = ggx.sample_visible(o, [0.5 * s, t2]);
            let i = reflect(o, h);
            let seen = if i.z > 0.0 { ggx.g2(o, i) / ggx.g1(o) } else { 0.0 };
            lost += ws * wt * (1.0 - seen);
            schlick += ws * wt * seen * (1.0 - o.dot(h)).powi(5);
        }
    }
    Albedo { deficit: lost, schlick }
}

/// Points and weights on [0,1] (Newton on the Legendre recurrence).
pub fn gauss_legendre(n: usize) -> Vec<(f64, f64)> {
    (0..n)
        .map(|i| {
            let mut z = (PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos();
            let mut derivative = 0.0;
            for _ in 0..20 {
                let (mut p0, mut p1) = (1.0, z);
                for k in 2..=n {
                    (p0, p1) = (p1, ((2 * k - 1) as f64 * z * p1 - (k - 1) as f64 * p0) / k as f64);
                }
                derivative = n as f64 * (z * p1 - p0) / (z * z - 1.0);
                z -= p1 / derivative;
            }
            (0.5 * (1.0 - z), 1.0 / ((1.0 - z * z) * derivative * derivative))
        })
        .collect()
}

/// (f_ms |cos wi|) of Kulla and Conty 2017 for F = 1, before the factor of Fresnel; both cosines > 0.
pub fn multiple_scattering(o: Albedo, i: Albedo, average: Albedo, cos_i: f64) -> f64 {
    if average.deficit > 0.0 { o.deficit * i.deficit * cos_i / (PI * average.deficit) } else { 0.0 }
}

/// Colour of light scattered more than once between facets (Hill 2018, after Kulla and Conty 2017): sum of F_avg^n over the
/// orders n >= 2, each followed by escape with probability E_avg.
pub fn multiple_scattering_color(fresnel_average: DVec3, average: Albedo) -> DVec3 {
    let e = 1.0 - average.deficit;
    fresnel_average * fresnel_average * e / (DVec3::ONE - fresnel_average * average.deficit)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// With STERADIAN_BLESS=1 it writes the file:
    /// `STERADIAN_BLESS=1 cargo test --lib the_committed_table_is_what_the_quadrature_gives`.
    #[test]
    fn the_committed_table_is_what_the_quadrature_gives() {
        let made = Table::new(X_COUNT, ALPHA_COUNT, 128).rows();
        if std::env::var_os("STERADIAN_BLESS").is_some() {
            let bytes: Vec<u8> = made.iter().flatten().flat_map(|v| v.to_le_bytes()).collect();
            std::fs::write(concat!(env!("CARGO_MANIFEST_DIR"), "/src/bsdf/ggx_albedo.f32"), bytes).unwrap();
            return;
        }
        assert_eq!(made.len(), rows().len());
        for (n, (a, b)) in made.iter().zip(rows()).enumerate() {
            for (a, b) in a.iter().zip(b) {
                assert!((a - b).abs() <= 1e-6 * a.abs().max(1e-3), "row {n}: made {a}, committed {b}");
            }
        }
    }

    #[test]
    fn the_table_interpolates_the_albedo() {
        let nodes = gauss_legendre(200);
        let (mut worst_a, mut worst_b) = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0));
        for j in 0..24 {
            let alpha = (0.0317 * 1.161f64.powi(j)).powi(2).min(1.0);
            for i in 1..=30 {
                let mu = (i as f64 / 30.0f64).powi(3);
                let (exact, table) = (integrate(mu, alpha, &nodes), table().at(mu, alpha));
                let (a, b) = (table.deficit - exact.deficit, table.schlick - exact.schlick);
                if a.abs() > f64::abs(worst_a.0) {
                    worst_a = (a, mu, alpha);
                }
                if b.abs() > f64::abs(worst_b.0) {
                    worst_b = (b, mu, alpha);
                }
            }
        }
        println!("largest error, mu, alpha: A {worst_a:?} B {worst_b:?}");
        assert!(worst_a.0.abs() < 1e-3 && worst_b.0.abs() < 1e-3);
    }
}
