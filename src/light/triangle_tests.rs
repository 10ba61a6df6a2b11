use std::f64::consts::PI;

use super::*;
use crate::light::integrals::polygon_irradiance;
use crate::metric::stats::chi_square_test;

const N: u32 = 256;

/// Stratified points of the unit square.
fn square() -> impl Iterator<Item = [f64; 2]> {
    (0..N * N).map(|i| [f64::from(i / N) + 0.5, f64::from(i % N) + 0.5].map(|x| x / f64::from(N)))
}

/// Triangles of many sizes, shapes and places about the origin: (name, vertices).
fn triangles() -> Vec<(String, [DVec3; 3])> {
    let shapes = [
        ("even", [DVec3::new(-0.5, -0.4, 0.0), DVec3::new(0.6, -0.3, 0.0), DVec3::new(0.0, 0.7, 0.0)]),
        ("sliver", [DVec3::new(-1.0, 0.0, 0.0), DVec3::new(1.0, 1e-3, 0.0), DVec3::new(0.9, -1e-3, 0.0)]),
        ("tilted", [DVec3::new(-0.5, -0.4, 0.3), DVec3::new(0.6, -0.3, -0.2), DVec3::new(0.0, 0.7, 0.4)]),
        ("right", [DVec3::new(0.0, 0.0, 0.0), DVec3::new(1.0, 0.0, 0.0), DVec3::new(0.0, 1.0, 0.0)]),
    ];
    let mut all = Vec::new();
    for (name, v) in shapes {
        for size in [1e-6, 1e-3, 0.03, 1.0, 10.0, 1e4] {
            for offset in [DVec3::new(0.2, 0.1, 1.0), DVec3::new(1.5, -0.2, 1.0)] {
                all.push((format!("{name} x {size} at {offset}"), v.map(|x| x * size + offset)));
            }
        }
    }
    all
}

#[test]
fn solid_angles_add_up() {
    let octant = [DVec3::X, DVec3::Y, DVec3::Z];
    assert!((solid_angle(DVec3::ZERO, octant) - PI / 2.0).abs() < 1e-14);
    // The faces of a tetrahedron fill the sphere from inside.
    let t = [
        DVec3::new(1.0, 1.0, 1.0),
        DVec3::new(-1.0, -1.0, 1.0),
        DVec3::new(-1.0, 1.0, -1.0),
        DVec3::new(1.0, -1.0, -1.0),
    ];
    let p = DVec3::new(0.2, -0.1, 0.15);
    let faces = [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]];
    let sum: f64 = faces.iter().map(|f| solid_angle(p, f.map(|i| t[i]))).sum();
    assert!((sum - 4.0 * PI).abs() < 1e-13);
    // Small and far: area cos / d^2.
    let far = octant.map(|v| v * 1e-6 + DVec3::splat(1.0));
    assert!((solid_angle(DVec3::ZERO, far) / (0.5 * 3f64.sqrt() * 1e-12 / 3.0) - 1.0).abs() < 1e-5);
    // In its plane: nothing outside, a hemisphere inside.
    let flat = [DVec3::ZERO, DVec3::X, DVec3::Y];
    assert_eq!(solid_angle(DVec3::new(2.0, 0.0, 0.0), flat), 0.0);
    assert!((solid_angle(DVec3::new(0.2, 0.2, 0.0), flat) - 2.0 * PI).abs() < 1e-14);
}

#[test]
fn samples_lie_on_the_triangle_and_pdf_agrees() {
    for (name, v) in triangles() {
        for u in square().step_by(61).chain([[0.0, 0.0], [1.0 - 1e-9, 0.0], [0.0, 1.0 - 1e-9], [1.0 - 1e-9; 2]]) {
            let s = sample(DVec3::ZERO, v, u);
            let point = v[0] + s.b1 * (v[1] - v[0]) + s.b2 * (v[2] - v[0]);
            assert!(s.b1 >= 0.0 && s.b2 >= 0.0 && s.b1 + s.b2 <= 1.0 + 1e-12, "{name} {u:?}");
            // Arvo's angles lose about eps/omega of the direction.
            let bound = 1e-9 + 1e-15 / solid_angle(DVec3::ZERO, v).max(1e-6);
            assert!(
                (point.normalize() - s.wi).length() < bound,
                "{name} {u:?} {}",
                (point.normalize() - s.wi).length()
            );
            assert!((s.distance / point.length() - 1.0).abs() < 1e-9, "{name} {u:?}");
            assert!((pdf(DVec3::ZERO, v, s.wi, s.distance) / s.pdf - 1.0).abs() < 1e-9, "{name} {u:?}");
        }
    }
}

#[test]
fn irradiance_is_lamberts() {
    let mut branches = [0, 0];
    for (name, v) in triangles() {
        let omega = solid_angle(DVec3::ZERO, v);
        branches[usize::from(is_sampled_by_solid_angle(omega))] += 1;
        for n in [DVec3::Z, DVec3::new(0.6, 0.0, 0.8)] {
            let estimate = |u| {
                let s = sample(DVec3::ZERO, v, u);
                if s.pdf > 0.0 { s.wi.dot(n).max(0.0) / s.pdf } else { 0.0 }
            };
            let mean = square().map(estimate).sum::<f64>() / f64::from(N * N);
            // Lambert's sum of edges cancels for a small triangle; that one is seen under a single cosine.
            let middle = ((v[0] + v[1] + v[2]) / 3.0).normalize();
            let is_small = (v[1] - v[0]).length() < 1e-4;
            let exact = if is_small { omega * middle.dot(n) } else { polygon_irradiance(DVec3::ZERO, n, &v) };
            // A huge triangle seen by area sampling has a variance that N^2 points do not beat.
            if exact > 0.0 && v[0].length() < 1e3 {
                assert!((mean / exact - 1.0).abs() < 2e-3, "{name} n {n}: {mean} {exact} omega {omega}");
            }
        }
    }
    assert!(branches[0] > 5 && branches[1] > 5, "{branches:?}");
}

#[test]
fn directions_are_uniform_in_solid_angle() {
    for (name, v) in triangles() {
        if !is_sampled_by_solid_angle(solid_angle(DVec3::ZERO, v)) {
            continue;
        }
        // 16 cells of the triangle; a point's cell from its weights, the cell's share from its own solid angle.
        let mut observed = [0.0; 16];
        let mut seed = 12345u64;
        let mut random = || {
            seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (seed >> 40) as f64 / 16777216.0
        };
        let count = 40_000;
        for _ in 0..count {
            let s = sample(DVec3::ZERO, v, [random(), random()]);
            observed[cell_of(s.b1, s.b2)] += 1.0;
        }
        let mut expected = [0.0; 16];
        for i in 0..4 {
            for j in 0..4 - i {
                let at =
                    |a: usize, b: usize| v[0] + (v[1] - v[0]) * (a as f64 / 4.0) + (v[2] - v[0]) * (b as f64 / 4.0);
                let mut put = |c: [DVec3; 3], b: (f64, f64)| {
                    let share = solid_angle(DVec3::ZERO, c) / solid_angle(DVec3::ZERO, v);
                    expected[cell_of(b.0, b.1)] = f64::from(count) * share;
                };
                let (x, y) = (i as f64 / 4.0, j as f64 / 4.0);
                put([at(i, j), at(i + 1, j), at(i, j + 1)], (x + 0.05, y + 0.05));
                if i + j < 3 {
                    put([at(i + 1, j + 1), at(i + 1, j), at(i, j + 1)], (x + 0.2, y + 0.2));
                }
            }
        }
        assert!((expected.iter().sum::<f64>() / f64::from(count) - 1.0).abs() < 1e-9, "{name}");
        // 24 triangles at a level of 1e-3 together.
        let test = chi_square_test(&observed, &expected, 5.0);
        assert!(test.p > 4e-5, "{name}: {test:?} {observed:?} {expected:?}");
    }
}

/// Number of the small triangle, of 16, that holds the weights.
fn cell_of(b1: f64, b2: f64) -> usize {
    let (i, j) = (((4.0 * b1) as usize).min(3), ((4.0 * b2) as usize).min(3));
    let (i, j) = if i + j > 3 { (i.min(3 - j.min(3)), j) } else { (i, j) };
    let is_upper = (4.0 * b1 - i as f64) + (4.0 * b2 - j as f64) > 1.0 && i + j < 3;
    // Row i of a triangle of side 4 has 2 (4 - i) - 1 cells.
    (0..i).map(|k| 2 * (4 - k) - 1).sum::<usize>() + 2 * j + usize::from(is_upper)
}

#[test]
fn edge_on_and_degenerate_triangles_give_no_sample_and_no_nan() {
    let flat = [DVec3::ZERO, DVec3::X, DVec3::Y];
    let line = [DVec3::Z, DVec3::Z * 2.0, DVec3::Z * 3.0];
    for (p, v) in [
        (DVec3::new(2.0, 0.3, 0.0), flat),
        (DVec3::ZERO, flat),
        (DVec3::new(0.5, 0.0, 0.0), flat),
        (DVec3::ZERO, line),
        (DVec3::X, [DVec3::Z; 3]),
    ] {
        for u in square().step_by(997) {
            let s = sample(p, v, u);
            assert!(s.wi.is_finite() && s.pdf == 0.0 && s.distance.is_finite(), "{p} {v:?} {s:?}");
        }
    }
}
