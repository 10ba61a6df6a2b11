//! Bounding volume hierarchy, built on the CPU: binned SAH (Wald 2007), collapsed to four children a node.
//!
//! A node is 7 rows (112 bytes): rows 0..=5 hold min x, max x, min y, max y, min z, max z of the four children, row 6 the four
//! child words. Child word: 0 = empty; bit 31 set = leaf, bits 30..29 kind (0 triangles, 1 spheres), bits 28..26 count - 1,
//! bits 25..0 first primitive in leaf order of that kind; else the index of an inner node (never 0, which is the root).

pub const CHILD_EMPTY: u32 = 0;
pub const LEAF_BIT: u32 = 1 << 31;
pub const LEAF_KIND_SHIFT: u32 = 29;
pub const LEAF_COUNT_SHIFT: u32 = 26;
pub const LEAF_FIRST_MASK: u32 = (1 << 26) - 1;

/// Axis-aligned boxes of four children and where they lead. 112 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Node4 {
    pub min_x: [f32; 4],
    pub max_x: [f32; 4],
    pub min_y: [f32; 4],
    pub max_y: [f32; 4],
    pub min_z: [f32; 4],
    pub max_z: [f32; 4],
    pub child: [u32; 4],
}

/// The tree and the order it wants its primitives in.
#[derive(Clone, Debug, Default)]
pub struct Bvh {
    pub nodes: Vec<Node4>,
    /// Leaf order: the i-th triangle in the table is input triangle `triangle_order[i]`.
    pub triangle_order: Vec<u32>,
    pub sphere_order: Vec<u32>,
    /// Longest path from the root in nodes: the traversal stack needs 3 entries a level.
    pub depth: u32,
}
