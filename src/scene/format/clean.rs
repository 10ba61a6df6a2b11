//! Vertex arrays that nothing downstream has to doubt: what is not finite is counted, noted, and taken out.

use glam::Vec3;

use crate::scene::Mesh;

/// Drops triangles with a non-finite corner; gives corners without a usable normal that of a face; sets non-finite
/// texture coordinates and colours to 0 and clips colours at 0; drops all tangents when one of them is unusable.
pub fn clean(mesh: &mut Mesh, notes: &mut Vec<String>) {
    let name = mesh.name.clone();
    let before = mesh.triangles.len();
    let is_finite: Vec<bool> = mesh.positions.iter().map(|p| p.iter().all(|x| x.is_finite())).collect();
    mesh.triangles.retain(|t| t.iter().all(|i| is_finite[*i as usize]));
    let dropped = before - mesh.triangles.len();
    if dropped > 0 {
        let vertices = is_finite.iter().filter(|f| !**f).count();
        notes.push(format!("{name}: {dropped} triangles left out, {vertices} vertices are NaN or infinite"));
    }
    clean_normals(mesh, &name, notes);
    if let Some(tangents) = &mesh.tangents {
        let is_bad = |t: &[f32; 4]| !is_direction([t[0], t[1], t[2]]) || !(t[3] == 1.0 || t[3] == -1.0);
        let used = mesh.triangles.iter().flatten().filter(|i| is_bad(&tangents[**i as usize])).count();
        if used > 0 {
            notes.push(format!("{name}: tangents left out, {used} of them are zero, not finite, or without a side"));
            mesh.tangents = None;
        }
    }
    let mut bad = 0;
    let mut repair = |x: &mut f32, least: f32| {
        if !x.is_finite() {
            *x = 0.0;
            bad += 1;
        }
        *x = x.max(least);
    };
    mesh.uvs.iter_mut().flatten().flatten().flatten().for_each(|x| repair(x, f32::MIN));
    mesh.colors.iter_mut().flatten().flatten().for_each(|x| repair(x, 0.0));
    if bad > 0 {
        notes.push(format!("{name}: {bad} texture coordinates or colours are NaN or infinite, set to 0"));
    }
}

fn clean_normals(mesh: &mut Mesh, name: &str, notes: &mut Vec<String>) {
    let Some(normals) = &mut mesh.normals else { return };
    let mut repaired = 0;
    for triangle in &mesh.triangles {
        for index in triangle {
            if is_direction(normals[*index as usize]) {
                continue;
            }
            let [a, b, c] = triangle.map(|i| Vec3::from(mesh.positions[i as usize]).as_dvec3());
            let normal = (b - a).cross(c - a).normalize_or(glam::DVec3::Z);
            normals[*index as usize] = normal.as_vec3().to_array();
            repaired += 1;
        }
    }
    if repaired > 0 {
        notes.push(format!("{name}: {repaired} normals are zero or not finite, a face's taken"));
    }
}

/// Finite, and long enough that its f32 square has not vanished.
fn is_direction(v: [f32; 3]) -> bool {
    let length = Vec3::from(v).length_squared();
    length.is_finite() && length > 1e-30
}
