//! Collapses the binary tree to four children a node: the child of largest surface area is opened until four are there.
//!
//! Wald, Benthin, Boulos 2008, "Getting rid of packets", Section 3.1. Nodes lie in depth-first order, and leaves number their
//! primitives in the same order, so that neighbours in space are neighbours in memory.

use super::build::Node2;
use super::{Bvh, KIND_DISC, KIND_INSTANCE, KIND_SPHERE, KIND_TRIANGLE, Node4, leaf_word};

/// `nodes` in post-order (the root last, empty for no primitive), `leaf_order` (kind, number) as the leaves refer to them.
pub(super) fn collapse(nodes: &[Node2], leaf_order: &[(u32, u32)]) -> Bvh {
    let mut bvh = Bvh { nodes: vec![Node4::EMPTY], depth: 1, ..Bvh::default() };
    if nodes.is_empty() {
        return bvh;
    }
    let root = nodes.len() - 1;
    // (binary node, wide parent and slot that waits for it, depth)
    let mut open = Vec::new();
    let mut children = Vec::with_capacity(4);
    widest_children(nodes, root, &mut children);
    fill(&mut bvh, 0, nodes, &children, leaf_order, 1, &mut open);
    while let Some((node, parent, slot, depth)) = open.pop() {
        let index = bvh.nodes.len();
        bvh.nodes[parent].child[slot] = index as u32;
        bvh.nodes.push(Node4::EMPTY);
        bvh.depth = bvh.depth.max(depth);
        widest_children(nodes, node, &mut children);
        fill(&mut bvh, index, nodes, &children, leaf_order, depth, &mut open);
    }
    bvh
}

/// Up to four descendants that together cover `node`; the node itself when it is a leaf.
fn widest_children(nodes: &[Node2], node: usize, children: &mut Vec<usize>) {
    children.clear();
    children.push(node);
    while children.len() < 4 {
        let area = |c: &usize| nodes[*c].bounds.half_area();
        let inner = (0..children.len()).filter(|&k| nodes[children[k]].count == 0);
        let Some(widest) = inner.max_by(|&a, &b| area(&children[a]).total_cmp(&area(&children[b]))) else {
            return;
        };
        let opened = children[widest];
        children[widest] = opened - 1 - nodes[opened].link as usize;
        children.insert(widest + 1, opened - 1);
    }
}

fn fill(
    bvh: &mut Bvh,
    index: usize,
    nodes: &[Node2],
    children: &[usize],
    leaf_order: &[(u32, u32)],
    depth: u32,
    open: &mut Vec<(usize, usize, usize, u32)>,
) {
    for (slot, &c) in children.iter().enumerate() {
        let (b, wide) = (&nodes[c].bounds, &mut bvh.nodes[index]);
        (wide.min_x[slot], wide.max_x[slot]) = (b.lo.x, b.hi.x);
        (wide.min_y[slot], wide.max_y[slot]) = (b.lo.y, b.hi.y);
        (wide.min_z[slot], wide.max_z[slot]) = (b.lo.z, b.hi.z);
        let count = nodes[c].count as usize;
        if count > 0 {
            let first = nodes[c].link as usize;
            let kind = leaf_order[first].0;
            let order = match kind {
                KIND_TRIANGLE => &mut bvh.triangle_order,
                KIND_SPHERE => &mut bvh.sphere_order,
                KIND_DISC => &mut bvh.disc_order,
                _ => &mut bvh.instance_order,
            };
            // Row 0 of the instances is the world.
            let first_row = order.len() + usize::from(kind == KIND_INSTANCE);
            wide.child[slot] = leaf_word(kind, first_row, count);
            order.extend(leaf_order[first..first + count].iter().map(|p| p.1));
        }
    }
    // Pushed last to first, so that the first child is the next in memory.
    for (slot, &c) in children.iter().enumerate().rev() {
        if nodes[c].count == 0 {
            open.push((c, index, slot, depth + 1));
        }
    }
}
