//! Faces by index as a mesh: one vertex for each distinct corner, polygons cut up, missing normals made.

use std::collections::HashMap;

use glam::DVec3;

use super::super::polygon;
use super::parse::{Corner, File, Part};
use crate::scene::Mesh;

/// What makes two corners the same vertex. `flat`: the face a corner belongs to alone, 0 for none; or its smoothing group.
#[derive(PartialEq, Eq, Hash)]
struct Key {
    corner: Corner,
    flat: u32,
    smoothing: u32,
}

pub fn mesh(file: &File, part: &Part) -> Mesh {
    let corners = |k: usize| &file.corners[part.faces[k].first..part.faces[k].first + part.faces[k].count];
    let has_given = |c: &Corner| c.normal.is_some();
    // A mesh none of whose corners has or gets a normal is flat and stays without.
    let is_flat = (0..part.faces.len()).all(|k| part.faces[k].smoothing == 0 && !corners(k).iter().any(has_given));
    let smooth = smooth_normals(file, part);
    let mut mesh = Mesh { name: part.group.clone(), ..Mesh::default() };
    let (mut normals, mut uvs, mut colors) = (Vec::new(), Vec::new(), Vec::new());
    let has_uvs = (0..part.faces.len()).any(|k| corners(k).iter().any(|c| c.uv.is_some()));
    let mut vertices: HashMap<Key, u32> = HashMap::new();
    for (k, face) in part.faces.iter().enumerate() {
        let points: Vec<[f32; 3]> = corners(k).iter().map(|c| file.positions[c.position as usize]).collect();
        let face_normal = newell(&points);
        let numbers: Vec<u32> = corners(k)
            .iter()
            .map(|&corner| {
                let is_given = corner.normal.is_some();
                let flat = if is_flat || is_given || face.smoothing != 0 { 0 } else { k as u32 + 1 };
                let smoothing = if is_given { 0 } else { face.smoothing };
                *vertices.entry(Key { corner, flat, smoothing }).or_insert_with(|| {
                    mesh.positions.push(file.positions[corner.position as usize]);
                    uvs.push(corner.uv.map_or([0.0; 2], |i| file.uvs[i as usize]));
                    if let Some(c) = file.colors.get(corner.position as usize) {
                        colors.push([c[0], c[1], c[2], 1.0]);
                    }
                    normals.push(match corner.normal {
                        Some(i) => file.normals[i as usize],
                        None if smoothing != 0 => smooth[&(corner.position, smoothing)].as_vec3().to_array(),
                        None => face_normal.normalize_or_zero().as_vec3().to_array(),
                    });
                    mesh.positions.len() as u32 - 1
                })
            })
            .collect();
        mesh.triangles.extend(polygon::triangulate(&points).into_iter().map(|t| t.map(|i| numbers[i])));
    }
    mesh.normals = (!is_flat).then_some(normals);
    mesh.uvs[0] = has_uvs.then_some(uvs);
    mesh.colors = (!file.colors.is_empty()).then_some(colors);
    mesh
}

/// By position and smoothing group: the sum of the unit normals of its faces, each times its angle there; unit.
fn smooth_normals(file: &File, part: &Part) -> HashMap<(u32, u32), DVec3> {
    let mut sums: HashMap<(u32, u32), DVec3> = HashMap::new();
    for face in part.faces.iter().filter(|f| f.smoothing != 0) {
        let corners = &file.corners[face.first..face.first + face.count];
        let at = |k: usize| DVec3::from(file.positions[corners[k % face.count].position as usize].map(f64::from));
        let points: Vec<[f32; 3]> = corners.iter().map(|c| file.positions[c.position as usize]).collect();
        let normal = newell(&points).normalize_or_zero();
        for k in 0..face.count {
            let (to_next, to_last) = (at(k + 1) - at(k), at(k + face.count - 1) - at(k));
            let angle = to_next.cross(to_last).length().atan2(to_next.dot(to_last));
            *sums.entry((corners[k].position, face.smoothing)).or_default() += angle * normal;
        }
    }
    sums.values_mut().for_each(|n| *n = n.normalize_or_zero());
    sums
}

/// Twice the area vector of a polygon (Newell): of a face that is not flat, the mean direction.
fn newell(points: &[[f32; 3]]) -> DVec3 {
    let at = |k: usize| DVec3::from(points[k % points.len()].map(f64::from)) - DVec3::from(points[0].map(f64::from));
    (0..points.len()).map(|k| at(k).cross(at(k + 1))).sum()
}
