//! Placed meshes beside the same triangles flat: rays a second, bytes and build time; then a million placements.
//!
//! Generated: a field of side x side bumpy tori of 256 triangles, each turned, scaled and tipped, on a plane; seen from above its edge.
//! 128 x 128 of them (4.2 million triangles) fit flat; 1000 x 1000 (256 million) do not. Rays are those of `bench_rays`: 2^18 primary
//! ones, and cosine bounces from where they hit. Rounds alternate; medians of rates and of the rounds' own quotients.

use std::f32::consts::TAU;
use std::time::Instant;

use glam::{DAffine3, DQuat, DVec3, Vec3};
use rayon::prelude::*;

use super::bench_rays::{median, unit};
use crate::bvh::tracer::{Question, RayRecord, Tracer};
use crate::bvh::traverse::{self, Geometry, NONE, Ray};
use crate::bvh::two_level::{Placement, build_two_level_unchecked};
use crate::bvh::{Node4, Primitives};
use crate::error::Error;
use crate::gpu::Device;
use crate::integrator::{Instancing, Settings};
use crate::prepare::records::TriangleRecord;
use crate::prepare::{self, Prepared};
use crate::reference::known::{camera, lambert};
use crate::scene::{Instance, Mesh, Scene, Shape};

const SIDE: usize = 512;
/// Tori along a side: what fits flat, and a million.
const SIDES: [usize; 2] = [128, 1000];

/// One class of rays on one scene.
#[derive(Clone, Debug, serde::Serialize)]
pub struct PlacedBench {
    pub device: String,
    pub placements: usize,
    pub triangles: u64,
    pub unique_triangles: usize,
    pub class: &'static str,
    #[serde(rename = "placed_Mrays_ps")]
    pub placed_mrays_ps: f64,
    /// 0 where flat geometry does not fit.
    #[serde(rename = "flat_Mrays_ps")]
    pub flat_mrays_ps: f64,
    /// Placed over flat: median of the rounds' own quotients.
    pub ratio: f64,
    pub hits: usize,
    /// Tables of the traversal: nodes, triangles, instances.
    pub placed_bytes: usize,
    pub flat_bytes: usize,
    pub bytes_a_placement: f64,
    /// Both levels, all threads, from meshes and matrices.
    pub build_s: f64,
}

pub fn run(device: &Device, rounds: usize) -> Result<Vec<PlacedBench>, Error> {
    let mut rows = Vec::new();
    for side in SIDES {
        let scene = field(side);
        let placed = prepared(&scene, Instancing::Always)?;
        let flat = (side == SIDES[0]).then(|| prepared(&scene, Instancing::Never)).transpose()?;
        rows.extend(bench(device, &placed, flat.as_ref(), rounds)?);
    }
    Ok(rows)
}

fn prepared(scene: &Scene, instancing: Instancing) -> Result<Prepared, Error> {
    let settings = Settings { instancing, ..Settings::default() };
    prepare::prepare(scene, &settings).map_err(|e| Error::Scene(e.to_string()))
}

fn bench(
    device: &Device,
    placed: &Prepared,
    flat: Option<&Prepared>,
    rounds: usize,
) -> Result<Vec<PlacedBench>, Error> {
    let failed = |e: crate::bvh::tracer::TraceError| Error::Shader(e.to_string());
    let g = placed.geometry();
    let primary: Vec<Ray> = (0..SIDE * SIDE).map(camera_ray).collect();
    let bounced = bounced(&g, &primary);
    let on_placed = Tracer::new(device, &g).map_err(failed)?;
    let flat_geometry = flat.map(Prepared::geometry);
    let on_flat = flat_geometry.map(|g| Tracer::new(device, &g)).transpose().map_err(failed)?;
    let build_s = build_time(placed);
    let placements = placed.instances.len() - 1;
    let triangles = placed.instances[1..].iter().map(|m| placed.mesh_triangles(m).len() as u64).sum::<u64>();
    let mut rows = Vec::new();
    for (class, rays) in [("primary", &primary), ("bounce 1", &bounced)] {
        let records: Vec<RayRecord> = rays
            .iter()
            .map(|r| RayRecord { o: r.o, t_max: r.t_max, d: r.d, primitive: NONE, ..Default::default() })
            .collect();
        let batch = on_placed.batch(Question::Closest, &records).map_err(failed)?;
        let flat_batch = on_flat.as_ref().map(|t| t.batch(Question::Closest, &records)).transpose().map_err(failed)?;
        // The first dispatch holds the driver's own compilation.
        batch.run()?;
        flat_batch.as_ref().map(|b| b.run()).transpose()?;
        let (mut rate, mut flat_rate, mut ratio) = (Vec::new(), Vec::new(), Vec::new());
        for _ in 0..rounds {
            let time = batch.run()?.as_secs_f64();
            rate.push(rays.len() as f64 / time / 1e6);
            if let Some(b) = &flat_batch {
                let flat_time = b.run()?.as_secs_f64();
                flat_rate.push(rays.len() as f64 / flat_time / 1e6);
                ratio.push(flat_time / time);
            }
        }
        let placed_bytes = bytes(&g);
        let one_copy = size_of::<TriangleRecord>() * placed.triangles.len();
        let median_or_0 = |v: Vec<f64>| if v.is_empty() { 0.0 } else { median(v) };
        rows.push(PlacedBench {
            device: device.info().title(),
            placements,
            triangles,
            unique_triangles: placed.triangles.len(),
            class,
            placed_mrays_ps: median(rate),
            flat_mrays_ps: median_or_0(flat_rate),
            ratio: median_or_0(ratio),
            hits: batch.hits()?.iter().filter(|h| h.kind != NONE).count(),
            placed_bytes,
            flat_bytes: flat.map_or(0, |p| bytes(&p.geometry())),
            bytes_a_placement: (placed_bytes - one_copy) as f64 / placements as f64,
            build_s,
        });
    }
    Ok(rows)
}

fn bytes(g: &Geometry) -> usize {
    size_of::<Node4>() * g.bvh.nodes.len() + size_of_val(g.triangles) + size_of_val(g.instances)
}

/// Median of three builds from the records' own matrices and triangles.
fn build_time(p: &Prepared) -> f64 {
    let first = p.bvh.flat_triangle_count();
    let corners: Vec<[[f32; 3]; 3]> = p.triangles[first..].iter().map(|t| [t.v0, t.v1, t.v2]).collect();
    let placements: Vec<Placement> =
        p.instances[1..].iter().map(|m| Placement { mesh: 0, to_world: m.to_world() }).collect();
    let time = |_| {
        let start = Instant::now();
        build_two_level_unchecked(&Primitives::default(), &[&corners], &placements).expect("it was built before");
        start.elapsed().as_secs_f64()
    };
    median((0..3).map(time).collect())
}

/// The camera stands at the origin of all rays.
fn camera_ray(i: usize) -> Ray {
    let (x, y) = ((i % SIDE) as f32 + unit(i, 1), (i / SIDE) as f32 + unit(i, 2));
    let (x, y) = (2.0 * x / SIDE as f32 - 1.0, 1.0 - 2.0 * y / SIDE as f32);
    let d = Vec3::new(0.6 * x, 0.35 * y - 0.4, -1.0).normalize();
    Ray { o: [0.0; 3], d: d.to_array(), t_max: f32::INFINITY }
}

/// Cosine-distributed directions from where the rays hit, begun a little beside the surface.
fn bounced(g: &Geometry, rays: &[Ray]) -> Vec<Ray> {
    let bounce_of = |(i, ray): (usize, &Ray)| {
        let h = traverse::closest_from(g, ray, 0.0, NONE);
        let t = g.triangles.get(h.slot as usize)?;
        let to_world = g.instances[h.instance as usize].to_world();
        let [a, b, c] = [t.v0, t.v1, t.v2].map(|v| to_world.transform_point3(Vec3::from(v).as_dvec3()).as_vec3());
        let n = (b - a).cross(c - a).normalize();
        let n = if n.dot(Vec3::from(ray.d)) > 0.0 { -n } else { n };
        let p = a + (b - a) * h.b1 + (c - a) * h.b2 + n * 1e-3;
        let (z, phi) = (1.0 - 2.0 * unit(i, 10), TAU * unit(i, 11));
        let r = (1.0 - z * z).sqrt();
        let d = (n + Vec3::new(r * phi.cos(), r * phi.sin(), z)).normalize_or(n);
        Some(Ray { o: p.to_array(), d: d.to_array(), t_max: f32::INFINITY })
    };
    rays.par_iter().enumerate().filter_map(bounce_of).collect()
}

/// 16 x 8 quads.
fn torus() -> Mesh {
    let vertex = |k: u32| {
        let (u, v) = ((k / 8) as f32 / 16.0 * TAU, (k % 8) as f32 / 8.0 * TAU);
        let r = 0.3 + (0.14 + 0.03 * (3.0 * u).sin()) * v.cos();
        [r * u.cos(), 0.14 * v.sin(), r * u.sin()]
    };
    let at = |i: u32, j: u32| i % 16 * 8 + j % 8;
    let quad = |k: u32| {
        let (i, j) = (k / 8, k % 8);
        let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        [[a, b, c], [a, c, d]]
    };
    Mesh {
        name: "torus".to_owned(),
        positions: (0..128).map(vertex).collect(),
        triangles: (0..128).flat_map(quad).collect(),
        ..Mesh::default()
    }
}

fn field(side: usize) -> Scene {
    let instance = |k: usize| {
        let turn = DQuat::from_rotation_y(f64::from(TAU * unit(k, 3))) * DQuat::from_rotation_x(f64::from(unit(k, 4)));
        let scale = DVec3::splat(0.7 + 0.6 * f64::from(unit(k, 5)));
        let (row, column) = ((k / side) as f64, (k % side) as f64);
        let place = DVec3::new(column - 0.5 * side as f64, 0.2 * f64::from(unit(k, 6)), -row);
        Instance {
            name: String::new(),
            shape: Shape::Mesh(0),
            to_world: DAffine3::from_scale_rotation_translation(scale, turn, place),
            material: 0,
        }
    };
    let eye = DVec3::new(0.0, 6.0, 4.0);
    Scene {
        name: "field".to_owned(),
        camera: camera(eye, eye + DVec3::new(0.0, -0.4, -1.0), 0.7),
        meshes: vec![torus()],
        materials: vec![lambert(DVec3::splat(0.5))],
        instances: (0..side * side).map(instance).collect(),
        ..Scene::default()
    }
}
