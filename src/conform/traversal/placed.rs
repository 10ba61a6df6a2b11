//! Gate 5 for placed meshes: the whole way from a scene's instances to their records, judged by f64 brute force over every placed
//! triangle moved by the record's own matrix.
//!
//! A ray is taken into object space in f32, so a placed triangle is seen from a place beside the ray's origin: `moved` is that, as
//! src/bvh/two_level.rs derives it, and the judge allows it in place of the flat test's.

use glam::{DAffine3, DQuat, DVec3};

use super::judge::{self, EPS, Judgement, Seen, Tally, ULPS};
use super::soup::{Random, aimed_at, around};
use super::{SOUP_RAYS, trace};
use crate::bvh::brute::{self, Nearest};
use crate::bvh::tracer::{Question, TraceError};
use crate::bvh::traverse::{self, NONE, Ray};
use crate::bvh::two_level::magnitudes;
use crate::conform::report::{Gate, GateRow, is_wanted};
use crate::gpu::Device;
use crate::integrator::{Instancing, Settings};
use crate::prepare::{self, Prepared};
use crate::reference::known::{lambert, place};
use crate::scene::{Mesh, Scene, Shape};

type Outcome = Result<(bool, String, &'static str), TraceError>;

/// Size of the whole scene, and its distance from the camera.
const PLACES: &[(&str, f64, f64)] =
    &[("of size 1", 1.0, 0.0), ("of 1e-6", 1e-6, 0.0), ("of 1e6", 1e6, 0.0), ("at 1e4", 1.0, 1e4)];

pub fn run(device: &Device, filter: &str) -> Vec<GateRow> {
    let mut rows = Vec::new();
    let mut check = |name: String, check: &dyn Fn() -> Outcome| {
        if is_wanted(Gate::Traversal, &name, filter) {
            let (is_passed, evidence, bound) =
                check().unwrap_or_else(|e| (false, e.to_string(), "the device can trace"));
            rows.push(GateRow::new(Gate::Traversal, name, is_passed, evidence, bound));
        }
    };
    for &(name, size, distance) in PLACES {
        check(format!("placed soup {name}"), &|| against_brute_force(device, &World::of(&soup(size, distance))));
        check(format!("placed closed {name}"), &|| no_ray_leaves(device, &World::of(&closed(size, distance))));
        check(format!("placed spawn {name}"), &|| spawned_rays_leave(device, &World::of(&soup(size, distance))));
    }
    check("placed coincident".into(), &|| every_copy_is_enumerated(device));
    rows
}

/// One triangle in the world.
struct Corners {
    v: [DVec3; 3],
    /// Placement it belongs to; None for flat ones.
    placed: Option<DAffine3>,
}

/// Records and, by primitive number, their triangles.
struct World {
    prepared: Prepared,
    corners: Vec<Option<Corners>>,
}

impl World {
    fn of(scene: &Scene) -> World {
        let settings = Settings { instancing: Instancing::Always, ..Settings::default() };
        let prepared = prepare::prepare(scene, &settings).expect("a gate's scene is sound");
        let mut world = World { corners: Vec::new(), prepared };
        let p = &world.prepared;
        let vector = |v: [f32; 3]| DVec3::from(v.map(f64::from));
        let flat = p.flat_triangles().iter().map(|t| (t.face, [t.v0, t.v1, t.v2].map(vector), None));
        let placed = p.instances.iter().skip(1).flat_map(|m| {
            let to_world = m.to_world();
            p.triangles[p.mesh_triangles(m)].iter().map(move |t| {
                let v = [t.v0, t.v1, t.v2].map(|v| to_world.transform_point3(vector(v)));
                (t.face.wrapping_add(m.primitive_offset), v, Some(to_world))
            })
        });
        for (number, v, placed) in flat.chain(placed) {
            let number = number as usize;
            if world.corners.len() <= number {
                world.corners.resize_with(number + 1, || None);
            }
            assert!(world.corners[number].is_none(), "two triangles have the number {number}");
            world.corners[number] = Some(Corners { v, placed });
        }
        world
    }

    fn triangles(&self) -> impl Iterator<Item = (u32, &Corners)> {
        (0..).zip(&self.corners).filter_map(|(number, c)| Some((number, c.as_ref()?)))
    }

    fn see(&self, ray: &Ray, number: u32) -> Option<Seen> {
        let c = self.corners.get(number as usize)?.as_ref()?;
        let moved = |far: f64| match c.placed {
            None => ULPS * EPS * far,
            Some(to_world) => {
                let back = to_world.inverse();
                let o = DVec3::from(ray.o.map(f64::from));
                let seen = magnitudes(&back.matrix3) * (o.abs() + far) + back.translation.abs();
                // The ray's own rounding, and the test's.
                2.0 * ULPS * EPS * (magnitudes(&to_world.matrix3) * seen).length()
            }
        };
        judge::see_corners(ray, c.v, moved)
    }

    fn nearest(&self, ray: &Ray) -> Option<Nearest> {
        let mut best: Option<Nearest> = None;
        for (primitive, c) in self.triangles() {
            if let Some((t, margin)) = brute::plane_of_corners(ray, c.v)
                && margin >= 0.0
                && t > 0.0
                && t < best.map_or(f64::from(ray.t_max), |b| b.t)
            {
                best = Some(Nearest { t, primitive, margin });
            }
        }
        best
    }

    fn vertices(&self) -> Vec<DVec3> {
        self.triangles().flat_map(|(_, c)| c.v).collect()
    }
}

/// A bumpy closed sphere of 20 x 12 quads about the origin, poles included.
fn ball() -> Mesh {
    let (columns, rows) = (20u32, 12u32);
    let vertex = |i: u32, j: u32| {
        let (u, v) = (f64::from(i) / f64::from(columns) * std::f64::consts::TAU, f64::from(j) / f64::from(rows));
        let (s, c) = (v * std::f64::consts::PI).sin_cos();
        let r = 1.0 + 0.2 * (3.0 * u).sin() * s * s;
        (DVec3::new(s * u.cos(), c, s * u.sin()) * r).as_vec3().to_array()
    };
    let mut mesh = Mesh { name: "ball".to_owned(), ..Mesh::default() };
    mesh.positions.extend([vertex(0, 0), vertex(0, rows)]);
    for j in 1..rows {
        mesh.positions.extend((0..columns).map(|i| vertex(i, j)));
    }
    let at = |i: u32, j: u32| 2 + (j - 1) * columns + i % columns;
    for i in 0..columns {
        mesh.triangles.push([0, at(i + 1, 1), at(i, 1)]);
        mesh.triangles.push([1, at(i, rows - 1), at(i + 1, rows - 1)]);
        for j in 1..rows - 1 {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh
}

/// A turn, unlike scales and every second time a mirror.
fn placement(i: usize, size: f64, center: DVec3, random: &mut Random) -> DAffine3 {
    let scale = DVec3::new(0.3 + 0.7 * f64::from(random.unit()), 0.4, if i.is_multiple_of(2) { 0.5 } else { -0.9 });
    let axis = random.cube().as_dvec3().normalize_or(DVec3::Y);
    let turn = DQuat::from_axis_angle(axis, 6.0 * f64::from(random.unit()));
    DAffine3::from_scale_rotation_translation(scale * size, turn, center)
}

/// The camera stands at the origin; `far` is where the scene is.
fn far(distance: f64) -> DVec3 {
    DVec3::new(0.6, 0.48, -0.64) * distance
}

fn soup(size: f64, distance: f64) -> Scene {
    let mut random = Random(23);
    let mut s = Scene::default();
    s.meshes.push(ball());
    let cloud = |random: &mut Random| (0..120).map(|_| random.cube().to_array()).collect::<Vec<_>>();
    let triangles = (0..40).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
    s.meshes.push(Mesh { positions: cloud(&mut random), triangles, ..Mesh::default() });
    for i in 0..24 {
        let center = far(distance) + random.cube().as_dvec3() * 2.0 * size;
        let to_world = placement(i, 0.5 * size, center, &mut random);
        place(&mut s, "placed", Shape::Mesh(i % 2), to_world, lambert(DVec3::ONE));
    }
    let floor = DAffine3::from_scale_rotation_translation(
        DVec3::splat(3.0 * size),
        DQuat::from_rotation_x(-1.5),
        far(distance) - DVec3::Y * size,
    );
    place(&mut s, "floor", Shape::Rectangle, floor, lambert(DVec3::ONE));
    s
}

/// Balls apart from each other.
fn closed(size: f64, distance: f64) -> Scene {
    let mut random = Random(29);
    let mut s = Scene::default();
    s.meshes.push(ball());
    for i in 0..8 {
        let corner = DVec3::new((i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2) as f64) * 4.0 - 2.0;
        let to_world = placement(i, size, far(distance) + corner * size, &mut random);
        place(&mut s, "ball", Shape::Mesh(0), to_world, lambert(DVec3::ONE));
    }
    s
}

fn against_brute_force(device: &Device, world: &World) -> Outcome {
    let g = world.prepared.geometry();
    let rays = around(&world.vertices(), SOUP_RAYS, &mut Random(11));
    let hits = trace(device, &g, Question::Closest, &rays)?;
    let any = trace(device, &g, Question::Any, &rays)?;
    let (mut tally, mut same_bits) = (Tally::default(), 0);
    for (ray, (hit, any)) in rays.iter().zip(hits.iter().zip(&any)) {
        let see = |number: u32| world.see(ray, number);
        tally.add(judge::judge_seen(ray, &hit.hit(), world.nearest(ray), &see, &|_| false), ray, hit);
        if (any.kind == 1) != (hit.kind != NONE) {
            tally.add(Judgement::Wrong("any-hit differs from closest"), ray, hit);
        }
        same_bits += usize::from(traverse::closest_from(&g, ray, 0.0, NONE) == hit.hit());
    }
    let evidence = format!("{tally}; {same_bits} of {} equal scalar Rust to the bit", rays.len());
    Ok((tally.wrong == 0, evidence, "every hit is the f64 one, or rounding on the way to object space explains it"))
}

/// From near each ball's middle at its vertices and edges: all must hit that very ball, nearer than its far side.
fn no_ray_leaves(device: &Device, world: &World) -> Outcome {
    let g = world.prepared.geometry();
    let mut random = Random(5);
    let mut rays = Vec::new();
    for m in g.instances.iter().skip(1) {
        let to_world = m.to_world();
        for t in &g.triangles[world.prepared.mesh_triangles(m)] {
            let v = [t.v0, t.v1, t.v2].map(|v| to_world.transform_point3(DVec3::from(v.map(f64::from))));
            let origin = to_world.transform_point3(0.1 * random.cube().as_dvec3()).as_vec3();
            rays.extend(aimed_at(origin, v, &mut random));
        }
    }
    let hits = trace(device, &g, Question::Closest, &rays)?;
    let any = trace(device, &g, Question::Any, &rays)?;
    let misses = hits.iter().filter(|h| h.kind == NONE).count();
    let any_misses = any.iter().filter(|h| h.kind == 0).count();
    let scalar = rays.iter().filter(|r| traverse::closest_from(&g, r, 0.0, NONE).kind == NONE).count();
    // Balls are apart: through a crack a ray could still meet another one.
    let each = rays.len() / (g.instances.len() - 1);
    let elsewhere = hits.iter().enumerate().filter(|(k, h)| {
        let own = g.instances[1 + k / each].object;
        h.kind != NONE && g.instances[h.instance as usize].object != own
    });
    let elsewhere = elsewhere.count();
    let evidence = format!(
        "{misses} closest, {any_misses} any-hit, {scalar} scalar Rust misses, {elsewhere} met another ball, of {} rays",
        rays.len()
    );
    Ok((misses + any_misses + scalar + elsewhere == 0, evidence, "no ray leaves a closed placed mesh"))
}

/// The origin of a reflected ray lies on its side of the placed triangle in f64, and from there that triangle is not hit again.
fn spawned_rays_leave(device: &Device, world: &World) -> Outcome {
    let g = world.prepared.geometry();
    let rays = around(&world.vertices(), 4 * SOUP_RAYS, &mut Random(17));
    let spawned = trace(device, &g, Question::Spawn, &rays)?;
    let (mut behind, mut highest, mut placed, mut example) = (0, 0.0f64, 0, String::new());
    let (mut origins, mut left) = (Vec::new(), Vec::new());
    for (ray, s) in rays.iter().zip(&spawned).filter(|(_, s)| s.kind != NONE) {
        let c = world.corners[s.primitive as usize].as_ref().expect("a hit has a triangle");
        let (o, d) = ([s.t, s.b1, s.b2], DVec3::from(ray.d.map(f64::from)));
        let n = (c.v[1] - c.v[0]).cross(c.v[2] - c.v[0]).normalize();
        let side = if d.dot(n) > 0.0 { -1.0 } else { 1.0 };
        let at = DVec3::from(o.map(f64::from));
        let height = side * (at - c.v[0]).dot(n);
        // By the place in the world and in the object, as the bound is.
        let to_world = c.placed.unwrap_or(DAffine3::IDENTITY);
        let back = to_world.inverse();
        let size = (c.v[1] - c.v[0]).length().max((c.v[2] - c.v[0]).length());
        let in_object = magnitudes(&back.matrix3) * at.abs() + back.translation.abs();
        let scale = (magnitudes(&to_world.matrix3) * in_object).length() + at.length() + size;
        highest = highest.max(height / scale);
        placed += usize::from(c.placed.is_some());
        if height.is_nan() || height < 0.0 {
            behind += 1;
            example = format!(", {ray:?} spawned {o:?} {height:e} above primitive {}", s.primitive);
        }
        let w = (d - n * (2.0 * d.dot(n))).normalize().as_vec3();
        origins.push(Ray { o, d: w.to_array(), t_max: f32::INFINITY });
        left.push(s.primitive);
    }
    let again = trace(device, &g, Question::Closest, &origins)?;
    let hit_self = again.iter().zip(&left).filter(|(h, l)| h.kind != NONE && h.primitive == **l).count();
    let evidence = format!(
        "{} spawned, {placed} from placed meshes: {behind} on the wrong side, {hit_self} hit what they left; highest \
         {highest:.1e} of scale{example}",
        left.len()
    );
    // |ng|_1 <= sqrt 3 times gamma_5 twice, gamma_7 and gamma_16 of two edges that |A| |B| has turned: below 64 eps.
    let is_near = highest < 64.0 * 3f64.sqrt() * EPS;
    Ok((behind + hit_self == 0 && is_near, evidence, "none behind, none hits again, within 64 sqrt 3 eps of scale"))
}

/// Three placements at one place: going on from each hit finds every copy once, in the order of (t, primitive).
fn every_copy_is_enumerated(device: &Device) -> Outcome {
    let mut s = Scene::default();
    s.meshes.push(ball());
    for _ in 0..3 {
        let to_world = DAffine3::from_translation(DVec3::new(0.3, -0.2, -5.0));
        place(&mut s, "copy", Shape::Mesh(0), to_world, lambert(DVec3::ONE));
    }
    let world = World::of(&s);
    let g = world.prepared.geometry();
    let tracer = crate::bvh::tracer::Tracer::new(device, &g)?;
    let mut random = Random(31);
    let aim = |random: &mut Random| {
        let d = (DVec3::new(0.3, -0.2, -5.0) + 0.4 * random.cube().as_dvec3()).normalize().as_vec3();
        super::record(&Ray { o: [0.0; 3], d: d.to_array(), t_max: f32::INFINITY })
    };
    let mut records: Vec<_> = (0..1024).map(|_| aim(&mut random)).collect();
    let mut found = vec![Vec::new(); records.len()];
    for _ in 0..8 {
        for (i, hit) in tracer.trace(Question::ClosestFrom, &records)?.iter().enumerate() {
            (records[i].t_after, records[i].primitive) = (hit.t, hit.primitive);
            if hit.kind != NONE {
                found[i].push((hit.t, hit.primitive));
            }
        }
    }
    // In at the front and out at the back, each three times.
    let is_right = |f: &&Vec<(f32, u32)>| f.len() == 6 && f.windows(2).all(|w| w[0] < w[1]);
    let right = found.iter().filter(is_right).count();
    Ok((
        right == found.len(),
        format!("{right} of {} rays found 6 hits in order", found.len()),
        "each copy once, in order",
    ))
}
