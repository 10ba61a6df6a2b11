//! Gate 4 for lights: a million samples of the device against the density's own share of each cell, by chi-square, and the
//! mean of 1/pdf against the solid angle that the light fills, which is what "the density integrates to one" means for samples.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::super::inputs::Inputs;
use super::super::probe::Probe;
use super::super::report::{Gate, GateRow, is_wanted};
use super::{disc, sky, sphere, triangle, vector};
use crate::gpu::Device;
use crate::light::{self, sky_table::cell_solid_angle};
use crate::metric::stats::{Moments, chi_square_test, sidak};

/// Chance of a false alarm over all rows here.
const LEVEL: f64 = 1e-4;

type CellOf = Box<dyn Fn(&[f32]) -> usize + Send + Sync>;

/// One light as seen from a point.
struct Row {
    name: String,
    probe: Probe,
    /// Cell of a result.
    cell: CellOf,
    /// Probability of each cell.
    shares: Vec<f64>,
    /// Place of the density in a result, and the solid angle it is spread over.
    pdf_at: usize,
    solid_angle: f64,
}

/// Uniform words only: the edges that other rows mix in would not be chi-square distributed.
fn unit(r: &mut Inputs) -> f32 {
    (r.word() >> 8) as f32 / 16_777_216.0
}

pub fn rows(device: &Device, filter: &str, count: usize) -> Vec<GateRow> {
    let rows: Vec<Row> =
        triangles().into_iter().chain(spheres()).chain(discs()).chain(suns()).chain([sky_cells()]).collect();
    let level = sidak(LEVEL, rows.len());
    rows.iter().filter(|r| is_wanted(Gate::Scattering, &r.name, filter)).map(|r| run(r, device, count, level)).collect()
}

fn run(row: &Row, device: &Device, count: usize, level: f64) -> GateRow {
    let bound = format!("chi-square p > {level:.1e} (Sidak), mean of 1/pdf within 5 sigma + 2e-5 of the solid angle");
    let results = match row.probe.outputs(device, count) {
        Ok(words) => words,
        Err(message) => return GateRow::new(Gate::Scattering, &row.name, false, message, bound),
    };
    let results: Vec<f32> = results.into_iter().map(f32::from_bits).collect();
    let width = results.len() / count;
    let mut observed = vec![0.0; row.shares.len()];
    results.chunks(width).for_each(|y| observed[(row.cell)(y)] += 1.0);
    let expected: Vec<f64> = row.shares.iter().map(|s| s * count as f64).collect();
    let test = chi_square_test(&observed, &expected, 5.0);
    let inverse = Moments::of(results.chunks(width).map(|y| 1.0 / f64::from(y[row.pdf_at])));
    let error = (inverse.mean / row.solid_angle - 1.0).abs();
    let allowed = 5.0 * inverse.variance_of_mean().sqrt() / row.solid_angle + 2e-5;
    let evidence = format!(
        "p = {:.3e}, {} cells, {count} samples; 1/pdf off by {error:.1e} of {allowed:.1e}, {:.4e} sr",
        test.p,
        row.shares.len(),
        row.solid_angle
    );
    GateRow::new(Gate::Scattering, &row.name, test.p > level && error < allowed, evidence, bound)
}

fn triangles() -> Vec<Row> {
    let even = [DVec3::new(-0.5, -0.4, 1.0), DVec3::new(0.6, -0.3, 1.0), DVec3::new(0.0, 0.7, 1.2)];
    let sliver = [DVec3::new(-1.0, 0.3, 0.5), DVec3::new(1.0, 0.31, 0.5), DVec3::new(0.9, 0.28, 0.6)];
    let shapes = [
        ("even", even),
        ("small, by area", even.map(|v| v * 0.01 + DVec3::Z)),
        ("sliver", sliver),
        // From the middle of an edge, almost touching.
        ("on an edge", [DVec3::new(-1.0, 0.0, 1e-2), DVec3::new(1.0, 0.0, 1e-2), DVec3::new(0.0, 1.0, 1e-2)]),
        ("grazing", [DVec3::new(1.0, 0.0, 0.01), DVec3::new(2.0, 0.5, 0.01), DVec3::new(2.0, -0.5, 0.02)]),
        ("half space", even.map(|v| DVec3::new(v.x * 30.0, v.y * 30.0, 1.0))),
    ];
    shapes.into_iter().map(|(name, v)| triangle_row(name, v)).collect()
}

fn triangle_row(name: &str, v: [DVec3; 3]) -> Row {
    // What the device sees is f32.
    let v = v.map(|x| x.as_vec3());
    let text = v.map(|x| format!("vec3({:?}, {:?}, {:?})", x.x, x.y, x.z)).join(", ");
    let glsl = format!(
        "TriangleLightSample s = triangle_light_sample(vec3(0.0), {text}, vec2(x0, x1)); y0 = s.b1; y1 = s.b2; y2 = s.pdf;"
    );
    let probe = Probe::judged(name, &glsl, 3, |r| [unit(r), unit(r)], |_, _| 0.0).files(&triangle::FILES);
    let v = v.map(|x| x.as_dvec3());
    let omega = light::triangle::solid_angle(DVec3::ZERO, v);
    let by_angle = (light::triangle::SOLID_ANGLE_MIN..=light::triangle::SOLID_ANGLE_MAX).contains(&omega);
    let mut shares = vec![0.0; 64];
    for (cell, corners) in small_triangles() {
        let c = corners.map(|[b1, b2]| v[0] + b1 * (v[1] - v[0]) + b2 * (v[2] - v[0]));
        shares[cell] = if by_angle { light::triangle::solid_angle(DVec3::ZERO, c) / omega } else { 1.0 / 64.0 };
    }
    let cell = Box::new(|y: &[f32]| small_triangle(f64::from(y[0]), f64::from(y[1])));
    Row { name: format!("light triangle {name}"), probe, cell, shares, pdf_at: 2, solid_angle: omega }
}

/// Number of the small triangle, of 64 in 8 strips, that holds the weights.
fn small_triangle(b1: f64, b2: f64) -> usize {
    let i = ((8.0 * b1) as usize).min(7);
    // Strip i has 8 - i triangles that stand and 7 - i that hang.
    let j = ((8.0 * b2) as usize).min(7 - i);
    let hangs = (8.0 * b1).fract() + (8.0 * b2 - j as f64) > 1.0 && i + j < 7;
    i * (16 - i) + 2 * j + usize::from(hangs)
}

/// Every small triangle with its corners' weights.
fn small_triangles() -> Vec<(usize, [[f64; 2]; 3])> {
    let at = |i: usize, j: usize| [i as f64 / 8.0, j as f64 / 8.0];
    let mut all = Vec::new();
    for i in 0..8 {
        for j in 0..8 - i {
            let first = i * (16 - i) + 2 * j;
            all.push((first, [at(i, j), at(i + 1, j), at(i, j + 1)]));
            if i + j < 7 {
                all.push((first + 1, [at(i + 1, j + 1), at(i + 1, j), at(i, j + 1)]));
            }
        }
    }
    all
}

fn spheres() -> Vec<Row> {
    sphere::SEEN.iter().map(|&(name, center, radius)| sphere_row(name, center, radius)).collect()
}

/// From the origin: 8 x 8 cells of the cone, equal in height and in turn.
fn sphere_row(name: &str, center: DVec3, radius: f64) -> Row {
    let (center, radius) = (center.as_vec3(), radius as f32);
    let glsl = format!(
        "SphereLightSample s = sphere_light_sample(vec3(0.0), vec3({:?}, {:?}, {:?}), {radius:?}, vec2(x0, x1)); \
         y0 = s.wi.x; y1 = s.wi.y; y2 = s.wi.z; y3 = s.pdf;",
        center.x, center.y, center.z
    );
    let probe = Probe::judged(name, &glsl, 4, |r| [unit(r), unit(r)], |_, _| 0.0).files(&sphere::FILES);
    let solid_angle = light::sphere::solid_angle(DVec3::ZERO, center.as_dvec3(), radius.into());
    cone_row(format!("light sphere {name}"), probe, center.as_dvec3().normalize(), solid_angle)
}

/// Suns of half angles from 1e-3 rad to a hemisphere.
fn suns() -> Vec<Row> {
    let row = |(name, half_angle): (&str, f64)| {
        let (axis, h) = (DVec3::new(0.48, -0.64, 0.6).as_vec3(), light::spot::one_minus_cos(half_angle) as f32);
        let glsl = format!(
            "vec3 wi = sun_direction(vec3({:?}, {:?}, {:?}), {h:?}, vec2(x0, x1)); y0 = wi.x; y1 = wi.y; y2 = wi.z; \
             y3 = uniform_cone_pdf({h:?});",
            axis.x, axis.y, axis.z
        );
        let probe = Probe::judged(name, &glsl, 4, |r| [unit(r), unit(r)], |_, _| 0.0)
            .files(&["light/sun.glsl"])
            .define("HAS_LIGHT_SUN", 0);
        cone_row(format!("light sun {name}"), probe, axis.as_dvec3().normalize(), TAU * f64::from(h))
    };
    [("small", 1e-3), ("of the sky", 4.65e-3), ("half the sky", 0.5 * PI)].map(row).into()
}

/// Uniform in the cone about `axis`: 8 x 8 cells, equal in height and in turn.
fn cone_row(name: String, probe: Probe, axis: DVec3, solid_angle: f64) -> Row {
    let (t, b) = axis.any_orthonormal_pair();
    let cell = Box::new(move |y: &[f32]| {
        let wi = vector(y).normalize();
        let (z, x, y) = (wi.dot(axis), wi.dot(t), wi.dot(b));
        // 1 - cos, from the sine where cos is near 1.
        let height = if z > 0.0 { (x * x + y * y) / (1.0 + z) } else { 1.0 - z };
        let ring = (8.0 * height * TAU / solid_angle) as usize;
        ring.min(7) * 8 + ((8.0 * (0.5 + y.atan2(x) / TAU)) as usize).min(7)
    });
    Row { name, probe, cell, shares: vec![1.0 / 64.0; 64], pdf_at: 3, solid_angle }
}

fn discs() -> Vec<Row> {
    disc::SEEN.iter().map(|&(name, center, normal, radius)| disc_row(name, center, normal, radius)).collect()
}

/// From the origin: 8 rings and 8 sectors, equal in area.
fn disc_row(name: &str, center: DVec3, normal: DVec3, radius: f64) -> Row {
    let x = normal.any_orthonormal_vector();
    let (x, y) = ((radius * x).as_vec3(), (radius * normal.cross(x)).as_vec3());
    let center = center.as_vec3();
    let text = [center, x, y].map(|v| format!("vec3({:?}, {:?}, {:?})", v.x, v.y, v.z)).join(", ");
    let glsl = format!(
        "DiscLightSample s = disc_light_sample(vec3(0.0), {text}, vec2(x0, x1)); \
         vec3 q = s.wi * s.distance; y0 = q.x; y1 = q.y; y2 = q.z; y3 = s.pdf;"
    );
    let probe = Probe::judged(name, &glsl, 4, |r| [unit(r), unit(r)], |_, _| 0.0).files(&disc::FILES);
    let (center, x, y) = (center.as_dvec3(), x.as_dvec3(), y.as_dvec3());
    let seen = light::disc::Disc { center, x, y };
    let solid_angle = light::disc::solid_angle(DVec3::ZERO, &seen);
    let cell = Box::new(move |out: &[f32]| {
        let q = (vector(out) - center) / (radius * radius);
        let (a, b) = (q.dot(x), q.dot(y));
        let ring = ((8.0 * (a * a + b * b)) as usize).min(7);
        ring * 8 + ((8.0 * (0.5 + b.atan2(a) / TAU)) as usize).min(7)
    });
    Row { name: format!("light disc {name}"), probe, cell, shares: vec![1.0 / 64.0; 64], pdf_at: 3, solid_angle }
}

/// Four parts of each cell of the image, equal in solid angle.
fn sky_cells() -> Row {
    let glsl = "SkySample s = sky_sample(n0, n1, vec2(x2, x3)); y0 = s.wi.x; y1 = s.wi.y; y2 = s.wi.z; y3 = s.pdf;";
    let words = |r: &mut Inputs| [f32::from_bits(r.word()), f32::from_bits(r.word()), unit(r), unit(r)];
    let probe = sky::with_sky(Probe::judged("sky", glsl, 4, words, |_, _| 0.0), 0);
    let view = sky::image();
    let (width, height) = (view.sky.width as usize, view.sky.height as usize);
    let share =
        |k: usize| f64::from(view.texels[k / 4].cell_pdf) * 0.25 * cell_solid_angle(k / 4 / width, width, height);
    let shares = (0..4 * width * height).map(share).collect();
    let cell = Box::new(move |y: &[f32]| {
        let (x, row) = view.position(vector(y));
        let (i, j) = ((x as usize).min(width - 1), (row as usize).min(height - 1));
        let cos = |row: f64| (PI * row / height as f64).cos();
        let is_late = cos(row) < 0.5 * (cos(j as f64) + cos(j as f64 + 1.0));
        4 * (j * width + i) + 2 * usize::from(is_late) + usize::from(x.fract() >= 0.5)
    });
    Row { name: "light sky".into(), probe, cell, shares, pdf_at: 3, solid_angle: 4.0 * PI }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_triangles_tile_the_triangle() {
        let all = small_triangles();
        assert_eq!(all.len(), 64);
        let mut seen = [false; 64];
        for (cell, c) in all {
            let middle = [0, 1].map(|k| (c[0][k] + c[1][k] + c[2][k]) / 3.0);
            assert_eq!(small_triangle(middle[0], middle[1]), cell, "{c:?}");
            seen[cell] = true;
        }
        assert!(seen.iter().all(|s| *s));
    }
}
