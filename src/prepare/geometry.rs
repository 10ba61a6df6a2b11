//! Instances flattened to world triangles, spheres and discs, rebased in f64 so that the camera stands at the origin. Meshes that the plan
//! keeps once (`instances`) come last, in their own space.
//!
//! Mirrored instances have their winding turned, so that "front is counter-clockwise" holds in the records. Normals go through the
//! inverse transpose. Vertex arrays exist only where a material or a texture reads them.

use glam::{DAffine3, DMat3, DQuat, DVec3};

use std::ops::Range;

use super::instances::{self, Placed, Plan, rebased};
use super::records::*;
use crate::scene::{Instance, Mesh, Scene, Shape};

/// Row numbers stay below this, so that row * rows-a-record fits 32 bits.
const MAX_COUNT: usize = 1 << 30;

/// Which vertex arrays the materials read.
#[derive(Clone, Copy, Debug, Default)]
pub struct Wanted {
    pub normals: bool,
    pub tangents: bool,
    pub uvs: bool,
    pub colors: bool,
}

/// World geometry before the BVH orders it.
#[derive(Clone, Debug, Default)]
pub struct Geometry {
    pub triangles: Vec<TriangleRecord>,
    pub spheres: Vec<SphereRecord>,
    pub discs: Vec<DiscRecord>,
    pub faces: Vec<FaceRecord>,
    pub normals: Vec<NormalRecord>,
    pub tangents: Vec<TangentRecord>,
    pub uvs: Vec<UvRecord>,
    pub colors: Vec<ColorRecord>,
    /// Number of an instance's first primitive, and its own number.
    pub objects: Vec<(u32, u32)>,
    /// Faces of each mesh of the plan, behind the flat ones; triangles have the same numbers.
    pub mesh_faces: Vec<Range<usize>>,
    pub placed: Vec<Placed>,
    /// Vertices so far: the arrays that are wanted all have this length.
    vertex_count: usize,
}

impl Geometry {
    /// Numbers below this name faces, spheres and discs; those of placed triangles follow.
    pub fn flat_primitive_count(&self) -> u64 {
        (self.faces.len() + self.spheres.len() + self.discs.len()) as u64
    }

    /// Triangles that lie in the world.
    pub fn flat_triangle_count(&self) -> usize {
        self.mesh_faces.first().map_or(self.triangles.len(), |faces| faces.start)
    }
}

/// Flattens every instance of `scene` that the plan does not place, moved by `-origin`. Errors name the instance.
pub fn flatten(
    scene: &Scene,
    origin: DVec3,
    wanted: Wanted,
    plan: &Plan,
    notes: &mut Vec<String>,
) -> Result<Geometry, super::Error> {
    let mut g = Geometry::default();
    let rectangle = rectangle_mesh();
    let (mut of_spheres, mut of_discs) = (Vec::new(), Vec::new());
    for (index, instance) in scene.instances.iter().enumerate() {
        let to_world = rebased(&instance.to_world, origin);
        if !to_world.is_finite() {
            return Err(super::Error::Transform { instance: instance.name.clone(), what: "is not finite" });
        }
        let material = instance.material as u32;
        let mesh = plan.placed[index];
        if mesh != NONE {
            g.placed.push(Placed::new(mesh, &to_world, material, index as u32));
            continue;
        }
        match instance.shape {
            Shape::Mesh(_) | Shape::Rectangle => g.objects.push((g.faces.len() as u32, index as u32)),
            Shape::Sphere => of_spheres.push(index as u32),
            Shape::Disc => of_discs.push(index as u32),
        }
        match instance.shape {
            Shape::Mesh(mesh) => append_mesh(&mut g, &scene.meshes[mesh], material, &to_world, wanted)?,
            Shape::Rectangle => append_mesh(&mut g, &rectangle, material, &to_world, wanted)?,
            Shape::Sphere => append_sphere(&mut g, instance, &to_world)?,
            Shape::Disc => append_disc(&mut g, instance, index, &to_world)?,
        }
    }
    for &mesh in &plan.meshes {
        let first = g.faces.len();
        append_mesh(&mut g, &scene.meshes[mesh], 0, &DAffine3::IDENTITY, wanted)?;
        g.mesh_faces.push(first..g.faces.len());
    }
    for (number, sphere) in g.spheres.iter_mut().enumerate() {
        sphere.primitive = (g.faces.len() + number) as u32;
    }
    for (number, disc) in g.discs.iter_mut().enumerate() {
        disc.primitive = (g.faces.len() + g.spheres.len() + number) as u32;
    }
    // Faces first, then spheres, then discs: as they are numbered.
    g.objects.extend(g.spheres.iter().map(|s| s.primitive).zip(of_spheres));
    g.objects.extend(g.discs.iter().map(|d| d.primitive).zip(of_discs));
    instances::number(&mut g, notes);
    Ok(g)
}

fn append_mesh(
    g: &mut Geometry,
    mesh: &Mesh,
    material: u32,
    to_world: &DAffine3,
    wanted: Wanted,
) -> Result<(), super::Error> {
    let linear = to_world.matrix3;
    let determinant = linear.determinant();
    let is_mirrored = determinant < 0.0;
    // The cofactor matrix is det * inverse transpose: the same direction, defined for flat (singular) transforms too.
    let cofactor = DMat3::from_cols(
        linear.y_axis.cross(linear.z_axis),
        linear.z_axis.cross(linear.x_axis),
        linear.x_axis.cross(linear.y_axis),
    ) * if is_mirrored { -1.0 } else { 1.0 };
    let first_vertex = g.vertex_count as u32;
    g.vertex_count += mesh.positions.len();
    let face_count = g.faces.len() + mesh.triangles.len();
    for (what, count) in [("vertices", g.vertex_count), ("triangles", face_count)] {
        if count > MAX_COUNT {
            return Err(super::Error::TooMany { what, count, limit: MAX_COUNT });
        }
    }
    let positions: Vec<[f32; 3]> =
        mesh.positions.iter().map(|p| to_world.transform_point3(vec(p)).as_vec3().to_array()).collect();
    let mut flags = 0;
    if wanted.normals {
        if mesh.normals.is_some() {
            flags |= FACE_SMOOTH;
        }
        let handedness =
            |i: usize| mesh.tangents.as_ref().map_or(1.0, |t| t[i][3]) * if is_mirrored { -1.0 } else { 1.0 };
        g.normals.extend((0..mesh.positions.len()).map(|i| NormalRecord {
            normal: mesh.normals.as_ref().map_or([0.0; 3], |n| unit(cofactor * vec(&n[i]))),
            handedness: handedness(i),
        }));
    }
    if wanted.tangents {
        if mesh.tangents.is_some() {
            flags |= FACE_TANGENTS;
        }
        g.tangents.extend((0..mesh.positions.len()).map(|i| TangentRecord {
            tangent: mesh.tangents.as_ref().map_or([0.0; 3], |t| unit(linear * vec(&[t[i][0], t[i][1], t[i][2]]))),
            reserved: 0.0,
        }));
    }
    if wanted.uvs {
        let uv = |set: usize, i: usize| mesh.uvs[set].as_ref().map_or([0.0; 2], |uv| uv[i]);
        g.uvs.extend((0..mesh.positions.len()).map(|i| UvRecord { uv0: uv(0, i), uv1: uv(1, i) }));
    }
    if wanted.colors {
        let color = |i: usize| mesh.colors.as_ref().map_or([1.0; 4], |c| c[i]);
        g.colors.extend((0..mesh.positions.len()).map(|i| ColorRecord { rgba: color(i) }));
    }
    for t in &mesh.triangles {
        let [a, b, c] = if is_mirrored { [t[0], t[2], t[1]] } else { *t };
        let face = g.faces.len() as u32;
        g.faces.push(FaceRecord { vertices: [a, b, c].map(|v| first_vertex + v), flags });
        g.triangles.push(TriangleRecord {
            v0: positions[a as usize],
            v1: positions[b as usize],
            v2: positions[c as usize],
            face,
            light: NONE,
            material,
        });
    }
    Ok(())
}

fn append_sphere(g: &mut Geometry, instance: &Instance, to_world: &DAffine3) -> Result<(), super::Error> {
    let m = to_world.matrix3;
    let fail = |what| Err(super::Error::Transform { instance: instance.name.clone(), what });
    let radius = m.x_axis.length();
    if radius == 0.0 {
        return fail("gives a sphere the radius 0");
    }
    if let Err(what) = Shape::Sphere.stays_round(to_world) {
        return fail(what);
    }
    // A mirroring matrix is a rotation times -1; the -1 stays beside the quaternion, which cannot hold it.
    let handedness = if m.determinant() < 0.0 { -1.0 } else { 1.0 };
    let to_local = DQuat::from_mat3(&(m * (handedness / radius))).conjugate().normalize();
    g.spheres.push(SphereRecord {
        center: to_world.translation.as_vec3().to_array(),
        radius: radius as f32,
        rotation: to_local.as_quat().to_array(),
        primitive: 0,
        light: NONE,
        material: instance.material as u32,
        handedness: handedness as f32,
    });
    Ok(())
}

fn append_disc(g: &mut Geometry, instance: &Instance, index: usize, to_world: &DAffine3) -> Result<(), super::Error> {
    let m = to_world.matrix3;
    let fail = |what| Err(super::Error::Transform { instance: instance.name.clone(), what });
    let (x, y) = (m.x_axis, m.y_axis);
    let radius = x.length();
    let normal = x.cross(y);
    if radius == 0.0 || normal == DVec3::ZERO {
        return fail("gives a disc the radius 0");
    }
    // Along the normal it may be scaled at will.
    if let Err(what) = Shape::Disc.stays_round(to_world) {
        return fail(what);
    }
    let handedness = if m.determinant() < 0.0 { -1.0 } else { 1.0 };
    g.discs.push(DiscRecord {
        center: to_world.translation.as_vec3().to_array(),
        radius: radius as f32,
        normal: unit(normal * handedness),
        primitive: 0,
        tangent: unit(x),
        handedness: handedness as f32,
        light: NONE,
        material: instance.material as u32,
        instance: index as u32,
        reserved: 0,
    });
    Ok(())
}

/// The unit rectangle of `Shape::Rectangle` as two triangles.
pub fn rectangle_mesh() -> Mesh {
    Mesh {
        name: "rectangle".to_owned(),
        positions: vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]],
        uvs: [Some(vec![[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]]), None],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    }
}

fn vec(a: &[f32; 3]) -> DVec3 {
    DVec3::new(a[0].into(), a[1].into(), a[2].into())
}

/// Unit vector in f32; zero stays zero (the kernel then falls back to the geometric normal).
fn unit(v: DVec3) -> [f32; 3] {
    let largest = v.abs().max_element();
    if largest > 0.0 && largest.is_finite() { (v / largest).normalize().as_vec3().to_array() } else { [0.0; 3] }
}
