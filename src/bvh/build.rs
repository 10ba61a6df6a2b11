//! From triangles, spheres and discs to a binary tree by binned SAH (see `sah`), then to four children a node (see `wide`).
//!
//! The result does not depend on the number of threads. Depth is bounded: below `sah_depth(n)` the cut is the median, which
//! halves, so that no input can make the tree deeper than 2 log2 n + 8 + log2 n + 3 levels.
//! Test: `tests` below, and gate 5 (src/conform/traversal.rs).

use glam::DVec3;
use rayon::prelude::*;

use super::sah::{self, Bounds, Ref};
use super::{
    BuildReport, Bvh, Disc, Error, KIND_DISC, KIND_INSTANCE, KIND_SPHERE, KIND_TRIANGLE, MAX_COORDINATE, MAX_LEAF,
    MAX_PRIMITIVES, Primitives, wide,
};

/// Primitives from which a task splits in two.
const PARALLEL_BUILD: usize = 1 << 12;
/// `Ref::id` is the primitive's number, its kind above it.
const KIND_SHIFT: u32 = MAX_PRIMITIVES.trailing_zeros();
/// Boxes are padded by this times the primitive's size: the triangle test shifts an edge by up to 5 ulp of the distance to its
/// vertices, which is at most the distance to the hit plus the size; the first part is in the ray's box test (Woop, Benthin,
/// Wald 2013, Section 4.2; Ize 2013).
const BOX_PADDING: f32 = 1.0 / (1u32 << 21) as f32;

/// A node of the binary tree, in post-order: an inner node's right child ends just before it, the left one before that.
pub(super) struct Node2 {
    pub bounds: Bounds,
    /// Inner: nodes of the right subtree. Leaf: first primitive.
    pub link: u32,
    /// Inner: 0.
    pub count: u32,
}

/// Builds the tree over all usable primitives. The caller reorders its records by `triangle_order`, `sphere_order` and
/// `disc_order`. Errors: more than 2^26 primitives.
pub fn build(primitives: &Primitives) -> Result<(Bvh, BuildReport), Error> {
    let (bvh, report) = build_unchecked(primitives)?;
    #[cfg(debug_assertions)]
    if let Err(broken) = super::validate::validate(&bvh, primitives, &report) {
        panic!("the tree just built is not valid: {broken}");
    }
    Ok((bvh, report))
}

/// `build` without the validation that debug assertions add: what the bench times.
pub fn build_unchecked(primitives: &Primitives) -> Result<(Bvh, BuildReport), Error> {
    let count = primitives.len();
    if count > MAX_PRIMITIVES {
        return Err(Error::TooManyPrimitives { count });
    }
    let (mut refs, report) = usable_primitives(primitives);
    let mut nodes = Vec::new();
    if !refs.is_empty() {
        let levels = sah_depth(refs.len());
        nodes = subtree(&mut refs, 0, levels);
    }
    let leaf_order: Vec<(u32, u32)> = refs.iter().map(|r| (kind(r), r.id() & ((1 << KIND_SHIFT) - 1))).collect();
    drop(refs);
    Ok((wide::collapse(&nodes, &leaf_order), report))
}

/// Levels on which SAH may cut; deeper, the median does.
fn sah_depth(count: usize) -> u32 {
    2 * count.ilog2() + 8
}

fn kind(r: &Ref) -> u32 {
    r.id() >> KIND_SHIFT
}

enum Unusable {
    ZeroArea,
    NonFinite,
    OutOfRange,
}

fn usable_primitives(p: &Primitives) -> (Vec<Ref>, BuildReport) {
    let id = |kind: u32, i: usize| kind << KIND_SHIFT | i as u32;
    let triangles = p.triangles.par_iter().enumerate().map(|(i, t)| triangle_ref(t, id(KIND_TRIANGLE, i)));
    let spheres = p.spheres.par_iter().enumerate().map(|(i, s)| sphere_ref(s, id(KIND_SPHERE, i)));
    let discs = p.discs.par_iter().enumerate().map(|(i, d)| disc_ref(d, id(KIND_DISC, i)));
    let placed = p.instances.par_iter().enumerate().map(|(i, b)| instance_ref(b, id(KIND_INSTANCE, i)));
    let tried: Vec<Result<Ref, Unusable>> = triangles.chain(spheres).chain(discs).chain(placed).collect();
    let mut report = BuildReport::default();
    let mut refs = Vec::with_capacity(tried.len());
    for r in tried {
        match r {
            Ok(r) => refs.push(r),
            Err(Unusable::ZeroArea) => report.zero_area += 1,
            Err(Unusable::NonFinite) => report.non_finite += 1,
            Err(Unusable::OutOfRange) => report.out_of_range += 1,
        }
    }
    (refs, report)
}

fn check_range(values: &[f32]) -> Result<(), Unusable> {
    if values.iter().any(|v| !v.is_finite()) {
        return Err(Unusable::NonFinite);
    }
    if values.iter().any(|v| v.abs() > MAX_COORDINATE) {
        return Err(Unusable::OutOfRange);
    }
    Ok(())
}

fn triangle_ref(t: &[[f32; 3]; 3], id: u32) -> Result<Ref, Unusable> {
    check_range(t.as_flattened())?;
    let [a, b, c] = t.map(|v| DVec3::from(v.map(f64::from)));
    if (b - a).cross(c - a) == DVec3::ZERO {
        return Err(Unusable::ZeroArea);
    }
    let lo: [f32; 3] = std::array::from_fn(|k| t[0][k].min(t[1][k]).min(t[2][k]));
    let hi: [f32; 3] = std::array::from_fn(|k| t[0][k].max(t[1][k]).max(t[2][k]));
    Ok(padded(lo, hi, id))
}

fn sphere_ref(&(center, radius): &([f32; 3], f32), id: u32) -> Result<Ref, Unusable> {
    check_range(&[center[0], center[1], center[2], radius])?;
    if radius < 0.0 {
        return Err(Unusable::NonFinite);
    }
    if radius == 0.0 {
        return Err(Unusable::ZeroArea);
    }
    Ok(padded(center.map(|c| c - radius), center.map(|c| c + radius), id))
}

fn disc_ref(d: &Disc, id: u32) -> Result<Ref, Unusable> {
    check_range(d.center.as_slice())?;
    check_range(&[d.normal[0], d.normal[1], d.normal[2], d.radius])?;
    if d.radius < 0.0 {
        return Err(Unusable::NonFinite);
    }
    // The test compares squares (shaders/bvh/disc.glsl).
    if d.radius * d.radius == 0.0 || d.normal == [0.0; 3] {
        return Err(Unusable::ZeroArea);
    }
    let half = d.half_extent();
    // `padded` adds an ulp, which covers the rounding to f32 here.
    let corner = |sign: f64| std::array::from_fn(|k| (f64::from(d.center[k]) + sign * half[k]) as f32);
    Ok(padded(corner(-1.0), corner(1.0), id))
}

/// Its box comes padded (`two_level`); that of a mesh without a usable triangle is inside out.
fn instance_ref([lo, hi]: &[[f32; 3]; 2], id: u32) -> Result<Ref, Unusable> {
    if (0..3).any(|k| lo[k] > hi[k]) {
        return Err(Unusable::ZeroArea);
    }
    check_range(lo)?;
    check_range(hi)?;
    Ok(Ref::new(*lo, *hi, id))
}

/// The box grown by `BOX_PADDING` of its largest side and by one ulp, which covers the rounding of the padding itself.
fn padded(lo: [f32; 3], hi: [f32; 3], id: u32) -> Ref {
    let size = (hi[0] - lo[0]).max(hi[1] - lo[1]).max(hi[2] - lo[2]);
    let padding = size * BOX_PADDING;
    Ref::new(lo.map(|v| (v - padding).next_down()), hi.map(|v| (v + padding).next_up()), id)
}

/// The subtree over `refs`, whose first has number `first` in leaf order; `levels` on which SAH may still cut.
fn subtree(refs: &mut [Ref], first: u32, levels: u32) -> Vec<Node2> {
    if refs.len() < PARALLEL_BUILD {
        let mut nodes = Vec::with_capacity(refs.len());
        append_subtree(refs, first, levels, &mut nodes);
        return nodes;
    }
    let extent = sah::extent(refs);
    // So many primitives are never a leaf.
    let middle = cut(refs, &extent, levels).unwrap_or(refs.len() / 2);
    let (left, right) = refs.split_at_mut(middle);
    let below = levels.saturating_sub(1);
    let (mut nodes, mut right) =
        rayon::join(|| subtree(left, first, below), || subtree(right, first + middle as u32, below));
    let link = right.len() as u32;
    nodes.append(&mut right);
    nodes.push(Node2 { bounds: extent.bounds, link, count: 0 });
    nodes
}

fn append_subtree(refs: &mut [Ref], first: u32, levels: u32, nodes: &mut Vec<Node2>) {
    let extent = sah::extent(refs);
    let Some(middle) = cut(refs, &extent, levels) else {
        nodes.push(Node2 { bounds: extent.bounds, link: first, count: refs.len() as u32 });
        return;
    };
    let (left, right) = refs.split_at_mut(middle);
    append_subtree(left, first, levels.saturating_sub(1), nodes);
    let before = nodes.len();
    append_subtree(right, first + middle as u32, levels.saturating_sub(1), nodes);
    nodes.push(Node2 { bounds: extent.bounds, link: (nodes.len() - before) as u32, count: 0 });
}

/// Orders `refs` into a left and a right part, neither empty, and says where the right one begins; None for a leaf.
fn cut(refs: &mut [Ref], extent: &sah::Extent, levels: u32) -> Option<usize> {
    let count = refs.len();
    if count == 1 {
        return None;
    }
    let first = kind(&refs[0]);
    let is_mixed = count <= MAX_LEAF && refs.iter().any(|r| kind(r) != first);
    // An instance is alone in its leaf.
    let can_be_leaf = count <= MAX_LEAF && !is_mixed && first != KIND_INSTANCE;
    if levels > 0
        && let Some(split) = sah::best_split(refs, extent)
    {
        if can_be_leaf && count as f64 <= sah::NODE_COST + split.cost {
            return None;
        }
        return Some(partition(refs, |r| split.is_left(r)));
    }
    if can_be_leaf {
        return None;
    }
    if is_mixed {
        return Some(partition(refs, |r| kind(r) == first));
    }
    let axis = sah::widest_axis(&extent.centroids);
    refs.select_nth_unstable_by(count / 2, sah::median_order(axis));
    Some(count / 2)
}

/// Moves what `is_left` to the front, and says how many they are.
fn partition(refs: &mut [Ref], is_left: impl Fn(&Ref) -> bool) -> usize {
    let (mut begin, mut end) = (0, refs.len());
    while begin < end {
        if is_left(&refs[begin]) {
            begin += 1;
        } else {
            end -= 1;
            refs.swap(begin, end);
        }
    }
    begin
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(n: usize) -> Vec<[[f32; 3]; 3]> {
        let corner = |i: usize, j: usize| [i as f32, ((i * 7 + j * 3) % 5) as f32 * 0.1, j as f32];
        (0..n * n)
            .flat_map(|k| {
                let (i, j) = (k / n, k % n);
                [
                    [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1)],
                    [corner(i, j), corner(i + 1, j + 1), corner(i, j + 1)],
                ]
            })
            .collect()
    }

    fn only(triangles: &[[[f32; 3]; 3]]) -> Primitives<'_> {
        Primitives { triangles, ..Primitives::default() }
    }

    // Every build below is validated by `build` itself, under debug assertions.

    #[test]
    fn an_empty_scene_has_a_root_without_children() {
        let (bvh, report) = build(&Primitives::default()).unwrap();
        assert_eq!((bvh.nodes.as_slice(), bvh.depth, report.dropped()), (&[crate::bvh::Node4::EMPTY][..], 1, 0));
    }

    #[test]
    fn unusable_primitives_are_dropped_and_counted() {
        let good = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let with = |v: f32| [[v, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let line = [[0.0; 3], [1.0; 3], [2.0; 3]];
        let tiny = good.map(|v| v.map(|c| c * 1e-30));
        let triangles = [good, with(f32::NAN), with(f32::INFINITY), with(1e30), line, [[3.0; 3]; 3], tiny, good];
        let spheres = [([0.0; 3], 1.0), ([0.0; 3], f32::NAN), ([0.0; 3], -1.0), ([0.0; 3], 0.0), ([0.0; 3], 1e30)];
        let up = [0.0, 0.0, 1.0];
        let disc = |radius: f32, normal| Disc { center: [1.0; 3], normal, radius };
        let discs = [disc(1.0, up), disc(f32::NAN, up), disc(1e-30, up), disc(1.0, [0.0; 3]), disc(1e20, up)];
        let (bvh, report) =
            build(&Primitives { triangles: &triangles, spheres: &spheres, discs: &discs, ..Primitives::default() })
                .unwrap();
        assert_eq!(report, BuildReport { zero_area: 5, non_finite: 5, out_of_range: 3 });
        let mut kept = bvh.triangle_order.clone();
        kept.sort_unstable();
        assert_eq!((kept, bvh.sphere_order, bvh.disc_order), (vec![0, 6, 7], vec![0], vec![0]));
    }

    #[test]
    fn hostile_sets_are_survived_at_a_bounded_depth() {
        let unit = [[0.0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let scaled = |s: f32| unit.map(|v| v.map(|c| c * s));
        let same: Vec<_> = vec![unit; 5000];
        // Each triangle is 1.5 times as large as the last: SAH cuts one off at a time.
        let geometric: Vec<_> = (0..5000).map(|i| scaled(1.5f32.powi(i % 200 - 100))).collect();
        let huge: Vec<_> = (1..300).map(|i| scaled(1e15 * i as f32)).collect();
        let denormal: Vec<_> = (1..300).map(|i| scaled(1e-44 * i as f32)).collect();
        for triangles in [same, geometric, huge, denormal] {
            let (bvh, _) = build(&only(&triangles)).unwrap();
            assert!(bvh.depth <= 3 * triangles.len().ilog2() + 10, "depth {} of {}", bvh.depth, triangles.len());
        }
    }

    #[test]
    fn kinds_do_not_mix_in_a_leaf() {
        let triangles = grid(20);
        let spheres: Vec<_> = (0..500).map(|i| ([(i % 20) as f32, 0.2, (i / 20) as f32], 0.3)).collect();
        let discs = [Disc { center: [3.5, 0.1, 3.5], normal: [0.6, 0.8, 0.0], radius: 0.5 }; 2];
        let all = Primitives { triangles: &triangles, spheres: &spheres, discs: &discs, ..Primitives::default() };
        let (bvh, report) = build(&all).unwrap();
        let counts = [bvh.triangle_order.len(), bvh.sphere_order.len(), bvh.disc_order.len(), report.dropped()];
        assert_eq!(counts, [800, 500, 2, 0]);
        // All at one place: only the kind can part them.
        let spheres = [([3.5, 0.1, 3.5], 0.5); 3];
        build(&Primitives {
            triangles: &[triangles[126]; 3],
            spheres: &spheres,
            discs: &discs,
            ..Primitives::default()
        })
        .unwrap();
    }

    #[test]
    fn the_tree_does_not_depend_on_the_number_of_threads() {
        let triangles = grid(220);
        let pool = |n| rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
        let one = pool(1).install(|| build(&only(&triangles)).unwrap().0);
        let four = pool(4).install(|| build(&only(&triangles)).unwrap().0);
        assert!(one.nodes == four.nodes && one.triangle_order == four.triangle_order && one.depth == four.depth);
    }
}
