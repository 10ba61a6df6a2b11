//! Every triangle, sphere and disc of the scene by number, moved to the world in f64 when it is asked for.
//!
//! Numbers run through the scene's instances in order. A scene of up to `FLAT_LIMIT` primitives is searched flat, so that the matrices
//! that `prepare` makes for placed meshes are held against none at all; beyond, meshes that are used twice have a tree of their own
//! here too, else a million instances would not fit into memory.

use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;

use glam::{DVec2, DVec3};

use crate::reference::tree::{Placed, Shape, Tree};
use crate::scene::{self, Scene};

/// Primitives up to which all are flat: some 300 MB of tree.
pub const FLAT_LIMIT: usize = 1 << 20;

/// Corners of `scene::Shape::Rectangle`, counter-clockwise seen from +z.
pub const RECTANGLE: [DVec2; 4] =
    [DVec2::new(-1.0, -1.0), DVec2::new(1.0, -1.0), DVec2::new(1.0, 1.0), DVec2::new(-1.0, 1.0)];
pub const RECTANGLE_PARTS: [[usize; 3]; 2] = [[0, 1, 2], [0, 2, 3]];

/// One triangle, sphere or disc in the world.
#[derive(Clone, Copy, Debug)]
pub struct Primitive {
    pub shape: Shape,
    pub instance: u32,
    /// Triangle of the mesh; corner pair of a rectangle; 0 for a sphere or disc.
    pub part: u32,
    /// The instance's transform mirrors: then the front is where the winding is clockwise.
    pub is_mirrored: bool,
}

/// The scene's primitives, numbered.
#[derive(Clone, Debug)]
pub struct Primitives<'a> {
    scene: &'a Scene,
    /// By instance, its first number; then the number of them all.
    starts: Vec<u32>,
}

impl<'a> Primitives<'a> {
    /// # Panics
    /// With more than 2^32 primitives, which this oracle cannot number.
    pub fn new(scene: &'a Scene) -> Self {
        let mut starts = vec![0u32];
        for instance in &scene.instances {
            let count = match instance.shape {
                scene::Shape::Mesh(mesh) => scene.meshes[mesh].triangles.len(),
                scene::Shape::Rectangle => RECTANGLE_PARTS.len(),
                scene::Shape::Sphere | scene::Shape::Disc => 1,
            };
            let next = u64::from(starts[starts.len() - 1]) + count as u64;
            starts.push(u32::try_from(next).expect("the oracle numbers up to 2^32 primitives"));
        }
        Self { scene, starts }
    }

    /// Numbers of an instance.
    pub fn of_instance(&self, instance: usize) -> Range<u32> {
        self.starts[instance]..self.starts[instance + 1]
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.starts[self.scene.instances.len()] as usize
    }

    pub fn get(&self, number: u32) -> Primitive {
        let instance = self.instance_of(number);
        self.part(instance, number - self.starts[instance])
    }

    pub fn instance_of(&self, number: u32) -> usize {
        self.starts.partition_point(|&start| start <= number) - 1
    }

    fn part(&self, number: usize, part: u32) -> Primitive {
        let instance = &self.scene.instances[number];
        let to_world = instance.to_world;
        let is_mirrored = to_world.matrix3.determinant() < 0.0;
        let shape = match instance.shape {
            scene::Shape::Mesh(mesh) => {
                Shape::Triangle(corners(&self.scene.meshes[mesh], part).map(|p| to_world.transform_point3(p)))
            }
            scene::Shape::Rectangle => Shape::Triangle(
                RECTANGLE_PARTS[part as usize].map(|i| to_world.transform_point3(RECTANGLE[i].extend(0.0))),
            ),
            scene::Shape::Disc => {
                let (x, y) = (to_world.matrix3.x_axis, to_world.matrix3.y_axis);
                let front = if is_mirrored { y.cross(x) } else { x.cross(y) };
                Shape::Disc { center: to_world.translation, normal: front.normalize(), radius: x.length() }
            }
            scene::Shape::Sphere => {
                Shape::Sphere { center: to_world.translation, radius: to_world.matrix3.x_axis.length() }
            }
        };
        Primitive { shape, instance: number as u32, part, is_mirrored }
    }

    /// The tree over all of them; `is_placed` keeps meshes that are used twice once.
    pub fn tree(&self, is_placed: bool) -> Tree {
        let scene = self.scene;
        let mut uses = vec![0usize; scene.meshes.len()];
        for instance in &scene.instances {
            if let scene::Shape::Mesh(mesh) = instance.shape {
                uses[mesh] += 1;
            }
        }
        let mut meshes: HashMap<usize, Arc<Tree>> = HashMap::new();
        let (mut flat, mut placed) = (Vec::new(), Vec::new());
        for (number, instance) in scene.instances.iter().enumerate() {
            let range = self.of_instance(number);
            match instance.shape {
                scene::Shape::Mesh(mesh) if is_placed && uses[mesh] > 1 => {
                    let tree = meshes.entry(mesh).or_insert_with(|| Arc::new(mesh_tree(&scene.meshes[mesh])));
                    placed.push(Placed::new(tree.clone(), instance.to_world, range.start, range.end - range.start));
                }
                _ => flat.extend(range.clone().map(|n| (n, self.part(number, n - range.start).shape))),
            }
        }
        Tree::build(flat).with_placed(placed)
    }
}

fn corners(mesh: &scene::Mesh, part: u32) -> [DVec3; 3] {
    mesh.triangles[part as usize].map(|i| mesh.positions[i as usize].map(f64::from).into())
}

fn mesh_tree(mesh: &scene::Mesh) -> Tree {
    Tree::build((0..mesh.triangles.len() as u32).map(|part| (part, Shape::Triangle(corners(mesh, part)))).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::scenes;
    use crate::reference::tree::free_ray;

    /// Both ways of searching one scene find the same, to rounding of the way there and back.
    #[test]
    fn placed_and_flat_trees_agree() {
        let scene = scenes::placed(16);
        let primitives = Primitives::new(&scene);
        let (flat, placed) = (primitives.tree(false), primitives.tree(true));
        let mut hits = 0;
        for i in 0..4000 {
            let angle = f64::from(i) * 2.399_963;
            let height = 1.0 - f64::from(i) / 2000.0;
            let r = (1.0 - height * height).max(0.0).sqrt();
            let target = DVec3::new(r * angle.cos(), height, r * angle.sin()) * 1.5;
            let origin = DVec3::new(4.0 * angle.sin(), 3.0, 4.0 * (1.7 * angle).cos());
            let ray = free_ray(origin, (target - origin).normalize());
            let (a, b) = (flat.closest(&ray, None, f64::INFINITY), placed.closest(&ray, None, f64::INFINITY));
            hits += usize::from(a.is_some());
            match (a, b) {
                (None, None) => {}
                (Some(a), Some(b)) => assert!((a.t - b.t).abs() < 1e-9, "{a:?} {b:?}"),
                other => panic!("ray {i}: {other:?}"),
            }
            if let Some(hit) = a {
                let left = crate::reference::tree::Ray { origin: ray.at(hit.t), leaves: hit.primitive, ..ray };
                let (a, b) = (flat.closest(&left, None, f64::INFINITY), placed.closest(&left, None, f64::INFINITY));
                assert_eq!(a.map(|h| h.primitive), b.map(|h| h.primitive), "ray {i} beyond its first hit");
            }
        }
        assert!(hits > 1000, "{hits}");
    }
}
