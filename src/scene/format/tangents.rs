//! Tangents for meshes that come without: MikkTSpace (Mikkelsen 2008), which glTF 2.0 section 3.7.2.1 asks for.
//!
//! Its tangents belong to corners of triangles; a vertex whose corners disagree is split. glTF's v runs down the
//! picture while a normal map's y points up it, so that the handedness is the opposite of MikkTSpace's.

use std::collections::HashMap;

use bevy_mikktspace::{Geometry, TangentSpace, generate_tangents};

use crate::scene::{Mesh, Scene, Shape, Value};

struct Corners<'m> {
    mesh: &'m Mesh,
    uvs: &'m [[f32; 2]],
    tangents: Vec<[[f32; 4]; 3]>,
}

impl Corners<'_> {
    fn vertex(&self, face: usize, corner: usize) -> usize {
        self.mesh.triangles[face][corner] as usize
    }
}

impl Geometry for Corners<'_> {
    fn num_faces(&self) -> usize {
        self.mesh.triangles.len()
    }
    fn num_vertices_of_face(&self, _face: usize) -> usize {
        3
    }
    fn position(&self, face: usize, corner: usize) -> [f32; 3] {
        self.mesh.positions[self.vertex(face, corner)]
    }
    fn normal(&self, face: usize, corner: usize) -> [f32; 3] {
        match &self.mesh.normals {
            Some(normals) => normals[self.vertex(face, corner)],
            None => flat_normal(self.mesh, face),
        }
    }
    fn tex_coord(&self, face: usize, corner: usize) -> [f32; 2] {
        self.uvs[self.vertex(face, corner)]
    }
    fn set_tangent(&mut self, tangent: Option<TangentSpace>, face: usize, corner: usize) {
        let [x, y, z, w] = tangent.unwrap_or_default().tangent_encoded();
        self.tangents[face][corner] = [x, y, z, -w];
    }
}

/// Gives the mesh tangents along texture set `set`, splitting vertices where corners disagree.
pub fn generate(mesh: &mut Mesh, set: usize) {
    let Some(uvs) = &mesh.uvs[set] else { return };
    let mut corners = Corners { mesh, uvs, tangents: vec![[[1.0, 0.0, 0.0, 1.0]; 3]; mesh.triangles.len()] };
    if generate_tangents(&mut corners).is_err() {
        return;
    }
    let per_corner = corners.tangents;
    let mut places: HashMap<(u32, [u32; 4]), u32> = HashMap::with_capacity(mesh.positions.len());
    let (mut sources, mut tangents) = (Vec::new(), Vec::new());
    for (triangle, corner_tangents) in mesh.triangles.iter_mut().zip(per_corner) {
        for (index, tangent) in triangle.iter_mut().zip(corner_tangents) {
            *index = *places.entry((*index, tangent.map(f32::to_bits))).or_insert_with(|| {
                sources.push(*index as usize);
                tangents.push(tangent);
                (sources.len() - 1) as u32
            });
        }
    }
    fn pick<T: Copy>(list: &mut [T], sources: &[usize]) -> Vec<T> {
        sources.iter().map(|s| list[*s]).collect()
    }
    mesh.positions = pick(&mut mesh.positions, &sources);
    mesh.normals = mesh.normals.as_mut().map(|list| pick(list, &sources));
    mesh.colors = mesh.colors.as_mut().map(|list| pick(list, &sources));
    for uvs in mesh.uvs.iter_mut().flatten() {
        *uvs = pick(uvs, &sources);
    }
    mesh.tangents = Some(tangents);
}

/// Tangents for whatever wears a normal map and has none. A rectangle that does becomes the mesh it stands for.
pub fn complete(scene: &mut Scene) {
    for instance in &mut scene.instances {
        let material = &scene.materials[instance.material];
        let Some((Value::Texture { uv_set, .. }, _)) = &material.normal_map else { continue };
        if matches!(instance.shape, Shape::Rectangle) {
            scene.meshes.push(rectangle(&instance.name));
            instance.shape = Shape::Mesh(scene.meshes.len() - 1);
        }
        let Shape::Mesh(index) = instance.shape else { continue };
        let mesh = &mut scene.meshes[index];
        if mesh.tangents.is_none() && mesh.uvs[usize::from(*uv_set)].is_some() {
            generate(mesh, usize::from(*uv_set));
        }
        if mesh.tangents.is_none() {
            let note =
                format!("{}: normal map of {} left out, no texture coordinates for it", mesh.name, material.name);
            scene.notes.push(note);
        }
    }
}

/// `Shape::Rectangle` in triangles.
fn rectangle(name: &str) -> Mesh {
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0f32]];
    let uvs = corners.map(|[x, y]| [(x + 1.0) / 2.0, (1.0 - y) / 2.0]).to_vec();
    Mesh {
        name: name.into(),
        positions: corners.map(|[x, y]| [x, y, 0.0]).to_vec(),
        uvs: [Some(uvs.clone()), Some(uvs)],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    }
}

fn flat_normal(mesh: &Mesh, face: usize) -> [f32; 3] {
    let [a, b, c] = mesh.triangles[face].map(|i| glam::Vec3::from(mesh.positions[i as usize]).as_dvec3());
    (b - a).cross(c - a).normalize_or(glam::DVec3::Z).as_vec3().to_array()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_normal_map_s_up_is_up_the_picture() {
        // A square seen from +z whose texture stands upright: u to the right, v down.
        let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let mut mesh = Mesh {
            positions: corners.map(|[x, y]| [x, y, 0.0]).to_vec(),
            normals: Some(vec![[0.0, 0.0, 1.0]; 4]),
            uvs: [Some(corners.map(|[x, y]| [x, 1.0 - y]).to_vec()), None],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..Default::default()
        };
        generate(&mut mesh, 0);
        // t = +x, and b = w (n x t) = +y.
        assert_eq!(mesh.tangents, Some(vec![[1.0, 0.0, 0.0, 1.0]; 4]));
        assert_eq!(mesh.positions.len(), 4);
    }

    #[test]
    fn mirrored_coordinates_split_their_vertices() {
        let mut mesh = Mesh {
            positions: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]],
            normals: Some(vec![[0.0, 0.0, 1.0]; 4]),
            uvs: [Some(vec![[0.0, 1.0], [1.0, 1.0], [0.0, 0.0], [1.0, 1.0]]), None],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..Default::default()
        };
        generate(&mut mesh, 0);
        assert_eq!(mesh.positions.len(), 6);
        let handedness: Vec<f32> = mesh.tangents.unwrap().iter().map(|t| t[3]).collect();
        assert_eq!(handedness, [1.0, 1.0, 1.0, -1.0, -1.0, -1.0]);
    }
}
