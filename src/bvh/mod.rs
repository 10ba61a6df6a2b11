//! Bounding volume hierarchy, built on the CPU: binned SAH (Wald 2007), collapsed to four children a node.
//!
//! A node is 7 rows (112 bytes): rows 0..=5 hold min x, max x, min y, max y, min z, max z of the four children, row 6 the four
//! child words. Child word: 0 = empty; bit 31 set = leaf, bits 30..29 kind (0 triangles, 1 spheres, 2 discs, 3 an instance), bits 28..26 count - 1,
//! bits 25..0 first primitive in leaf order of that kind; else the index of an inner node (never 0, which is the root).
//! An empty slot's box is inside out (+inf, -inf), which no ray enters. There is always a root, even of an empty scene.
//!
//! Two levels (`two_level`): a leaf of kind 3 names a row of `instances`; the mesh's own tree follows the top one in the same table of
//! nodes, its leaves number the same table of triangles. Row 0 of `instances` is the world, whose leaf word (`WORLD`) is what the
//! traversal leaves on its stack to come back to.
//!
//! `shaders/bvh/{closest,any}.glsl` walks it on the device, `traverse` in Rust; `validate` states what both rely on.

pub mod brute;
mod build;
mod sah;
pub mod tracer;
pub mod traverse;
pub mod two_level;
pub mod validate;
mod wide;

pub use build::{build, build_unchecked};

use glam::DVec3;

pub const CHILD_EMPTY: u32 = 0;
pub const LEAF_BIT: u32 = 1 << 31;
pub const LEAF_KIND_SHIFT: u32 = 29;
pub const LEAF_COUNT_SHIFT: u32 = 26;
pub const LEAF_FIRST_MASK: u32 = (1 << 26) - 1;
pub const KIND_TRIANGLE: u32 = 0;
pub const KIND_SPHERE: u32 = 1;
pub const KIND_DISC: u32 = 2;
pub const KIND_INSTANCE: u32 = 3;
/// Leaf word of the world itself: the way back from an instance.
pub const WORLD: u32 = LEAF_BIT | KIND_INSTANCE << LEAF_KIND_SHIFT;
/// What a leaf word can number.
pub const MAX_PRIMITIVES: usize = 1 << 26;
/// What three bits can count.
pub const MAX_LEAF: usize = 8;
/// Largest coordinate and radius kept: products of two differences of them, and the error-free split of such a product,
/// must stay finite in f32 (shaders/bvh/triangle.glsl).
pub const MAX_COORDINATE: f32 = (1u64 << 60) as f32;

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

impl Node4 {
    /// Four empty slots.
    pub const EMPTY: Node4 = Node4 {
        min_x: [f32::INFINITY; 4],
        max_x: [f32::NEG_INFINITY; 4],
        min_y: [f32::INFINITY; 4],
        max_y: [f32::NEG_INFINITY; 4],
        min_z: [f32::INFINITY; 4],
        max_z: [f32::NEG_INFINITY; 4],
        child: [CHILD_EMPTY; 4],
    };
}

/// What a tree is built over. A number counts within its kind.
#[derive(Clone, Copy, Debug, Default)]
pub struct Primitives<'a> {
    /// Corners.
    pub triangles: &'a [[[f32; 3]; 3]],
    /// Centre and radius.
    pub spheres: &'a [([f32; 3], f32)],
    pub discs: &'a [Disc],
    /// Lowest and highest corner of each instance.
    pub instances: &'a [[[f32; 3]; 2]],
}

impl Primitives<'_> {
    pub fn len(&self) -> usize {
        self.triangles.len() + self.spheres.len() + self.discs.len() + self.instances.len()
    }

    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// A flat disc. `normal` has unit length to rounding.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disc {
    pub center: [f32; 3],
    pub normal: [f32; 3],
    pub radius: f32,
}

impl Disc {
    /// Half the extent of its box along each axis, in f64: r sqrt(1 - n_k^2).
    pub fn half_extent(&self) -> [f64; 3] {
        let n = self.normal.map(f64::from);
        let length2: f64 = n.iter().map(|c| c * c).sum();
        n.map(|c| f64::from(self.radius) * (1.0 - c * c / length2).max(0.0).sqrt())
    }
}

/// The tree and the order it wants its primitives in.
#[derive(Clone, Debug, Default)]
pub struct Bvh {
    pub nodes: Vec<Node4>,
    /// Leaf order: the i-th triangle in the table is input triangle `triangle_order[i]`. Dropped triangles are absent.
    pub triangle_order: Vec<u32>,
    pub sphere_order: Vec<u32>,
    pub disc_order: Vec<u32>,
    /// Row k + 1 of the instances' table is input instance `instance_order[k]`.
    pub instance_order: Vec<u32>,
    /// Longest path from the root in nodes: the traversal stack needs 3 entries a level.
    pub depth: u32,
    /// By mesh of the lower level: its root in `nodes`, and where its triangles begin in `triangle_order`.
    pub roots: Vec<u32>,
    pub first_triangles: Vec<u32>,
    /// The longest path of any of them.
    pub mesh_depth: u32,
}

impl Bvh {
    /// Triangles of the upper level: those before the first mesh's.
    pub fn flat_triangle_count(&self) -> usize {
        self.first_triangles.first().map_or(self.triangle_order.len(), |&first| first as usize)
    }

    /// Corners of all that is below a node; inside out when nothing is.
    pub fn bounds_below(&self, node: u32) -> [DVec3; 2] {
        let n = &self.nodes[node as usize];
        let corner = |x: [f32; 4], y: [f32; 4], z: [f32; 4]| {
            (0..4).map(move |c| DVec3::new(f64::from(x[c]), f64::from(y[c]), f64::from(z[c])))
        };
        [
            corner(n.min_x, n.min_y, n.min_z).fold(DVec3::INFINITY, DVec3::min),
            corner(n.max_x, n.max_y, n.max_z).fold(DVec3::NEG_INFINITY, DVec3::max),
        ]
    }

    /// Entries of the traversal stack (GLSL constant BVH_STACK): each node on a path leaves at most three siblings behind,
    /// one entry below them says that the stack is empty, and one slot above is written but never kept; an instance adds its mesh's
    /// path and the way back.
    pub fn stack_size(&self) -> u32 {
        let below = if self.roots.is_empty() { 0 } else { 3 * self.mesh_depth + 1 };
        3 * self.depth + 2 + below
    }
}

/// What was dropped before the build.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct BuildReport {
    /// Triangles on a line or a point, spheres of radius 0, discs whose radius has no square in f32.
    pub zero_area: usize,
    /// A coordinate or radius is NaN or infinite; a radius below 0 counts here too.
    pub non_finite: usize,
    /// A coordinate or radius is larger than `MAX_COORDINATE`.
    pub out_of_range: usize,
}

impl BuildReport {
    pub fn dropped(&self) -> usize {
        self.zero_area + self.non_finite + self.out_of_range
    }
}

#[derive(Debug, thiserror::Error, PartialEq, Eq)]
pub enum Error {
    #[error(
        "{count} primitives are more than the {MAX_PRIMITIVES} that a leaf word can number; split the scene or simplify its meshes"
    )]
    TooManyPrimitives { count: usize },
}

/// Word of a leaf of `count` (1..=8) primitives of a kind.
pub fn leaf_word(kind: u32, first: usize, count: usize) -> u32 {
    LEAF_BIT | kind << LEAF_KIND_SHIFT | ((count - 1) as u32) << LEAF_COUNT_SHIFT | first as u32
}

/// (kind, first, count) of a leaf word.
pub fn leaf_range(word: u32) -> (u32, usize, usize) {
    let count = (word >> LEAF_COUNT_SHIFT & 7) + 1;
    (word >> LEAF_KIND_SHIFT & 3, (word & LEAF_FIRST_MASK) as usize, count as usize)
}
