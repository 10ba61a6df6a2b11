//! The oracle's intersection: a binary tree in f64, binned by surface area.
//!
//! No epsilon: a ray names the primitive it leaves (`shape`). Boxes are widened as in Ize 2013 (`build`). A level above holds trees of
//! triangles that are placed by a matrix (`Placed`); their triangles are numbered through, so that callers see one kind of number.
//! Tests: tree_tests.rs, against brute force.

mod build;
mod shape;

use std::ops::Range;
use std::sync::Arc;

use glam::{DAffine3, DVec3};

use crate::prepare::records::NONE;
pub(super) use build::Bounds;
use build::{Node, STACK_SIZE, build};
use shape::Stored;
pub use shape::{Hit, Ray, Shape, free_ray};

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

#[cfg(test)]
#[path = "tree_tests.rs"]
mod tests;
