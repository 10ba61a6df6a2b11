//! Is a difference between a device's hit and the f64 one explained by rounding?
//!
//! The f32 triangle test rounds each vertex's place in the ray's frame by at most `ULPS` ulp of its distance D from the origin, so
//! an edge function over vertices at most L from the ray moves by 2 L times that, and a weight by that over the doubled area.

use std::fmt;

use glam::DVec3;

use crate::bvh::brute::{self, Nearest};
use crate::bvh::tracer::HitRecord;
use crate::bvh::traverse::{Geometry, Hit, NONE, Ray};
use crate::prepare::records::{DiscRecord, SphereRecord, TriangleRecord};

/// Subtraction, two shear products, a difference, and the f32 direction's own shear quotient: 5, in two components.
pub const ULPS: f64 = 8.0;
pub const EPS: f64 = 1.0 / 16_777_216.0;

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Judgement {
    Same,
    /// Another primitive, as near within rounding.
    Tie,
    /// An outline or an end of the ray within rounding.
    Edge,
    Wrong(&'static str),
}

#[derive(Default)]
pub struct Tally {
    hits: usize,
    misses: usize,
    ties: usize,
    edges: usize,
    pub wrong: usize,
    example: String,
}

impl Tally {
    pub fn add(&mut self, judgement: Judgement, ray: &Ray, hit: &HitRecord) {
        match judgement {
            Judgement::Same if hit.kind == NONE => self.misses += 1,
            Judgement::Same => self.hits += 1,
            Judgement::Tie => self.ties += 1,
            Judgement::Edge => self.edges += 1,
            Judgement::Wrong(why) => {
                self.wrong += 1;
                self.example = format!(", {why}: {ray:?} {:?}", hit.hit());
            }
        }
    }
}

impl fmt::Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Tally { hits, misses, ties, edges, wrong, example } = self;
        write!(f, "{hits} hits and {misses} misses agree, {ties} ties, {edges} within rounding, {wrong} wrong{example}")
    }
}

/// A primitive seen along a ray in f64: distances, how far inside (0 = on the outline), and what rounding does to both.
#[derive(Clone, Copy)]
pub struct Seen {
    t: [f64; 2],
    margin: f64,
    margin_error: f64,
    t_error: f64,
}

fn vector(v: [f32; 3]) -> DVec3 {
    DVec3::from(v.map(f64::from))
}

fn see_triangle(ray: &Ray, r: &TriangleRecord) -> Option<Seen> {
    see_corners(ray, [r.v0, r.v1, r.v2].map(vector), |far| ULPS * EPS * far)
}

/// `moved` says how far rounding moves a vertex as the ray sees it, given its distance.
pub fn see_corners(ray: &Ray, corners: [DVec3; 3], moved: impl Fn(f64) -> f64) -> Option<Seen> {
    let (t, margin) = brute::plane_of_corners(ray, corners)?;
    let (o, d) = (vector(ray.o), vector(ray.d));
    let v = corners.map(|v| v - o);
    // Distance and offset from the ray's line of each vertex; the doubled area as the ray sees it.
    let across = v.map(|p| p - d * (p.dot(d) / d.length_squared()));
    let far = v.iter().map(|p| p.length()).fold(0.0, f64::max);
    let wide = across.iter().map(|p| p.length()).fold(0.0, f64::max);
    let area = (across[1] - across[0]).cross(across[2] - across[0]).length();
    let moved = moved(far);
    let margin_error = (2.0 * wide * moved + 4.0 * EPS * wide * wide) / area;
    let size = (v[1] - v[0]).length().max((v[2] - v[0]).length());
    let t_error = 3.0 * margin_error * size + moved;
    Some(Seen { t: [t; 2], margin, margin_error, t_error })
}

fn see_sphere(ray: &Ray, r: &SphereRecord) -> Option<Seen> {
    let (t, margin) = brute::line_of_sphere(ray, r)?;
    let radius = f64::from(r.radius);
    let far = (vector(ray.o) - vector(r.center)).length();
    let moved = ULPS * EPS * (far + radius);
    let half = (t[1] - t[0]) / 2.0;
    let t_error = moved + (radius * moved / half.max(1e-300)).min((2.0 * radius * moved).sqrt());
    Some(Seen { t, margin, margin_error: moved / radius, t_error: t_error + 2.0 * EPS * far })
}

/// Height over the plane and cosine are sums of three products each: their errors over the cosine move the hit along the ray.
fn see_disc(ray: &Ray, r: &DiscRecord) -> Option<Seen> {
    let (t, margin) = brute::plane_of_disc(ray, r)?;
    let (o, d, n) = (vector(ray.o), vector(ray.d), vector(r.normal));
    let far = (vector(r.center) - o).length().max(t.abs() * d.length());
    let t_error = ULPS * EPS * far / d.dot(n).abs();
    Some(Seen { t: [t; 2], margin, margin_error: (t_error + ULPS * EPS * far) / f64::from(r.radius), t_error })
}

fn see(g: &Geometry, ray: &Ray, primitive: u32) -> Option<Seen> {
    if let Some(r) = g.triangles.iter().find(|r| r.face == primitive) {
        return see_triangle(ray, r);
    }
    if let Some(r) = g.spheres.iter().find(|r| r.primitive == primitive) {
        return see_sphere(ray, r);
    }
    see_disc(ray, g.discs.iter().find(|r| r.primitive == primitive)?)
}

impl Seen {
    fn is_on_outline(&self) -> bool {
        self.margin <= self.margin_error
    }

    /// Distance of t from the nearer of both, in excess of rounding.
    fn excess(&self, t: f64) -> f64 {
        (self.t[0] - t).abs().min((self.t[1] - t).abs()) - self.t_error
    }
}

pub fn judge(g: &Geometry, ray: &Ray, hit: &Hit, nearest: Option<Nearest>) -> Judgement {
    // The f64 line may pass by a sphere: only rounding at the outline can hit it.
    let grazes = |primitive: u32| {
        let sphere = g.spheres.iter().find(|r| r.primitive == primitive);
        sphere.is_some_and(|r| {
            let (f, d) = (vector(ray.o) - vector(r.center), vector(ray.d));
            let off = (f - d * (f.dot(d) / d.length_squared())).length();
            off - f64::from(r.radius) <= ULPS * EPS * (f.length() + f64::from(r.radius))
        })
    };
    judge_seen(ray, hit, nearest, &|primitive| see(g, ray, primitive), &grazes)
}

/// `see` looks at a primitive by its number; `grazes` says that rounding may hit one that the f64 line passes by.
pub fn judge_seen(
    ray: &Ray,
    hit: &Hit,
    nearest: Option<Nearest>,
    see: &dyn Fn(u32) -> Option<Seen>,
    grazes: &dyn Fn(u32) -> bool,
) -> Judgement {
    let expected = nearest.and_then(|n| see(n.primitive).map(|s| (n, s)));
    let is_at_end = |n: &Nearest, s: &Seen| n.t <= s.t_error || f64::from(ray.t_max) - n.t <= s.t_error;
    if hit.kind == NONE {
        return match expected {
            None => Judgement::Same,
            Some((n, s)) if s.is_on_outline() || is_at_end(&n, &s) => Judgement::Edge,
            Some(_) => Judgement::Wrong("missed"),
        };
    }
    let Some(seen) = see(hit.primitive) else {
        let is_explained = grazes(hit.primitive);
        return if is_explained { Judgement::Edge } else { Judgement::Wrong("hit what the line does not meet") };
    };
    if seen.margin < -seen.margin_error {
        return Judgement::Wrong("hit outside the primitive");
    }
    let t = f64::from(hit.t);
    // Seen so nearly edge-on that no digit of t is certain: then the outline judges.
    if seen.excess(t) > 0.0 && seen.margin_error < 1.0 {
        return Judgement::Wrong("wrong distance");
    }
    match expected {
        None => Judgement::Edge,
        Some((n, s)) if n.primitive == hit.primitive && (n.t - t).abs() <= s.t_error => Judgement::Same,
        Some((n, s)) if (n.t - t).abs() <= s.t_error + seen.t_error => Judgement::Tie,
        Some((n, s)) if s.is_on_outline() || is_at_end(&n, &s) => Judgement::Edge,
        Some((n, _)) if t < n.t && seen.is_on_outline() => Judgement::Edge,
        Some((n, _)) if t < n.t && t <= seen.t_error => Judgement::Edge,
        Some(_) => Judgement::Wrong("not the nearest"),
    }
}

/// Triangles that the ray surely hits, and those that it hits when rounding helps.
pub fn all_hits(g: &Geometry, ray: &Ray) -> (Vec<u32>, Vec<u32>) {
    let (mut surely, mut possibly) = (Vec::new(), Vec::new());
    for r in g.triangles {
        let Some(s) = see_triangle(ray, r) else { continue };
        let t_max = f64::from(ray.t_max);
        let e = s.t_error;
        if s.margin > s.margin_error && s.t[0] > e && s.t[0] < t_max - e {
            surely.push(r.face);
        }
        if s.margin > -s.margin_error && s.t[0] > -e && s.t[0] < t_max + e {
            possibly.push(r.face);
        }
    }
    (surely, possibly)
}

/// How far `o` lies above the surface on the side the ray came from, in f64; |p| + size to measure it by; the mirrored direction.
pub fn height_above(g: &Geometry, kind: u32, slot: u32, ray: &Ray, o: [f32; 3]) -> (f64, f64, [f32; 3]) {
    let (o, d) = (vector(o), vector(ray.d));
    let (n, height, size) = if kind == 0 {
        let [a, b, c] = [&g.triangles[slot as usize]].map(|r| [r.v0, r.v1, r.v2].map(vector))[0];
        let n = (b - a).cross(c - a).normalize();
        (n, (o - a).dot(n), (b - a).length().max((c - a).length()))
    } else if kind == 2 {
        let r = &g.discs[slot as usize];
        let n = vector(r.normal).normalize();
        (n, (o - vector(r.center)).dot(n), f64::from(r.radius))
    } else {
        let r = &g.spheres[slot as usize];
        let f = o - vector(r.center);
        (f.normalize(), f.length() - f64::from(r.radius), f64::from(r.radius))
    };
    let side = if d.dot(n) > 0.0 { -1.0 } else { 1.0 };
    let w = (d - n * (2.0 * d.dot(n))).normalize().as_vec3();
    (side * height, o.length() + size, w.to_array())
}

/// Whether the ray met the sphere from inside.
pub fn is_inside(g: &Geometry, slot: u32, ray: &Ray, o: [f32; 3]) -> bool {
    vector(ray.d).dot(vector(o) - vector(g.spheres[slot as usize].center)) > 0.0
}

/// Length of the way through the sphere from a point on it in direction w.
pub fn chord(g: &Geometry, slot: u32, o: [f32; 3], w: [f32; 3]) -> f32 {
    (2.0 * vector(w).dot(vector(g.spheres[slot as usize].center) - vector(o))) as f32
}
