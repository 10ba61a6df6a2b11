//! Gate 5: the device's traversal against brute force in f64, aimed rays at every edge and vertex of closed meshes, spawned rays.
//!
//! A difference counts as wrong unless rounding explains it: the f32 test moves a vertex by a few ulp of its distance from the
//! ray's origin, which bounds how far a barycentric weight and a distance may move (`judge`). What rounding explains is counted
//! and shown, so that a change that makes it frequent is seen.

mod judge;
mod placed;
mod soup;

use super::{Gate, GateRow};
use crate::bvh::brute;
use crate::bvh::tracer::{HitRecord, Question, RayRecord, TraceError, Tracer};
use crate::bvh::traverse::{self, Geometry, NONE, Ray};
use crate::gpu::Device;
use judge::{Judgement, Tally};
use soup::{Mesh, Random};

/// Rays for each soup.
const SOUP_RAYS: usize = 4096;

/// All rows of the gate whose name contains `filter`. A device that cannot trace fails, with its message as evidence.
pub fn run(device: &Device, filter: &str) -> Vec<GateRow> {
    type Check = fn(&Device, &Mesh) -> Result<(bool, String, &'static str), TraceError>;
    let mut rows = Vec::new();
    let mut check = |name: String, mesh: &dyn Fn() -> Mesh, check: Check| {
        if super::report::is_wanted(Gate::Traversal, &name, filter) {
            let (is_passed, evidence, bound) =
                check(device, &mesh()).unwrap_or_else(|e| (false, e.to_string(), "the device can trace"));
            rows.push(GateRow::new(Gate::Traversal, name, is_passed, evidence, bound));
        }
    };
    for (name, make) in soup::SOUPS {
        check(format!("soup {name}"), &|| Mesh::of(make()), against_brute_force);
    }
    for &(name, scale, offset) in soup::PLACES {
        check(format!("watertight sphere {name}"), &|| soup::closed_sphere(5, scale, offset), aimed_rays_hit);
        check(format!("watertight torus {name}"), &|| soup::closed_torus(96, 48, scale, offset), aimed_rays_hit);
        check(format!("spawn {name}"), &|| soup::spawn_scene(scale, offset), spawned_rays_leave);
    }
    check("quad of two triangles".into(), &soup::quad, the_diagonal_is_hit);
    check("hits in order".into(), &soup::stack_of_copies, every_hit_is_enumerated);
    check("unlike scales".into(), &soup::geometric, against_brute_force);
    check("nothing".into(), &|| Mesh::of(Default::default()), against_brute_force);
    rows.extend(placed::run(device, filter));
    rows
}

fn record(ray: &Ray) -> RayRecord {
    RayRecord { o: ray.o, t_max: ray.t_max, d: ray.d, primitive: NONE, t_after: 0.0, reserved: [0; 3] }
}

fn trace(device: &Device, g: &Geometry, question: Question, rays: &[Ray]) -> Result<Vec<HitRecord>, TraceError> {
    let records: Vec<_> = rays.iter().map(record).collect();
    Tracer::new(device, g)?.trace(question, &records)
}

const EXPLAINED: &str =
    "every hit is the f64 one, or rounding of 8 ulp of the distance explains it; any-hit agrees with closest";

fn against_brute_force(device: &Device, mesh: &Mesh) -> Result<(bool, String, &'static str), TraceError> {
    let g = mesh.geometry();
    let rays = soup::rays(mesh, SOUP_RAYS, &mut Random(11));
    let hits = trace(device, &g, Question::Closest, &rays)?;
    let any = trace(device, &g, Question::Any, &rays)?;
    let mut tally = Tally::default();
    let mut same_bits = 0;
    for (ray, (hit, any)) in rays.iter().zip(hits.iter().zip(&any)) {
        let nearest = brute::nearest(&g, ray);
        tally.add(judge::judge(&g, ray, &hit.hit(), nearest), ray, hit);
        if (any.kind == 1) != (hit.kind != NONE) {
            tally.add(Judgement::Wrong("any-hit differs from closest"), ray, hit);
        }
        same_bits += usize::from(traverse::closest_from(&g, ray, 0.0, NONE) == hit.hit());
    }
    let evidence = format!("{tally}; {same_bits} of {} equal scalar Rust to the bit", rays.len());
    Ok((tally.wrong == 0, evidence, EXPLAINED))
}

/// From inside every ray must hit; aimed at each vertex, at points on each edge, and beside them by an ulp or two.
fn aimed_rays_hit(device: &Device, mesh: &Mesh) -> Result<(bool, String, &'static str), TraceError> {
    let g = mesh.geometry();
    let rays = soup::aimed_rays(mesh, &mut Random(5));
    let hits = trace(device, &g, Question::Closest, &rays)?;
    let any = trace(device, &g, Question::Any, &rays)?;
    let misses = hits.iter().filter(|h| h.kind == NONE).count();
    let any_misses = any.iter().filter(|h| h.kind == 0).count();
    let scalar = rays.iter().filter(|r| traverse::closest_from(&g, r, 0.0, NONE).kind == NONE).count();
    let first = rays.iter().zip(&hits).find(|(_, h)| h.kind == NONE).map_or(String::new(), |(r, _)| format!(", {r:?}"));
    let evidence = format!(
        "{misses} closest, {any_misses} any-hit, {scalar} scalar Rust misses of {} rays at {} triangles{first}",
        rays.len(),
        g.triangles.len()
    );
    Ok((misses + any_misses + scalar == 0, evidence, "no ray leaves a closed mesh"))
}

/// Oblikovati issue 2146 (FIELD.md N1): a ray along the diagonal that two triangles share.
fn the_diagonal_is_hit(device: &Device, mesh: &Mesh) -> Result<(bool, String, &'static str), TraceError> {
    let ray = Ray { o: [0.0, 0.0, 10.0], d: [0.30458447, 0.30458447, -0.9024725], t_max: f32::INFINITY };
    let hit = trace(device, &mesh.geometry(), Question::Closest, &[ray])?[0];
    let p = ray.d.map(|d| f64::from(d) * f64::from(hit.t));
    let distance = ((p[0] - 3.375).powi(2) + (p[1] - 3.375).powi(2)).sqrt();
    let evidence = format!("hit {} at t = {}, {distance:.1e} from (3.375, 3.375, 0)", hit.kind != NONE, hit.t);
    Ok((hit.kind == 0 && distance < 1e-5, evidence, "hit within 1e-5"))
}

/// Going on from each hit finds every primitive on the ray once, in the order of (t, primitive), coincident ones too.
fn every_hit_is_enumerated(device: &Device, mesh: &Mesh) -> Result<(bool, String, &'static str), TraceError> {
    let g = mesh.geometry();
    let tracer = Tracer::new(device, &g)?;
    let rays = soup::rays(mesh, 1024, &mut Random(3));
    let mut records: Vec<RayRecord> = rays.iter().map(record).collect();
    let mut found = vec![Vec::new(); rays.len()];
    loop {
        let hits = tracer.trace(Question::ClosestFrom, &records)?;
        let mut is_done = true;
        for (i, hit) in hits.iter().enumerate() {
            // A ray that is through goes on from infinity, and finds nothing again.
            (records[i].t_after, records[i].primitive) = (hit.t, hit.primitive);
            if hit.kind != NONE {
                found[i].push((hit.t, hit.primitive));
                is_done = false;
            }
        }
        if is_done || found[0].len() > g.triangles.len() {
            break;
        }
    }
    let (mut wrong, mut total, mut example) = (0, 0, String::new());
    for (ray, found) in rays.iter().zip(&found) {
        let mut primitives: Vec<u32> = found.iter().map(|h| h.1).collect();
        primitives.sort_unstable();
        let (surely, possibly) = judge::all_hits(&g, ray);
        let is_ordered = found.windows(2).all(|w| w[0] < w[1]);
        let is_unique = primitives.windows(2).all(|w| w[0] != w[1]);
        let is_complete = surely.iter().all(|p| primitives.binary_search(p).is_ok());
        let is_sound = primitives.iter().all(|p| possibly.contains(p));
        total += found.len();
        if !(is_ordered && is_unique && is_complete && is_sound) {
            wrong += 1;
            example = format!(", {ray:?} found {found:?}, expected {surely:?}");
        }
    }
    let evidence = format!("{wrong} of {} rays wrong, {total} hits{example}", rays.len());
    Ok((wrong == 0, evidence, "each hit once, in order, none left out"))
}

/// The origin of a reflected ray lies on its side of the surface (in f64), and from there the surface it left is not hit.
fn spawned_rays_leave(device: &Device, mesh: &Mesh) -> Result<(bool, String, &'static str), TraceError> {
    let g = mesh.geometry();
    let rays = soup::rays(mesh, 4 * SOUP_RAYS, &mut Random(17));
    let spawned = trace(device, &g, Question::Spawn, &rays)?;
    let mut origins = Vec::new();
    let mut left = Vec::new();
    let (mut behind, mut largest, mut example) = (0, 0.0f64, String::new());
    for (ray, s) in rays.iter().zip(&spawned).filter(|(_, s)| s.kind != NONE) {
        let o = [s.t, s.b1, s.b2];
        let (height, size, w) = judge::height_above(&g, s.kind, s.slot, ray, o);
        largest = largest.max(height / size);
        if height.is_nan() || height < 0.0 {
            behind += 1;
            example = format!(", {ray:?} spawned {o:?} {height:e} above primitive {}", s.primitive);
        }
        origins.push(Ray { o, d: w, t_max: f32::INFINITY });
        // Inside a sphere the far side is hit after a chord of 2 r cos; nearer than half of that is the point it left.
        let is_inside = s.kind == 1 && judge::is_inside(&g, s.slot, ray, o);
        let chord = if is_inside { judge::chord(&g, s.slot, o, w) } else { f32::INFINITY };
        left.push((s.kind, s.primitive, 0.5 * chord));
    }
    let again = trace(device, &g, Question::Closest, &origins)?;
    let hit_self = again.iter().zip(&left).filter(|(h, l)| (h.kind, h.primitive) == (l.0, l.1) && h.t < l.2).count();
    let evidence = format!(
        "{} spawned: {behind} on the wrong side, {hit_self} hit what they left; highest {largest:.1e} of |p| + size{example}",
        left.len()
    );
    // delta <= |ng|_1 times the largest component of the error <= sqrt 3 (gamma_7 (|p| + size) + gamma_16 2 size).
    let is_near = largest < 4.1e-6;
    Ok((behind + hit_self == 0 && is_near, evidence, "none behind, none hits again, within 4.1e-6 of |p| + size"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::conform::Verdict;
    use crate::gpu::{Choice, Options};

    #[test]
    fn the_traversal_gate_holds() {
        let options = Options { validation: true, max_memory: None };
        let device = Device::open(&Choice::Auto, &options).expect("tests need a Vulkan device: run ./x once");
        let rows = run(&device, "");
        for r in &rows {
            eprintln!("{:?} {}: {} [{}]", r.verdict, r.name, r.evidence, r.bound);
        }
        assert!(rows.iter().all(|r| r.verdict == Verdict::Pass));
        assert_eq!(device.messages(), Vec::<String>::new());
    }
}
