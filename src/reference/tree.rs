//! The oracle's intersection: a binary tree in f64, binned by surface area.
//!
//! Triangles by signed volumes (Pluecker coordinates; Davidovic, Hachisuka and Slusallek 2012): the edge functions of two
//! triangles that share an edge are exactly opposite in IEEE arithmetic, so rays do not slip between them. Spheres by the
//! quadratic whose discriminant is taken from the distance of the centre to the ray (Haines et al., Ray Tracing Gems 2019,
//! ch. 7), discs by the plane and the distance from the centre. No epsilon: a ray names the primitive it leaves. A plane cannot be hit again from itself; a sphere can be hit
//! only on its far side, and only when the ray goes inside. Boxes are widened as in Ize 2013. A level above holds trees of triangles that
//! are placed by a matrix (`Placed`); their triangles are numbered through, so that callers see one kind of number. Tests below: brute force.

use std::ops::Range;
use std::sync::Arc;

use glam::{DAffine3, DVec2, DVec3};

use crate::prepare::records::NONE;

/// Half-line. Primitives are named by number.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    pub origin: DVec3,
    /// Unit length.
    pub direction: DVec3,
    /// The primitive `origin` lies on, or NONE.
    pub leaves: u32,
    /// A primitive the ray passes through unseen (the light that a shadow ray aims at), or NONE.
    pub ignores: u32,
    /// Diameter of its cone at the origin, m, and growth a metre.
    pub cone: DVec2,
}

impl Ray {
    pub fn at(&self, t: f64) -> DVec3 {
        self.origin + t * self.direction
    }
}

/// Where a ray meets a primitive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    pub t: f64,
    pub primitive: u32,
    /// Triangle: weights of vertices 1 and 2. Sphere, disc: 0.
    pub barycentric: [f64; 2],
    /// The ray leaves a sphere here.
    pub is_far: bool,
}

#[derive(Clone, Copy, Debug)]
pub enum Shape {
    Triangle([DVec3; 3]),
    Sphere {
        center: DVec3,
        radius: f64,
    },
    /// `normal` is unit.
    Disc {
        center: DVec3,
        normal: DVec3,
        radius: f64,
    },
}

/// A tree of triangles in a space of its own, placed in the world. Its triangle k has the world's number `first + k`.
#[derive(Clone, Debug)]
pub struct Placed {
    pub first: u32,
    pub count: u32,
    pub to_world: DAffine3,
    to_object: DAffine3,
    tree: Arc<Tree>,
}

impl Placed {
    pub fn new(tree: Arc<Tree>, to_world: DAffine3, first: u32, count: u32) -> Self {
        Self { first, count, to_world, to_object: to_world.inverse(), tree }
    }

    fn bounds(&self) -> Bounds {
        let Some(root) = self.tree.nodes.first() else { return Bounds::EMPTY };
        let corner = |i: u32| {
            let pick = |bit: u32, k: usize| if i >> bit & 1 == 1 { root.bounds.max[k] } else { root.bounds.min[k] };
            self.to_world.transform_point3(DVec3::new(pick(0, 0), pick(1, 1), pick(2, 2)))
        };
        let exact = (0..8).map(corner).fold(Bounds::EMPTY, |b, p| b.union(Bounds { min: p, max: p }));
        // What f64 does to a ray's way there and back, far above 2^-53 of all that enters.
        let margin = 1e-12
            * (exact.min.abs().max(exact.max.abs()).max_element() + self.to_world.translation.abs().max_element());
        Bounds { min: exact.min - margin, max: exact.max + margin }
    }

    /// The ray in the mesh's space, with its numbers; distances are the world's.
    fn object_ray(&self, ray: &Ray) -> Ray {
        let number = |n: u32| n.checked_sub(self.first).filter(|k| *k < self.count).unwrap_or(NONE);
        Ray {
            origin: self.to_object.transform_point3(ray.origin),
            direction: self.to_object.transform_vector3(ray.direction),
            leaves: number(ray.leaves),
            ignores: number(ray.ignores),
            cone: ray.cone,
        }
    }
}

impl Shape {
    fn bounds(&self) -> Bounds {
        match self {
            Self::Triangle(v) => Bounds { min: v[0].min(v[1]).min(v[2]), max: v[0].max(v[1]).max(v[2]) },
            Self::Sphere { center, radius } => Bounds { min: center - *radius, max: center + *radius },
            Self::Disc { center, normal, radius } => {
                // 1e-12 of the radius covers the rounding of 1 - n^2 near 0.
                let half = *radius * ((DVec3::ONE - normal * normal).max(DVec3::ZERO).map(f64::sqrt) + 1e-12);
                Bounds { min: center - half, max: center + half }
            }
        }
    }
}

/// A shape as the leaves hold it.
#[derive(Clone, Copy, Debug)]
struct Stored {
    number: u32,
    shape: Shape,
    /// Of a triangle, not unit: from edges, because the signed volumes lose digits for small far triangles.
    normal: DVec3,
}

impl Stored {
    fn new(number: u32, shape: Shape) -> Self {
        let normal = match shape {
            Shape::Triangle(v) => (v[1] - v[0]).cross(v[2] - v[0]),
            Shape::Sphere { .. } | Shape::Disc { .. } => DVec3::ZERO,
        };
        Self { number, shape, normal }
    }

    /// Calls `found` with each hit in 0 < t <= t_max.
    #[inline(always)]
    fn intersect(&self, ray: &Ray, t_max: f64, mut found: impl FnMut(Hit)) {
        let leaves = self.number == ray.leaves;
        match &self.shape {
            Shape::Triangle(v) => {
                // The plane first: most candidates fail there.
                let t = self.normal.dot(v[0] - ray.origin) / self.normal.dot(ray.direction);
                if t > 0.0
                    && t <= t_max
                    && !leaves
                    && let Some(barycentric) = triangle(v, ray)
                {
                    found(Hit { t, primitive: self.number, barycentric, is_far: false });
                }
            }
            Shape::Sphere { center, radius } => {
                let [near, far] = sphere(*center, *radius, ray, leaves);
                for (t, is_far) in [(near, false), (far, true)] {
                    if t > 0.0 && t <= t_max {
                        found(Hit { t, primitive: self.number, barycentric: [0.0; 2], is_far });
                    }
                }
            }
            Shape::Disc { center, normal, radius } => {
                let t = (*center - ray.origin).dot(*normal) / ray.direction.dot(*normal);
                if t > 0.0 && t <= t_max && !leaves && ray.at(t).distance_squared(*center) <= radius * radius {
                    found(Hit { t, primitive: self.number, barycentric: [0.0; 2], is_far: false });
                }
            }
        }
    }
}

/// Weights of vertices 1 and 2 where the line of the ray passes inside.
#[inline(always)]
fn triangle(v: &[DVec3; 3], ray: &Ray) -> Option<[f64; 2]> {
    let [a, b, c] = [v[0] - ray.origin, v[1] - ray.origin, v[2] - ray.origin];
    let d = ray.direction;
    let weight_a = d.dot(c.cross(b));
    let weight_b = d.dot(a.cross(c));
    let weight_c = d.dot(b.cross(a));
    let is_inside = (weight_a >= 0.0 && weight_b >= 0.0 && weight_c >= 0.0)
        || (weight_a <= 0.0 && weight_b <= 0.0 && weight_c <= 0.0);
    let sum = weight_a + weight_b + weight_c;
    (is_inside && sum != 0.0).then(|| [weight_b / sum, weight_c / sum])
}

/// Both distances, NaN for what is not there.
fn sphere(center: DVec3, radius: f64, ray: &Ray, leaves: bool) -> [f64; 2] {
    let to_center = center - ray.origin;
    let along = to_center.dot(ray.direction);
    if leaves {
        // The other root of a ray that starts on the sphere; going outward it is negative.
        return [f64::NAN, 2.0 * along];
    }
    let across = to_center - along * ray.direction;
    // NaN for a ray that passes by.
    let half = (radius * radius - across.length_squared()).sqrt();
    [along - half, along + half]
}

#[derive(Clone, Copy, Debug)]
struct Bounds {
    min: DVec3,
    max: DVec3,
}

impl Bounds {
    const EMPTY: Self = Self { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };

    fn union(self, o: Self) -> Self {
        Self { min: self.min.min(o.min), max: self.max.max(o.max) }
    }
    fn half_area(&self) -> f64 {
        let e = (self.max - self.min).max(DVec3::ZERO);
        e.x * e.y + e.y * e.z + e.z * e.x
    }
    fn center(&self) -> DVec3 {
        0.5 * self.min + 0.5 * self.max
    }
    #[inline(always)]
    /// Distance at which the ray enters, or infinity when it misses, leaves before `t_min` or enters past `t_max`.
    fn entry(&self, origin: DVec3, inverse: DVec3, t_min: f64, t_max: f64) -> f64 {
        let a = (self.min - origin) * inverse;
        let b = (self.max - origin) * inverse;
        // `f64::min` and `max` drop a NaN (0 * infinity: the ray lies in a face), which leaves that slab open.
        let near = a.x.min(b.x).max(a.y.min(b.y)).max(a.z.min(b.z)).max(0.0);
        let far = a.x.max(b.x).min(a.y.max(b.y)).min(a.z.max(b.z)) * (1.0 + 4.0 * f64::EPSILON);
        if near > far || far < t_min {
            return f64::INFINITY;
        }
        // The distance to a flat box and that to the triangle in it round differently, and of two faces in one plane the second must
        // not be culled by the first: media count both.
        let near = (near - 1e-12 * (near + origin.abs().max_element())).max(0.0);
        if near <= t_max { near } else { f64::INFINITY }
    }
}

#[derive(Clone, Copy, Debug)]
struct Node {
    bounds: Bounds,
    /// Inner: index of the second child (the first follows the node). Leaf: first shape.
    at: u32,
    /// 0 for inner nodes.
    count: u32,
}

const LEAF_SIZE: usize = 3;
/// Below this depth nodes are halved, so that no input needs more than `STACK_SIZE` entries.
const PLANE_DEPTH: usize = 40;
const STACK_SIZE: usize = PLANE_DEPTH + 32;

/// Closest-hit and any-hit queries over numbered shapes.
#[derive(Clone, Debug, Default)]
pub struct Tree {
    nodes: Vec<Node>,
    /// In leaf order.
    shapes: Vec<Stored>,
    placed: Option<Box<Upper>>,
}

/// The upper level: boxes of placements, visited after the shapes of the world.
#[derive(Clone, Debug)]
struct Upper {
    nodes: Vec<Node>,
    /// In leaf order.
    placed: Vec<Placed>,
}

impl Tree {
    /// Shapes whose bounds are not finite are left out.
    pub fn build(shapes: Vec<(u32, Shape)>) -> Self {
        let mut items: Vec<(u32, Shape, Bounds)> = shapes
            .into_iter()
            .map(|(number, shape)| (number, shape, shape.bounds()))
            .filter(|(_, _, b)| b.min.is_finite() && b.max.is_finite())
            .collect();
        if items.is_empty() {
            return Self::default();
        }
        let nodes = build(&mut items, 0, 0);
        let shapes = items.into_iter().map(|(number, shape, _)| Stored::new(number, shape)).collect();
        Self { nodes, shapes, placed: None }
    }

    /// The same with a level above for placed trees. Those that hold nothing finite are left out.
    pub fn with_placed(self, placed: Vec<Placed>) -> Self {
        let mut items: Vec<(u32, Placed, Bounds)> = placed
            .into_iter()
            .map(|p| {
                let bounds = p.bounds();
                (p.first, p, bounds)
            })
            .filter(|(_, _, b)| b.min.is_finite() && b.max.is_finite())
            .collect();
        if items.is_empty() {
            return self;
        }
        let nodes = build(&mut items, 0, 0);
        let placed = items.into_iter().map(|i| i.1).collect();
        Self { placed: Some(Box::new(Upper { nodes, placed })), ..self }
    }

    /// First hit with 0 < t <= t_max in the order (t, primitive), past `after` in that order.
    pub fn closest(&self, ray: &Ray, after: Option<&Hit>, t_max: f64) -> Option<Hit> {
        let mut best: Option<Hit> = None;
        // Boxes behind `after` are skipped; 1e-9 is far above the rounding of a hit's distance.
        let t_min = after.map_or(0.0, |a| a.t * (1.0 - 1e-9));
        self.visit(ray, t_min, t_max, |hit| {
            let is_later = after.is_none_or(|a| (hit.t, hit.primitive) > (a.t, a.primitive));
            let is_better = best.is_none_or(|b| (hit.t, hit.primitive) < (b.t, b.primitive));
            if is_later && is_better {
                best = Some(hit);
            }
            best.map_or(t_max, |b| b.t)
        });
        best
    }

    /// True when some hit with 0 < t < t_max satisfies `blocks`.
    pub fn any(&self, ray: &Ray, t_max: f64, mut blocks: impl FnMut(&Hit) -> bool) -> bool {
        let mut is_blocked = false;
        self.visit(ray, 0.0, t_max, |hit| {
            is_blocked = is_blocked || (hit.t < t_max && blocks(&hit));
            if is_blocked { -1.0 } else { t_max }
        });
        is_blocked
    }

    /// Calls `found` with hits in 0 < t <= limit, in no order; it returns the new limit, negative to stop. Hits before `t_min`
    /// may be left out.
    fn visit(&self, ray: &Ray, t_min: f64, mut t_max: f64, mut found: impl FnMut(Hit) -> f64) {
        self.visit_shapes(ray, t_min, &mut t_max, &mut found);
        let Some(upper) = self.placed.as_ref().filter(|_| t_max >= 0.0) else { return };
        walk(&upper.nodes, ray, t_min, &mut t_max, |leaf, t_max| {
            for placed in &upper.placed[leaf] {
                let local = placed.object_ray(ray);
                let mut found = |hit: Hit| found(Hit { primitive: hit.primitive + placed.first, ..hit });
                placed.tree.visit_shapes(&local, t_min, t_max, &mut found);
                if *t_max < 0.0 {
                    return;
                }
            }
        });
    }

    #[inline(always)]
    fn visit_shapes(&self, ray: &Ray, t_min: f64, t_max: &mut f64, mut found: impl FnMut(Hit) -> f64) {
        walk(&self.nodes, ray, t_min, t_max, |leaf, t_max| {
            for stored in &self.shapes[leaf] {
                if stored.number == ray.ignores {
                    continue;
                }
                stored.intersect(ray, *t_max, |hit| *t_max = t_max.min(found(hit)));
                if *t_max < 0.0 {
                    return;
                }
            }
        });
    }
}

/// Calls `visit` with the items of each leaf that the ray enters before `t_max`, nearest first, until that is negative.
#[inline(always)]
fn walk(nodes: &[Node], ray: &Ray, t_min: f64, t_max: &mut f64, mut visit: impl FnMut(Range<usize>, &mut f64)) {
    let Some(root) = nodes.first() else { return };
    let inverse = ray.direction.recip();
    let mut stack = [(0u32, 0.0f64); STACK_SIZE];
    let mut depth = 0;
    let entry = root.bounds.entry(ray.origin, inverse, t_min, *t_max);
    if entry == f64::INFINITY {
        return;
    }
    let mut next = Some((0u32, entry));
    while let Some((index, entry)) = next.take().or_else(|| {
        depth = usize::checked_sub(depth, 1)?;
        Some(stack[depth])
    }) {
        if entry > *t_max {
            if depth == 0 {
                return;
            }
            continue;
        }
        let node = &nodes[index as usize];
        if node.count == 0 {
            let children = [index + 1, node.at];
            let entries = children.map(|c| nodes[c as usize].bounds.entry(ray.origin, inverse, t_min, *t_max));
            let (near, far) = if entries[0] <= entries[1] { (0, 1) } else { (1, 0) };
            if entries[far] < f64::INFINITY {
                stack[depth] = (children[far], entries[far]);
                depth += 1;
            }
            if entries[near] < f64::INFINITY {
                next = Some((children[near], entries[near]));
            }
            continue;
        }
        visit(node.at as usize..(node.at + node.count) as usize, t_max);
        if *t_max < 0.0 {
            return;
        }
    }
}

/// Nodes of `items` in depth-first order; `first` is the place of `items[0]` among all shapes.
fn build<T: Send>(items: &mut [(u32, T, Bounds)], first: usize, depth: usize) -> Vec<Node> {
    let bounds = items.iter().fold(Bounds::EMPTY, |b, i| b.union(i.2));
    let leaf = Node { bounds, at: first as u32, count: items.len() as u32 };
    if items.len() <= LEAF_SIZE {
        return vec![leaf];
    }
    let middle = if depth < PLANE_DEPTH { split(items, &bounds) } else { split_median(items) };
    let (left, right) = items.split_at_mut(middle);
    let (left, right) = if left.len() > 4096 {
        rayon::join(|| build(left, first, depth + 1), || build(right, first + middle, depth + 1))
    } else {
        (build(left, first, depth + 1), build(right, first + middle, depth + 1))
    };
    let mut nodes = Vec::with_capacity(1 + left.len() + right.len());
    let second = 1 + left.len() as u32;
    nodes.push(Node { bounds, at: second, count: 0 });
    // Children were numbered from their own roots.
    let shift = |by: u32| move |n: Node| if n.count == 0 { Node { at: n.at + by, ..n } } else { n };
    nodes.extend(left.into_iter().map(shift(1)));
    nodes.extend(right.into_iter().map(shift(second)));
    nodes
}

/// Orders `items` about the best of 15 planes an axis by the surface area heuristic (MacDonald and Booth 1990, binned as in
/// Wald 2007), or about the median where no plane parts them; returns the first of the right side.
fn split<T>(items: &mut [(u32, T, Bounds)], bounds: &Bounds) -> usize {
    const BINS: usize = 16;
    let centers = items.iter().fold(Bounds::EMPTY, |b, i| {
        let c = i.2.center();
        b.union(Bounds { min: c, max: c })
    });
    let extent = centers.max - centers.min;
    let bin = |axis: usize, b: &Bounds| {
        let at = (b.center()[axis] - centers.min[axis]) / extent[axis];
        ((at * BINS as f64) as usize).min(BINS - 1)
    };
    let mut best = (f64::INFINITY, 0, 0);
    for axis in 0..3 {
        if !(extent[axis] > 0.0 && extent[axis].is_finite()) {
            continue;
        }
        let mut bins = [(Bounds::EMPTY, 0usize); BINS];
        for (_, _, b) in items.iter() {
            let bin = &mut bins[bin(axis, b)];
            *bin = (bin.0.union(*b), bin.1 + 1);
        }
        let mut right_cost = [0.0; BINS];
        let (mut right, mut count) = (Bounds::EMPTY, 0);
        for k in (1..BINS).rev() {
            (right, count) = (right.union(bins[k].0), count + bins[k].1);
            right_cost[k] = right.half_area() * count as f64;
        }
        let (mut left, mut count) = (Bounds::EMPTY, 0);
        for k in 1..BINS {
            (left, count) = (left.union(bins[k - 1].0), count + bins[k - 1].1);
            let cost = left.half_area() * count as f64 + right_cost[k];
            if count > 0 && count < items.len() && cost < best.0 {
                best = (cost, axis, k);
            }
        }
    }
    let (_, axis, plane) = best;
    if plane == 0 || bounds.half_area() == 0.0 {
        return split_median(items);
    }
    let mut middle = 0;
    for i in 0..items.len() {
        if bin(axis, &items[i].2) < plane {
            items.swap(i, middle);
            middle += 1;
        }
    }
    middle
}

/// Halves `items` along the longest axis of their centres.
fn split_median<T>(items: &mut [(u32, T, Bounds)]) -> usize {
    let (min, max) = items.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(min, max), i| {
        let c = i.2.center();
        (min.min(c), max.max(c))
    });
    let axis = (max - min).max_position();
    let middle = items.len() / 2;
    items.select_nth_unstable_by(middle, |a, b| a.2.center()[axis].total_cmp(&b.2.center()[axis]).then(a.0.cmp(&b.0)));
    middle
}

/// Ray from the origin of nothing in particular: no primitive left, none ignored.
pub fn free_ray(origin: DVec3, direction: DVec3) -> Ray {
    Ray { origin, direction, leaves: NONE, ignores: NONE, cone: DVec2::ZERO }
}

#[cfg(test)]
#[path = "tree_tests.rs"]
mod tests;
