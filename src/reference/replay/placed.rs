//! Placed meshes as the replay sees them: each mesh's triangles are gathered from the tree's own nodes below the record's root, and
//! the matrix is the record's `to_world` with an inverse of its own in f64, so that a wrong root or a wrong `to_object` shows.

use std::collections::HashMap;
use std::sync::Arc;

use glam::DVec3;

use super::vec;
use crate::bvh::{CHILD_EMPTY, LEAF_BIT, leaf_range};
use crate::prepare::Prepared;
use crate::prepare::records::*;
use crate::reference::tree::{Placed, Shape, Tree};

/// Which placement a placed triangle's number belongs to.
#[derive(Clone, Debug, Default)]
pub struct Numbers {
    /// (first number, row of `instances`, face of the first number), ascending.
    first: Vec<(u32, u32, u32)>,
}

impl Numbers {
    /// Row of `instances` and face of a number; None for what is flat.
    pub fn find(&self, number: u32) -> Option<(u32, u32)> {
        let place = self.first.partition_point(|f| f.0 <= number).checked_sub(1)?;
        let (first, row, face) = self.first[place];
        Some((row, face + (number - first)))
    }
}

/// A mesh's tree, with the number of its first face and how many there are.
type Mesh = (Arc<Tree>, u32, u32);

/// The placements for the oracle's tree, and the way back from their numbers.
pub fn trees(p: &Prepared) -> (Numbers, Vec<Placed>) {
    let mut meshes: HashMap<u32, Mesh> = HashMap::new();
    let (mut numbers, mut placed) = (Numbers::default(), Vec::new());
    for (row, record) in p.instances.iter().enumerate().skip(1) {
        let (tree, face, count) =
            meshes.entry(record.first_node).or_insert_with(|| mesh_below(p, record.first_node)).clone();
        let first = face.wrapping_add(record.primitive_offset);
        numbers.first.push((first, row as u32, face));
        placed.push(Placed::new(tree, record.to_world(), first, count));
    }
    numbers.first.sort_unstable();
    (numbers, placed)
}

fn mesh_below(p: &Prepared, root: u32) -> Mesh {
    let mut triangles = Vec::new();
    let mut open = vec![root];
    while let Some(word) = open.pop() {
        if word & LEAF_BIT != 0 {
            let (_, first, count) = leaf_range(word);
            triangles.extend_from_slice(&p.triangles[first..first + count]);
        } else {
            open.extend(p.bvh.nodes[word as usize].child.iter().filter(|&&w| w != CHILD_EMPTY));
        }
    }
    let first = triangles.iter().map(|t| t.face).min().unwrap_or(0);
    let count = triangles.iter().map(|t| t.face - first + 1).max().unwrap_or(0);
    let shapes = triangles.iter().map(|t| (t.face - first, Shape::Triangle([t.v0, t.v1, t.v2].map(vec)))).collect();
    (Arc::new(Tree::build(shapes)), first, count)
}

/// A placed triangle's corners in the world, counter-clockwise seen from the front; then what its directions go through.
pub struct ToWorld<'a> {
    record: &'a InstanceRecord,
    normals: glam::DMat3,
}

impl<'a> ToWorld<'a> {
    pub fn new(record: &'a InstanceRecord) -> Self {
        Self { record, normals: record.to_world().matrix3.inverse().transpose() }
    }

    pub fn corners(&self, t: &TriangleRecord) -> [DVec3; 3] {
        [t.v0, t.v1, t.v2].map(|v| self.record.to_world().transform_point3(vec(v)))
    }

    pub fn normal(&self, n: DVec3) -> DVec3 {
        (self.normals * n).normalize_or_zero()
    }

    pub fn tangent(&self, t: DVec3) -> DVec3 {
        (self.record.to_world().matrix3 * t).normalize_or_zero()
    }

    /// -1 for a mirror.
    pub fn handedness(&self) -> f64 {
        if self.record.to_world().matrix3.determinant() < 0.0 { -1.0 } else { 1.0 }
    }
}
