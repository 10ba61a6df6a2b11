//! Which meshes are kept once and placed many times, and the records of the placements.
//!
//! A placed mesh costs 128 bytes a placement and a node of the upper tree in place of its triangles, and in time: the ray is taken into
//! its space at each visit, code that every ray of the scene carries. So `Instancing::Auto` places meshes only where that saves
//! `SAVED_TRIANGLES` in all; below, flat is faster and fits any cache that matters. A mesh qualifies by two uses or more whose triangles
//! outweigh the placements. An instance that emits is flattened always: lights are sampled in world space, and their records name
//! one triangle each. So is one whose matrix is nearly singular to f32, whose error bounds would be as large as itself.
//! The picture does not depend on the choice but in rounding and in the random numbers of alpha.

use glam::{DAffine3, DMat3, DVec3};

use super::Prepared;
use super::geometry::Geometry;
use super::records::*;
use crate::bvh::Bvh;
use crate::bvh::two_level::{Placement, world_box};
use crate::integrator::Instancing;
use crate::scene::{Projection, Scene, Shape};

/// About 200 bytes each (triangle, face, its share of nodes and vertices): 100 MB.
const SAVED_TRIANGLES: usize = 1 << 19;
/// Bytes of a flat triangle and of a placement in the tables, nodes included.
const TRIANGLE_BYTES: usize = 120;
const PLACEMENT_BYTES: usize = 180;
/// Largest product of the norms of a matrix and its inverse: of eleven decimal bits of f32, ten are left.
const MAX_CONDITION: f64 = 1e4;
/// Scales and places outside lose digits to the ends of f32 in the triangle test.
const MAX_SIZE: f64 = 1e15;

/// What is placed and what is flattened.
#[derive(Clone, Debug, Default)]
pub struct Plan {
    /// By instance of the scene: position in `meshes`, or NONE when it is flattened.
    pub placed: Vec<u32>,
    /// The scene's meshes that are kept once.
    pub meshes: Vec<usize>,
}

/// Decides. `emits` answers for a material's number.
pub fn plan(scene: &Scene, origin: DVec3, instancing: Instancing, emits: impl Fn(usize) -> bool) -> Plan {
    let flat = Plan { placed: vec![NONE; scene.instances.len()], meshes: Vec::new() };
    let metered: &[usize] = match &scene.camera.projection {
        Projection::MeterSurface(meter) | Projection::MeterLeaving(meter) => &meter.shapes,
        _ => &[],
    };
    let mut uses = vec![0usize; scene.meshes.len()];
    let candidates: Vec<Option<usize>> = scene
        .instances
        .iter()
        .enumerate()
        .map(|(number, i)| match i.shape {
            // A surface meter begins its rays on flat triangles.
            Shape::Mesh(_) if metered.contains(&number) => None,
            Shape::Mesh(mesh) if !emits(i.material) && is_well_conditioned(&rebased(&i.to_world, origin)) => Some(mesh),
            _ => None,
        })
        .collect();
    candidates.iter().flatten().for_each(|&mesh| uses[mesh] += 1);
    let is_kept = |mesh: usize| {
        let (count, triangles) = (uses[mesh], scene.meshes[mesh].triangles.len());
        let pays = count.saturating_sub(1) * triangles * TRIANGLE_BYTES > count * PLACEMENT_BYTES;
        count >= 2 && (pays || instancing == Instancing::Always)
    };
    let meshes: Vec<usize> = (0..scene.meshes.len()).filter(|&m| is_kept(m)).collect();
    let saved: usize = meshes.iter().map(|&m| (uses[m] - 1) * scene.meshes[m].triangles.len()).sum();
    let is_worth_it = match instancing {
        Instancing::Auto => saved >= SAVED_TRIANGLES,
        Instancing::Always => !meshes.is_empty(),
        Instancing::Never => false,
    };
    if !is_worth_it {
        return flat;
    }
    let mut row = vec![NONE; scene.meshes.len()];
    (0..).zip(&meshes).for_each(|(number, &mesh)| row[mesh] = number);
    Plan { placed: candidates.iter().map(|c| c.map_or(NONE, |mesh| row[mesh])).collect(), meshes }
}

/// Seen from the camera; subtracted in f64.
pub fn rebased(to_world: &DAffine3, origin: DVec3) -> DAffine3 {
    DAffine3 { translation: to_world.translation - origin, ..*to_world }
}

fn norm(m: &DMat3) -> f64 {
    (m.x_axis.length_squared() + m.y_axis.length_squared() + m.z_axis.length_squared()).sqrt()
}

fn is_well_conditioned(to_world: &DAffine3) -> bool {
    let (forth, back) = (norm(&to_world.matrix3), norm(&to_world.matrix3.inverse()));
    to_world.is_finite()
        && forth.max(back).max(to_world.translation.abs().max_element()) < MAX_SIZE
        && forth * back < MAX_CONDITION
}

/// A placement before the tree orders it.
#[derive(Clone, Copy, Debug)]
pub struct Placed {
    /// Position in `Plan::meshes`.
    pub mesh: u32,
    /// The matrix rounded to f32, which from here on is the truth, and its inverse.
    pub to_world: DAffine3,
    pub to_object: DAffine3,
    pub material: u32,
    /// Number in the scene's instances.
    pub object: u32,
    /// Number of its first triangle; see `number`.
    pub first_primitive: u32,
}

impl Placed {
    pub fn new(mesh: u32, to_world: &DAffine3, material: u32, object: u32) -> Self {
        let rounded = |v: DVec3| v.as_vec3().as_dvec3();
        let m = &to_world.matrix3;
        let to_world = DAffine3 {
            matrix3: DMat3::from_cols(rounded(m.x_axis), rounded(m.y_axis), rounded(m.z_axis)),
            translation: rounded(to_world.translation),
        };
        Self { mesh, to_world, to_object: to_world.inverse(), material, object, first_primitive: 0 }
    }

    pub fn placement(&self) -> Placement {
        Placement { mesh: self.mesh, to_world: self.to_world }
    }
}

/// The table of instances in the order of the tree, the world first; empty when nothing is placed.
pub fn records(g: &Geometry, bvh: &Bvh) -> Vec<InstanceRecord> {
    if g.placed.is_empty() {
        return Vec::new();
    }
    let record = |&k: &u32| {
        let placed = &g.placed[k as usize];
        let [to_world0, to_world1, to_world2] = rows(&placed.to_world);
        let [to_object0, to_object1, to_object2] = rows(&placed.to_object);
        let is_mirrored = placed.to_world.matrix3.determinant() < 0.0;
        InstanceRecord {
            to_world0,
            to_world1,
            to_world2,
            to_object0,
            to_object1,
            to_object2,
            first_node: bvh.roots[placed.mesh as usize],
            material: placed.material,
            flags: INSTANCE_VISIBLE_TO_ALL | if is_mirrored { INSTANCE_MIRRORED } else { 0 },
            primitive_offset: placed.first_primitive.wrapping_sub(g.mesh_faces[placed.mesh as usize].start as u32),
            object: placed.object,
            motion: NONE,
            media: [NONE; 2],
        }
    };
    std::iter::once(WORLD_RECORD).chain(bvh.instance_order.iter().map(record)).collect()
}

/// Numbers placed triangles in the order of the scene's instances, behind everything flat. A scene of more than 2^32 begins again there:
/// such numbers order hits at the very same distance, feed the hash of alpha and name objects (which is then said), and never a light.
pub fn number(g: &mut Geometry, notes: &mut Vec<String>) {
    let first = g.flat_primitive_count();
    let mut next = first;
    let mut begins_again = false;
    for placed in &mut g.placed {
        let count = g.mesh_faces[placed.mesh as usize].len() as u64;
        if next + count > u64::from(NONE) {
            next = first;
            begins_again = true;
        }
        placed.first_primitive = next as u32;
        next += count;
        if !begins_again {
            g.objects.push((placed.first_primitive, placed.object));
        }
    }
    if begins_again {
        notes.push("more than 2^32 triangles are placed: beyond, object ids are those of others".to_owned());
    }
}

fn rows(m: &DAffine3) -> [[f32; 4]; 3] {
    let (l, t) = (m.matrix3, m.translation);
    [0, 1, 2].map(|r| [l.x_axis[r] as f32, l.y_axis[r] as f32, l.z_axis[r] as f32, t[r] as f32])
}

/// Row 0: flat geometry, where it is.
pub const WORLD_RECORD: InstanceRecord = InstanceRecord {
    to_world0: [1.0, 0.0, 0.0, 0.0],
    to_world1: [0.0, 1.0, 0.0, 0.0],
    to_world2: [0.0, 0.0, 1.0, 0.0],
    to_object0: [1.0, 0.0, 0.0, 0.0],
    to_object1: [0.0, 1.0, 0.0, 0.0],
    to_object2: [0.0, 0.0, 1.0, 0.0],
    first_node: 0,
    material: 0,
    flags: INSTANCE_VISIBLE_TO_ALL,
    primitive_offset: 0,
    object: NONE,
    motion: NONE,
    media: [NONE; 2],
};

impl InstanceRecord {
    /// The decoded matrices.
    pub fn to_world(&self) -> DAffine3 {
        affine([self.to_world0, self.to_world1, self.to_world2])
    }

    pub fn to_object(&self) -> DAffine3 {
        affine([self.to_object0, self.to_object1, self.to_object2])
    }
}

impl Prepared {
    /// Rows of `triangles` of the mesh that a record places.
    pub fn mesh_triangles(&self, record: &InstanceRecord) -> std::ops::Range<usize> {
        let starts = &self.bvh.first_triangles;
        let mesh = self.bvh.roots.partition_point(|&root| root < record.first_node);
        let end = starts.get(mesh + 1).map_or(self.triangles.len(), |&next| next as usize);
        starts[mesh] as usize..end
    }

    /// Triangles that all placements stand for.
    pub fn placed_triangle_count(&self) -> u64 {
        self.instances.iter().skip(1).map(|m| self.mesh_triangles(m).len() as u64).sum()
    }

    /// Corners in the world, counter-clockwise seen from the front, and materials of the triangles that a ray from the origin may meet:
    /// all flat ones, and those of placed meshes whose boxes it meets.
    pub fn triangles_towards(&self, direction: DVec3) -> impl Iterator<Item = ([DVec3; 3], u32)> {
        let vector = |v: [f32; 3]| DVec3::from(v.map(f64::from));
        let flat = self.flat_triangles().iter().map(move |t| ([t.v0, t.v1, t.v2].map(vector), t.material));
        let is_met = move |m: &&InstanceRecord| {
            let [lo, hi] = world_box(&m.to_world(), self.bvh.bounds_below(m.first_node));
            let (a, b) = (lo / direction, hi / direction);
            a.min(b).max_element() <= a.max(b).min_element()
        };
        let placed = self.instances.iter().skip(1).filter(is_met).flat_map(move |m| {
            let (to_world, is_mirrored) = (m.to_world(), m.flags & INSTANCE_MIRRORED != 0);
            self.triangles[self.mesh_triangles(m)].iter().map(move |t| {
                let [a, b, c] = [t.v0, t.v1, t.v2].map(|v| to_world.transform_point3(vector(v)));
                (if is_mirrored { [a, c, b] } else { [a, b, c] }, m.material)
            })
        });
        flat.chain(placed)
    }
}

fn affine(rows: [[f32; 4]; 3]) -> DAffine3 {
    let column = |c: usize| DVec3::from(rows.map(|r| f64::from(r[c])));
    DAffine3 { matrix3: DMat3::from_cols(column(0), column(1), column(2)), translation: column(3) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::integrator::Settings;
    use crate::reference::known::{lambert, lamp, place};
    use glam::DQuat;

    /// `count` copies of a mesh of one triangle, turned and mirrored, and a lamp of the same mesh.
    fn copies(count: usize) -> Scene {
        let mut scene = Scene::default();
        scene.meshes.push(crate::scene::Mesh {
            positions: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            triangles: vec![[0, 1, 2]],
            ..Default::default()
        });
        for i in 0..count {
            let scale = DVec3::new(1.0, 2.0, if i % 2 == 0 { 1.0 } else { -0.5 });
            let to_world = DAffine3::from_scale_rotation_translation(
                scale,
                DQuat::from_rotation_x(i as f64),
                DVec3::new(3.0 * i as f64, 0.0, -10.0),
            );
            place(&mut scene, "copy", Shape::Mesh(0), to_world, lambert(DVec3::ONE));
        }
        place(&mut scene, "lamp", Shape::Mesh(0), DAffine3::IDENTITY, lamp(DVec3::ONE));
        scene
    }

    fn prepared(scene: &Scene, instancing: Instancing) -> Prepared {
        super::super::prepare(scene, &Settings { instancing, ..Settings::default() }).unwrap()
    }

    #[test]
    fn emitters_and_singular_placements_stay_flat() {
        let mut scene = copies(4);
        scene.instances[1].to_world.matrix3 *= DMat3::from_diagonal(DVec3::new(1.0, 1.0, 1e-9));
        let p = prepared(&scene, Instancing::Always);
        assert_eq!((p.instances.len(), p.bvh.flat_triangle_count(), p.triangles.len()), (1 + 3, 2, 3));
        assert_eq!(p.lights.len(), 1);
        let few = prepared(&copies(4), Instancing::Auto);
        assert_eq!((few.instances.len(), few.triangles.len()), (0, 5));
    }

    #[test]
    fn records_invert_each_other_and_number_each_placed_triangle_once() {
        let p = prepared(&copies(9), Instancing::Always);
        let mut numbers: Vec<u32> = Vec::new();
        for r in &p.instances {
            let round_trip = r.to_world() * r.to_object();
            assert!(round_trip.abs_diff_eq(DAffine3::IDENTITY, 1e-5), "{round_trip:?}");
            assert_eq!(r.flags & INSTANCE_MIRRORED != 0, r.to_world().matrix3.determinant() < 0.0);
        }
        let mesh_face = p.triangles[p.bvh.flat_triangle_count()].face;
        numbers.extend(p.instances[1..].iter().map(|r| mesh_face.wrapping_add(r.primitive_offset)));
        numbers.sort_unstable();
        assert_eq!(numbers, (2..11).collect::<Vec<u32>>(), "behind the face of the lamp and that of the mesh");
    }

    #[test]
    fn numbers_begin_again_behind_what_is_flat() {
        let mut g = Geometry::default();
        g.mesh_faces.push(3..1_000_000_003);
        g.placed = vec![Placed::new(0, &DAffine3::IDENTITY, 0, 0); 7];
        g.faces = vec![FaceRecord::default(); 3];
        let mut notes = Vec::new();
        number(&mut g, &mut notes);
        let first: Vec<u32> = g.placed.iter().map(|p| p.first_primitive).collect();
        assert_eq!(first[..5], [3, 1_000_000_003, 2_000_000_003, 3_000_000_003, 3], "four fit");
        assert_eq!((g.objects.len(), notes.len()), (4, 1));
    }
}
