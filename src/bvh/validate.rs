//! What every traversal relies on, checked after each build in tests and debug builds.
//!
//! Each usable primitive lies in exactly one leaf, each box holds what is below it, kinds do not mix, `depth` is the longest
//! path, every node but the roots has one parent, and an empty slot has a box that no ray enters. With two levels this holds for the
//! upper one over the instances' boxes and for each mesh's; that those boxes hold the meshes is checked in `two_level`.

use super::{BuildReport, Bvh, KIND_DISC, KIND_INSTANCE, KIND_SPHERE, KIND_TRIANGLE, LEAF_BIT, Primitives, leaf_range};

#[derive(Debug, thiserror::Error)]
#[error("node {node}, slot {slot}: {what}")]
pub struct Broken {
    pub node: usize,
    pub slot: usize,
    pub what: String,
}

type Box3 = ([f32; 3], [f32; 3]);

struct Walk<'a> {
    bvh: &'a Bvh,
    primitives: &'a Primitives<'a>,
    seen_nodes: Vec<bool>,
    /// By kind and number.
    seen: [Vec<bool>; 4],
    depth: u32,
}

/// Checks the tree against the primitives it was built from.
pub fn validate(bvh: &Bvh, primitives: &Primitives, report: &BuildReport) -> Result<(), Broken> {
    let fail = |what: String| Err(Broken { node: 0, slot: 0, what });
    if bvh.nodes.is_empty() {
        return fail("no root".into());
    }
    let kept = bvh.triangle_order.len() + bvh.sphere_order.len() + bvh.disc_order.len() + bvh.instance_order.len();
    if kept + report.dropped() != primitives.len() {
        return fail(format!("{kept} kept and {} dropped of {}", report.dropped(), primitives.len()));
    }
    let counts =
        [primitives.triangles.len(), primitives.spheres.len(), primitives.discs.len(), primitives.instances.len()];
    let mut walk = Walk {
        bvh,
        primitives,
        seen_nodes: vec![false; bvh.nodes.len()],
        seen: counts.map(|count| vec![false; count]),
        depth: 0,
    };
    walk.node(0, 1)?;
    if walk.depth != bvh.depth {
        return fail(format!("depth {} is stored, {} is right", bvh.depth, walk.depth));
    }
    walk.depth = 0;
    for &root in &bvh.roots {
        walk.node(root as usize, 1)?;
    }
    if walk.depth != bvh.mesh_depth {
        return fail(format!("depth {} of the meshes is stored, {} is right", bvh.mesh_depth, walk.depth));
    }
    let leaves = walk.seen.iter().flatten().filter(|s| **s).count();
    if leaves != kept {
        return fail(format!("{leaves} primitives in leaves, {kept} in the order"));
    }
    if walk.seen_nodes.iter().any(|s| !s) {
        return fail("a node without a parent".into());
    }
    Ok(())
}

impl Walk<'_> {
    /// The box of all that is below; recursion is bounded by the depth that `build` bounds.
    fn node(&mut self, index: usize, depth: u32) -> Result<Box3, Broken> {
        let fail = |slot: usize, what: String| Err(Broken { node: index, slot, what });
        if std::mem::replace(&mut self.seen_nodes[index], true) {
            return fail(0, "two parents".into());
        }
        self.depth = self.depth.max(depth);
        let n = self.bvh.nodes[index];
        let mut whole = EMPTY;
        for slot in 0..4 {
            let lo = [n.min_x[slot], n.min_y[slot], n.min_z[slot]];
            let hi = [n.max_x[slot], n.max_y[slot], n.max_z[slot]];
            let word = n.child[slot];
            if word == 0 {
                if lo != EMPTY.0 || hi != EMPTY.1 {
                    return fail(slot, format!("empty, but its box is {lo:?} {hi:?}"));
                }
                continue;
            }
            if lo.iter().chain(&hi).any(|v| !v.is_finite()) {
                return fail(slot, format!("box {lo:?} {hi:?} is not finite"));
            }
            let inside = if word & LEAF_BIT != 0 {
                self.leaf(word).or_else(|what| fail(slot, what))?
            } else if (word as usize) < self.bvh.nodes.len() {
                self.node(word as usize, depth + 1)?
            } else {
                return fail(slot, format!("leads to node {word} of {}", self.bvh.nodes.len()));
            };
            if (0..3).any(|k| inside.0[k] < lo[k] || inside.1[k] > hi[k]) {
                return fail(slot, format!("box {lo:?} {hi:?} does not hold {inside:?}"));
            }
            whole = union(whole, (lo, hi));
        }
        Ok(whole)
    }

    fn leaf(&mut self, word: u32) -> Result<Box3, String> {
        let (kind, first, count) = leaf_range(word);
        let order = match kind {
            KIND_TRIANGLE => &self.bvh.triangle_order,
            KIND_SPHERE => &self.bvh.sphere_order,
            KIND_DISC => &self.bvh.disc_order,
            KIND_INSTANCE if first > 0 && count == 1 => &self.bvh.instance_order,
            _ => return Err(format!("kind {kind}")),
        };
        let first = first - usize::from(kind == KIND_INSTANCE);
        let range = order.get(first..first + count).ok_or(format!("{first} + {count} of {}", order.len()))?;
        let mut whole = EMPTY;
        for &i in range {
            let i = i as usize;
            if std::mem::replace(&mut self.seen[kind as usize][i], true) {
                return Err(format!("primitive {i} of kind {kind} is in two leaves"));
            }
            match kind {
                KIND_TRIANGLE => self.primitives.triangles[i].iter().for_each(|v| whole = union(whole, (*v, *v))),
                KIND_SPHERE => {
                    let (c, r) = self.primitives.spheres[i];
                    whole = union(whole, (c.map(|c| c - r), c.map(|c| c + r)));
                }
                KIND_INSTANCE => {
                    let [lo, hi] = self.primitives.instances[i];
                    whole = union(whole, (lo, hi));
                }
                _ => {
                    let d = &self.primitives.discs[i];
                    let end = |sign: f64| {
                        let half = d.half_extent();
                        std::array::from_fn(|k| (f64::from(d.center[k]) + sign * half[k]) as f32)
                    };
                    whole = union(whole, (end(-1.0), end(1.0)));
                }
            }
        }
        Ok(whole)
    }
}

const EMPTY: Box3 = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);

fn union(a: Box3, b: Box3) -> Box3 {
    (std::array::from_fn(|k| a.0[k].min(b.0[k])), std::array::from_fn(|k| a.1[k].max(b.1[k])))
}
