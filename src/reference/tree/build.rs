//! Boxes, and the binary tree over them: nodes in depth-first order, parted by surface area.

use glam::DVec3;

#[derive(Clone, Copy, Debug)]
pub struct Bounds {
    pub min: DVec3,
    pub max: DVec3,
}

impl Bounds {
    pub const EMPTY: Self = Self { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };

    pub fn union(self, o: Self) -> Self {
        Self { min: self.min.min(o.min), max: self.max.max(o.max) }
    }
    fn half_area(&self) -> f64 {
        let e = (self.max - self.min).max(DVec3::ZERO);
        e.x * e.y + e.y * e.z + e.z * e.x
    }
    fn center(&self) -> DVec3 {
        0.5 * self.min + 0.5 * self.max
    }
    /// Distance at which the ray enters, or infinity when it misses, leaves before `t_min` or enters past `t_max`.
    #[inline(always)]
    pub fn entry(&self, origin: DVec3, inverse: DVec3, t_min: f64, t_max: f64) -> f64 {
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
pub struct Node {
    pub bounds: Bounds,
    /// Inner: index of the second child (the first follows the node). Leaf: first shape.
    pub at: u32,
    /// 0 for inner nodes.
    pub count: u32,
}

const LEAF_SIZE: usize = 3;
/// Below this depth nodes are halved, so that no input needs more than `STACK_SIZE` entries.
const PLANE_DEPTH: usize = 40;
/// Entries that a walk down the tree needs at most.
pub const STACK_SIZE: usize = PLANE_DEPTH + 32;

/// Nodes of `items` in depth-first order; `first` is the place of `items[0]` among all shapes.
pub fn build<T: Send>(items: &mut [(u32, T, Bounds)], first: usize, depth: usize) -> Vec<Node> {
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
