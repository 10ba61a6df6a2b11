//! Scalar f32 traversal in Rust, operation for operation that of shaders/bvh: the figure to compare the device with, and a
//! second opinion on each hit.
//!
//! Watertight triangles after Woop, Benthin, Wald 2013, boxes after Ize 2013, spheres after Haines et al. 2019; the pages of
//! shaders/bvh/{triangle,node,sphere,disc}.glsl give the details. Test: gate 5 (src/conform/traversal.rs), which compares both
//! with `brute`.

use super::{Bvh, KIND_DISC, KIND_INSTANCE, KIND_SPHERE, KIND_TRIANGLE, LEAF_BIT, WORLD, leaf_range};
use crate::prepare::records::{DiscRecord, InstanceRecord, SphereRecord, TriangleRecord};

/// `d` has unit length; hits lie at 0 < t < t_max.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    pub o: [f32; 3],
    pub d: [f32; 3],
    pub t_max: f32,
}

/// `kind` is NONE where nothing was hit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    pub t: f32,
    /// Barycentric weights of v1 and v2; 0 on a sphere or disc.
    pub b1: f32,
    pub b2: f32,
    pub kind: u32,
    /// Place in leaf order.
    pub slot: u32,
    /// Face number, or `primitive` of the sphere's or disc's record; on an instance, with its `primitive_offset` added.
    pub primitive: u32,
    /// Row of `instances`; 0 is the world.
    pub instance: u32,
}

pub const NONE: u32 = u32::MAX;

impl Hit {
    pub const MISS: Hit =
        Hit { t: f32::INFINITY, b1: 0.0, b2: 0.0, kind: NONE, slot: NONE, primitive: NONE, instance: 0 };
}

/// The tree and its primitives in leaf order.
#[derive(Clone, Copy)]
pub struct Geometry<'a> {
    pub bvh: &'a Bvh,
    pub triangles: &'a [TriangleRecord],
    pub spheres: &'a [SphereRecord],
    pub discs: &'a [DiscRecord],
    /// Empty in a scene of one level.
    pub instances: &'a [InstanceRecord],
}

/// 1 + 2 gamma_13: 3 roundings of a slab distance (Ize 2013, Section 3) and 10 ulp by which the triangle test may move an edge.
pub const BOX_SLACK: f32 = 1.0 + 26.0 / 16_777_216.0;

/// The frame in which the ray is the z axis.
#[derive(Clone, Copy)]
pub struct Shear {
    /// Axis of largest |d|.
    kz: usize,
    sx: f32,
    sy: f32,
    sz: f32,
}

impl Shear {
    pub fn new(d: [f32; 3]) -> Shear {
        let a = d.map(f32::abs);
        let kz = if a[0] >= a[1] && a[0] >= a[2] {
            0
        } else if a[1] >= a[2] {
            1
        } else {
            2
        };
        let sz = 1.0 / d[kz];
        Shear { kz, sx: d[(kz + 1) % 3] * sz, sy: d[(kz + 2) % 3] * sz, sz }
    }

    fn apply(&self, o: [f32; 3], v: [f32; 3]) -> [f32; 3] {
        let p: [f32; 3] = std::array::from_fn(|k| v[k] - o[k]);
        let (x, y, z) = (p[(self.kz + 1) % 3], p[(self.kz + 2) % 3], p[self.kz]);
        [x - self.sx * z, y - self.sy * z, self.sz * z]
    }
}

/// Rounding error of the product a * b = p: 12-bit halves by masking, then Dekker's sum (1971), each step exact.
fn product_error(a: f32, b: f32, p: f32) -> f32 {
    let high = |x: f32| f32::from_bits(x.to_bits() & 0xffff_f000);
    let (ah, bh) = (high(a), high(b));
    let (al, bl) = (a - ah, b - bh);
    ((ah * bh - p) + ah * bl + al * bh) + al * bl
}

/// a * b - c * d with the right sign: only where both products round to the same number can f32 lose it.
fn edge(a: f32, b: f32, c: f32, d: f32) -> f32 {
    let (p, q) = (a * b, c * d);
    let e = p - q;
    if e == 0.0 { product_error(a, b, p) - product_error(c, d, q) } else { e }
}

/// (t, b1, b2); t is NaN where the ray passes by or the triangle is seen edge-on. Points on an edge belong to the triangle.
pub fn intersect_triangle(shear: &Shear, o: [f32; 3], v: [[f32; 3]; 3]) -> (f32, f32, f32) {
    let [a, b, c] = v.map(|p| shear.apply(o, p));
    let e0 = edge(b[0], c[1], b[1], c[0]);
    let e1 = edge(c[0], a[1], c[1], a[0]);
    let e2 = edge(a[0], b[1], a[1], b[0]);
    let lowest = e0.min(e1).min(e2);
    let highest = e0.max(e1).max(e2);
    let sum = (e0 + e1) + e2;
    if (lowest < 0.0 && highest > 0.0) || sum == 0.0 {
        return (f32::NAN, 0.0, 0.0);
    }
    let inverse = 1.0 / sum;
    let (b0, b1, b2) = (e0 * inverse, e1 * inverse, e2 * inverse);
    ((b0 * a[2] + b1 * b[2]) + b2 * c[2], b1, b2)
}

/// Near and far distance; NaN where the ray passes by.
pub fn intersect_sphere(o: [f32; 3], d: [f32; 3], center: [f32; 3], radius: f32) -> (f32, f32) {
    let dot = |a: [f32; 3], b: [f32; 3]| (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2];
    let f: [f32; 3] = std::array::from_fn(|k| o[k] - center[k]);
    let a = dot(d, d);
    let b = -dot(f, d);
    let s = b / a;
    let l: [f32; 3] = std::array::from_fn(|k| f[k] + s * d[k]);
    let length = dot(l, l).sqrt();
    let discriminant = (radius - length) * (radius + length);
    if discriminant < 0.0 {
        return (f32::NAN, f32::NAN);
    }
    let root = (a * discriminant).sqrt();
    let q = if b < 0.0 { b - root } else { b + root };
    let distance = dot(f, f).sqrt();
    let c = (distance - radius) * (distance + radius);
    let (t0, t1) = (c / q, q / a);
    (t0.min(t1), t0.max(t1))
}

/// Distance; NaN where the ray passes by or runs along the plane.
pub fn intersect_disc(o: [f32; 3], d: [f32; 3], center: [f32; 3], normal: [f32; 3], radius: f32) -> f32 {
    let dot = |a: [f32; 3], b: [f32; 3]| (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2];
    let f: [f32; 3] = std::array::from_fn(|k| center[k] - o[k]);
    let t = dot(f, normal) / dot(d, normal);
    let h: [f32; 3] = std::array::from_fn(|k| t * d[k] - f[k]);
    if dot(h, h) <= radius * radius { t } else { f32::NAN }
}

/// The ray in the space of an instance; distances stay as they are.
pub fn object_ray(m: &InstanceRecord, ray: &Ray) -> Ray {
    let rows = [m.to_object0, m.to_object1, m.to_object2];
    let point = |r: [f32; 4]| ((r[0] * ray.o[0] + r[1] * ray.o[1]) + r[2] * ray.o[2]) + r[3];
    let vector = |r: [f32; 4]| (r[0] * ray.d[0] + r[1] * ray.d[1]) + r[2] * ray.d[2];
    Ray { o: rows.map(point), d: rows.map(vector), t_max: ray.t_max }
}

/// Nearest hit after (t_after, primitive_after) in the order of (t, primitive), before t_max. Start with (0, NONE).
pub fn closest_from(g: &Geometry, ray: &Ray, t_after: f32, primitive_after: u32) -> Hit {
    let mut best = Hit { t: ray.t_max, primitive: 0, ..Hit::MISS };
    walk(g, ray, |hit, t_max| {
        let Hit { t, primitive, .. } = hit;
        let is_after = t > t_after || (t == t_after && primitive > primitive_after);
        if is_after && (t < best.t || (t == best.t && primitive < best.primitive)) {
            best = hit;
            *t_max = t;
        }
        false
    });
    if best.kind == NONE { Hit::MISS } else { best }
}

/// Whether anything but `excluded` lies on 0 < t < t_max.
pub fn any(g: &Geometry, ray: &Ray, excluded: u32) -> bool {
    walk(g, ray, |hit, _| hit.t > 0.0 && hit.t < ray.t_max && hit.primitive != excluded)
}

/// Calls `hit(hit, &mut t_max)` for each primitive the ray meets at t > 0, until one returns true.
fn walk(g: &Geometry, world: &Ray, mut hit: impl FnMut(Hit, &mut f32) -> bool) -> bool {
    let reciprocal = |d: [f32; 3]| d.map(|d| if d == 0.0 { f32::INFINITY } else { 1.0 / d });
    let mut ray = *world;
    let mut inverse = reciprocal(ray.d);
    let mut shear = Shear::new(ray.d);
    let (mut instance, mut offset) = (0, 0);
    let mut t_max = ray.t_max;
    let mut stack: Vec<(f32, u32)> = Vec::with_capacity(g.bvh.stack_size() as usize);
    let mut current = 0u32;
    loop {
        if current & LEAF_BIT == 0 {
            let mut entered = [(f32::INFINITY, 0u32); 4];
            let count = enter_children(&g.bvh.nodes[current as usize], ray.o, inverse, t_max, &mut entered);
            entered[..count].sort_unstable_by(|a, b| b.0.total_cmp(&a.0));
            stack.extend_from_slice(&entered[..count]);
        } else if leaf_range(current).0 == KIND_INSTANCE {
            instance = leaf_range(current).1 as u32;
            let record = &g.instances[instance as usize];
            ray = object_ray(record, world);
            (inverse, shear, offset) = (reciprocal(ray.d), Shear::new(ray.d), record.primitive_offset);
            if current != WORLD {
                stack.push((0.0, WORLD));
                current = record.first_node;
                continue;
            }
        } else {
            let (kind, first, count) = leaf_range(current);
            let mut offer = |primitive: u32, slot: usize, (t, b1, b2): (f32, f32, f32)| {
                let primitive = primitive.wrapping_add(offset);
                t > 0.0 && hit(Hit { t, b1, b2, kind, slot: slot as u32, primitive, instance }, &mut t_max)
            };
            for slot in first..first + count {
                let done = match kind {
                    KIND_TRIANGLE => {
                        let r = &g.triangles[slot];
                        offer(r.face, slot, intersect_triangle(&shear, ray.o, [r.v0, r.v1, r.v2]))
                    }
                    KIND_SPHERE => {
                        let r = &g.spheres[slot];
                        let (near, far) = intersect_sphere(ray.o, ray.d, r.center, r.radius);
                        offer(r.primitive, slot, (near, 0.0, 0.0)) || offer(r.primitive, slot, (far, 0.0, 0.0))
                    }
                    _ => {
                        debug_assert_eq!(kind, KIND_DISC);
                        let r = &g.discs[slot];
                        let t = intersect_disc(ray.o, ray.d, r.center, r.normal, r.radius);
                        offer(r.primitive, slot, (t, 0.0, 0.0))
                    }
                };
                if done {
                    return true;
                }
            }
        }
        loop {
            let Some((t, next)) = stack.pop() else { return false };
            if t <= t_max * BOX_SLACK {
                current = next;
                break;
            }
        }
    }
}

/// The children that the ray enters before t_max, with the distance, in slot order.
#[inline]
fn enter_children(
    n: &super::Node4,
    o: [f32; 3],
    inverse: [f32; 3],
    t_max: f32,
    entered: &mut [(f32, u32); 4],
) -> usize {
    // A NaN (0 times infinity: the origin lies in a face plane that the ray runs along) loses each comparison and drops out.
    let larger = |a: f32, b: f32| if a > b { a } else { b };
    let smaller = |a: f32, b: f32| if a < b { a } else { b };
    let mut t_near = [0.0f32; 4];
    let mut t_far = [t_max; 4];
    for (k, lo, hi) in [(0, &n.min_x, &n.max_x), (1, &n.min_y, &n.max_y), (2, &n.min_z, &n.max_z)] {
        let (near, far) = if inverse[k] < 0.0 { (hi, lo) } else { (lo, hi) };
        for c in 0..4 {
            t_near[c] = larger((near[c] - o[k]) * inverse[k], t_near[c]);
            t_far[c] = smaller((far[c] - o[k]) * inverse[k], t_far[c]);
        }
    }
    let mut count = 0;
    for c in 0..4 {
        if t_near[c] <= t_far[c] * BOX_SLACK {
            entered[count] = (t_near[c], n.child[c]);
            count += 1;
        }
    }
    count
}
