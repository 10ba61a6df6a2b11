//! Rays a second of a device beside scalar Rust with rayon on the very same rays, and triangles a second of the build.
//!
//! Generated scene, fixed seeds: 98 bumpy tori in a room, 401,420 triangles; 2^18 rays a class. Rounds alternate between device
//! and Rust, and the median of the rounds' ratios is told: this machine's clock drifts by more than the differences. The clock
//! holds submit and wait, not the upload. Hits are compared one by one.

use std::f32::consts::TAU;
use std::time::Instant;

use glam::Vec3;
use rayon::prelude::*;

use crate::bvh::tracer::{HitRecord, Question, RayRecord, TraceError, Tracer};
use crate::bvh::traverse::{self, Geometry, NONE, Ray};
use crate::bvh::{self, Bvh, Primitives};
use crate::gpu::Device;
use crate::prepare::records::TriangleRecord;

/// Rounds that the README's figures were measured with.
pub const ROUNDS: usize = 9;
const SIDE: usize = 512;
const EYE: Vec3 = Vec3::new(0.0, 6.0, 19.0);
const LAMP: Vec3 = Vec3::new(3.0, 9.5, 2.0);

/// One line of the bench; medians over the rounds.
#[derive(Clone, Debug, serde::Serialize)]
pub struct RayBench {
    pub device: String,
    pub class: &'static str,
    #[serde(rename = "throughput_Mrays_ps")]
    pub throughput_mrays_ps: f64,
    /// The same for scalar Rust on all cores.
    #[serde(rename = "scalar_Mrays_ps")]
    pub scalar_mrays_ps: f64,
    /// Median of the rounds' own quotients.
    pub ratio: f64,
    pub rays: usize,
    pub hits: usize,
    /// Rays whose hit differs from scalar Rust's in primitive or distance.
    pub mismatches: usize,
}

#[derive(Clone, Debug, serde::Serialize)]
pub struct BuildBench {
    pub triangles: usize,
    pub threads: usize,
    pub build_s: f64,
    #[serde(rename = "throughput_Mtriangles_ps")]
    pub throughput_mtriangles_ps: f64,
    pub nodes: usize,
    pub depth: u32,
}

/// Median of `rounds` builds of the bench's scene, without the validation that debug assertions add.
pub fn build(rounds: usize) -> BuildBench {
    let corners = scene();
    let mut times = Vec::new();
    let mut tree = Bvh::default();
    for _ in 0..rounds {
        let start = Instant::now();
        tree = bvh::build_unchecked(&Primitives { triangles: &corners, ..Primitives::default() })
            .expect("the bench's scene is small")
            .0;
        times.push(start.elapsed().as_secs_f64());
    }
    let build_s = median(times);
    BuildBench {
        triangles: corners.len(),
        threads: rayon::current_num_threads(),
        build_s,
        throughput_mtriangles_ps: corners.len() as f64 / build_s / 1e6,
        nodes: tree.nodes.len(),
        depth: tree.depth,
    }
}

/// Primary, bounce 1, bounce 2 and shadow rays on `device` and in scalar Rust.
pub fn rays(device: &Device, rounds: usize) -> Result<Vec<RayBench>, TraceError> {
    let corners = scene();
    let (bvh, _) =
        bvh::build(&Primitives { triangles: &corners, ..Primitives::default() }).expect("the bench's scene is small");
    let record = |&i: &u32| {
        let [v0, v1, v2] = corners[i as usize];
        TriangleRecord { v0, v1, v2, face: i, ..Default::default() }
    };
    let triangles: Vec<_> = bvh.triangle_order.iter().map(record).collect();
    let g = Geometry { bvh: &bvh, triangles: &triangles, spheres: &[], discs: &[], instances: &[] };
    let tracer = Tracer::new(device, &g)?;

    let primary: Vec<Ray> = (0..SIDE * SIDE).map(camera_ray).collect();
    let bounce1 = bounced(&g, &primary, 1);
    let bounce2 = bounced(&g, &bounce1, 2);
    let shadow = shadow_rays(&g, &primary);
    let classes = [
        ("primary", Question::Closest, primary),
        ("bounce 1", Question::Closest, bounce1),
        ("bounce 2", Question::Closest, bounce2),
        ("shadow", Question::Any, shadow),
    ];
    classes
        .into_iter()
        .map(|(class, question, rays)| bench_class(device, (&tracer, &g), class, question, &rays, rounds))
        .collect()
}

fn bench_class(
    device: &Device,
    (tracer, g): (&Tracer, &Geometry),
    class: &'static str,
    question: Question,
    rays: &[Ray],
    rounds: usize,
) -> Result<RayBench, TraceError> {
    let records: Vec<RayRecord> = rays
        .iter()
        .map(|r| RayRecord { o: r.o, t_max: r.t_max, d: r.d, primitive: NONE, ..Default::default() })
        .collect();
    let batch = tracer.batch(question, &records)?;
    // The first dispatch holds the driver's own compilation.
    batch.run()?;
    let (mut device_rate, mut scalar_rate, mut ratio) = (Vec::new(), Vec::new(), Vec::new());
    let mut scalar = Vec::new();
    for _ in 0..rounds {
        let on_device = batch.run()?.as_secs_f64();
        let start = Instant::now();
        scalar = rays.par_chunks(1024).flat_map_iter(|part| part.iter().map(|r| scalar_hit(g, question, r))).collect();
        let in_rust = start.elapsed().as_secs_f64();
        device_rate.push(rays.len() as f64 / on_device / 1e6);
        scalar_rate.push(rays.len() as f64 / in_rust / 1e6);
        ratio.push(in_rust / on_device);
    }
    let hits: Vec<(u32, u32, u32)> = batch.hits()?.iter().map(words).collect();
    let no_hit = if question == Question::Any { 0 } else { NONE };
    Ok(RayBench {
        device: device.info().title(),
        class,
        throughput_mrays_ps: median(device_rate),
        scalar_mrays_ps: median(scalar_rate),
        ratio: median(ratio),
        rays: rays.len(),
        hits: hits.iter().filter(|h| h.0 != no_hit).count(),
        mismatches: hits.iter().zip(&scalar).filter(|(a, b)| a != b).count(),
    })
}

fn words(h: &HitRecord) -> (u32, u32, u32) {
    (h.kind, h.primitive, h.t.to_bits())
}

fn scalar_hit(g: &Geometry, question: Question, ray: &Ray) -> (u32, u32, u32) {
    if question == Question::Any {
        return (u32::from(traverse::any(g, ray, NONE)), NONE, 0);
    }
    let h = traverse::closest_from(g, ray, 0.0, NONE);
    (h.kind, h.primitive, h.t.to_bits())
}

pub(super) fn median(mut values: Vec<f64>) -> f64 {
    values.sort_unstable_by(f64::total_cmp);
    values[values.len() / 2]
}

/// A word from two numbers (Wellons' lowbias32 on their mix): no stream to keep, so rays are the same on any number of threads.
pub(super) fn unit(i: usize, k: u32) -> f32 {
    let mut x = (i as u32).wrapping_mul(0x9e37_79b9) ^ k.wrapping_mul(0x85eb_ca6b);
    x = (x ^ x >> 16).wrapping_mul(0x7feb_352d);
    x = (x ^ x >> 15).wrapping_mul(0x846c_a68b);
    ((x ^ x >> 16) >> 8) as f32 / 16_777_216.0
}

fn camera_ray(i: usize) -> Ray {
    let (x, y) = ((i % SIDE) as f32 + unit(i, 1), (i / SIDE) as f32 + unit(i, 2));
    let (x, y) = (2.0 * x / SIDE as f32 - 1.0, 1.0 - 2.0 * y / SIDE as f32);
    let d = Vec3::new(0.5 * x, 0.5 * y - 0.2, -1.0).normalize();
    Ray { o: EYE.to_array(), d: d.to_array(), t_max: f32::INFINITY }
}

/// Point and normal toward the ray, for rays that hit.
fn surface(g: &Geometry, ray: &Ray) -> Option<(Vec3, Vec3)> {
    let h = traverse::closest_from(g, ray, 0.0, NONE);
    let t = g.triangles.get(h.slot as usize)?;
    let [a, b, c] = [t.v0, t.v1, t.v2].map(Vec3::from);
    let n = (b - a).cross(c - a).normalize();
    let n = if n.dot(Vec3::from(ray.d)) > 0.0 { -n } else { n };
    Some((a + (b - a) * h.b1 + (c - a) * h.b2 + n * 1e-4, n))
}

/// Cosine-distributed directions from where the rays hit.
fn bounced(g: &Geometry, rays: &[Ray], bounce: u32) -> Vec<Ray> {
    let bounce_of = |(i, ray): (usize, &Ray)| {
        let (p, n) = surface(g, ray)?;
        let (z, phi) = (1.0 - 2.0 * unit(i, 10 * bounce), TAU * unit(i, 10 * bounce + 1));
        let r = (1.0 - z * z).sqrt();
        let d = (n + Vec3::new(r * phi.cos(), r * phi.sin(), z)).normalize_or(n);
        Some(Ray { o: p.to_array(), d: d.to_array(), t_max: f32::INFINITY })
    };
    rays.par_iter().enumerate().filter_map(bounce_of).collect()
}

fn shadow_rays(g: &Geometry, rays: &[Ray]) -> Vec<Ray> {
    let to_lamp = |ray: &Ray| {
        let (p, _) = surface(g, ray)?;
        let distance = (LAMP - p).length();
        Some(Ray { o: p.to_array(), d: ((LAMP - p) / distance).to_array(), t_max: distance })
    };
    rays.par_iter().filter_map(to_lamp).collect()
}

/// The room's 12 triangles, and 98 tori of 64 by 32 quads, tilted, with bumps.
fn scene() -> Vec<[[f32; 3]; 3]> {
    let mut triangles = Vec::new();
    let corner = |k: usize| {
        let side = |bit: usize, lo: f32, hi: f32| if k >> bit & 1 == 0 { lo } else { hi };
        [side(0, -12.0, 12.0), side(1, 0.0, 12.0), side(2, -12.0, 20.0)]
    };
    for [a, b, c, d] in [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]] {
        let [a, b, c, d] = [a, b, c, d].map(corner);
        triangles.extend([[a, b, c], [a, c, d]]);
    }
    for torus in 0..98 {
        let (row, column) = ((torus / 7) as f32, (torus % 7) as f32);
        let center = Vec3::new(3.2 * column - 9.6, 1.2 + 5.0 * unit(torus, 7), 1.5 * row - 11.0);
        let tilt =
            glam::Quat::from_rotation_x(3.0 * unit(torus, 8)) * glam::Quat::from_rotation_z(3.0 * unit(torus, 9));
        let vertex = |i: usize, j: usize| {
            let (u, v) = ((i % 64) as f32 / 64.0 * TAU, (j % 32) as f32 / 32.0 * TAU);
            let tube = 0.35 + 0.06 * (9.0 * u).sin() * (5.0 * v).cos();
            let r = 0.9 + tube * v.cos();
            (center + tilt * Vec3::new(r * u.cos(), tube * v.sin(), r * u.sin())).to_array()
        };
        for (i, j) in (0..64 * 32).map(|k| (k / 32, k % 32)) {
            let [a, b, c, d] = [vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    triangles
}
