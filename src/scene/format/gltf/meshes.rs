//! Primitives as meshes: triangles, strips and fans, indexed or not; points and lines are counted and left out.

use super::buffers::File;
use super::document::{Document, Primitive};
use crate::scene::format::clean::clean;
use crate::scene::format::tangents;
use crate::scene::{Error, Mesh};

/// What reading a primitive gave.
pub enum Read {
    Mesh(Box<Mesh>),
    /// Points, lines, or nothing that could be seen.
    Nothing,
}

/// Reads primitive `number` of mesh `index`, which will wear `material`.
pub fn read(
    file: &File<'_>,
    (index, number): (usize, usize),
    material: Option<usize>,
    notes: &mut Vec<String>,
) -> Result<Read, Error> {
    let entry = &file.document.meshes[index];
    let primitive = &entry.primitives[number];
    let name = place(&file.document, index, number);
    if primitive.mode < 4 {
        let what = if primitive.mode == 0 { "points" } else { "lines" };
        notes.push(format!("{name}: {what} left out, triangles are read"));
        return Ok(Read::Nothing);
    }
    if primitive.mode > 6 {
        return Err(file.error(name, format!("mode {} does not exist; use 4, triangles", primitive.mode)));
    }
    let Some(positions) = primitive.attributes.get("POSITION") else {
        notes.push(format!("{name}: no positions, left out"));
        return Ok(Read::Nothing);
    };
    if !primitive.targets.is_empty() {
        notes.push(format!("{name}: morph targets left out, the base shape is taken"));
    }
    let mut mesh = Mesh { name: name.clone(), positions: file.floats(*positions, &name)?, ..Default::default() };
    let count = mesh.positions.len();
    let corners = match primitive.indices {
        Some(accessor) => {
            let indices = file.indices(accessor, &name)?;
            if let Some(at) = indices.iter().position(|i| *i as usize >= count) {
                return Err(file.error(
                    format!("accessor {accessor}"),
                    format!(
                        "index {} at place {at} is beyond the {count} vertices of {name}; export it again",
                        indices[at]
                    ),
                ));
            }
            indices
        }
        None => {
            (0..u32::try_from(count).map_err(|_| file.error(&name, "has more than 2^32 vertices; split it"))?).collect()
        }
    };
    mesh.triangles = triangles(&corners, primitive.mode);
    if primitive.mode == 4 && corners.len() % 3 != 0 {
        notes.push(format!("{name}: {} corners after the last whole triangle left out", corners.len() % 3));
    }
    attributes(file, primitive, &mut mesh)?;
    clean(&mut mesh, notes);
    if mesh.triangles.is_empty() {
        notes.push(format!("{name}: no triangle in it, left out"));
        return Ok(Read::Nothing);
    }
    if let Some(set) = normal_map_set(&file.document, material)
        && mesh.tangents.is_none()
        && mesh.uvs[set].is_some()
    {
        tangents::generate(&mut mesh, set);
    }
    Ok(Read::Mesh(Box::new(mesh)))
}

pub fn place(document: &Document, index: usize, number: usize) -> String {
    let entry = &document.meshes[index];
    let mut place = match &entry.name {
        Some(name) => format!("mesh {index} \"{name}\""),
        None => format!("mesh {index}"),
    };
    if entry.primitives.len() > 1 {
        place += &format!(" primitive {number}");
    }
    place
}

/// The coordinates a normal map of this material lives in.
fn normal_map_set(document: &Document, material: Option<usize>) -> Option<usize> {
    let material = document.materials.get(material?)?;
    Some(if material.normal_texture.as_ref()?.uv_set() == 1 { 1 } else { 0 })
}

fn attributes(file: &File<'_>, primitive: &Primitive, mesh: &mut Mesh) -> Result<(), Error> {
    let name = mesh.name.clone();
    let count = mesh.positions.len();
    let accessor = |key: &str| primitive.attributes.get(key).copied();
    let fits = |key: &str, length: usize| match length == count {
        true => Ok(()),
        false => {
            Err(file.error(&name, format!("{key} has {length} rows and there are {count} positions; export it again")))
        }
    };
    if let Some(index) = accessor("NORMAL") {
        let normals = file.floats::<3>(index, &name)?;
        fits("NORMAL", normals.len())?;
        mesh.normals = Some(normals);
    }
    if let Some(index) = accessor("TANGENT").filter(|_| mesh.normals.is_some()) {
        let tangents = file.floats::<4>(index, &name)?;
        fits("TANGENT", tangents.len())?;
        mesh.tangents = Some(tangents);
    }
    for (set, key) in ["TEXCOORD_0", "TEXCOORD_1"].into_iter().enumerate() {
        if let Some(index) = accessor(key) {
            let uvs = file.floats::<2>(index, &name)?;
            fits(key, uvs.len())?;
            mesh.uvs[set] = Some(uvs);
        }
    }
    if let Some(index) = accessor("COLOR_0") {
        let colors = match file.width(index, &name)? {
            3 => file.floats::<3>(index, &name)?.into_iter().map(|[r, g, b]| [r, g, b, 1.0]).collect(),
            _ => file.floats::<4>(index, &name)?,
        };
        fits("COLOR_0", colors.len())?;
        mesh.colors = Some(colors);
    }
    Ok(())
}

/// glTF 2.0, section 3.7.2.1: every second triangle of a strip turns around, so that all keep their front.
fn triangles(corners: &[u32], mode: u32) -> Vec<[u32; 3]> {
    let count = corners.len();
    match mode {
        5 => {
            (0..count.saturating_sub(2)).map(|i| [corners[i], corners[i + 1 + i % 2], corners[i + 2 - i % 2]]).collect()
        }
        6 => (1..count.saturating_sub(1)).map(|i| [corners[i], corners[i + 1], corners[0]]).collect(),
        _ => corners.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect(),
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn strips_and_fans_keep_their_front() {
        assert_eq!(super::triangles(&[0, 1, 2, 3], 5), [[0, 1, 2], [1, 3, 2]]);
        assert_eq!(super::triangles(&[0, 1, 2, 3], 6), [[1, 2, 0], [2, 3, 0]]);
        assert_eq!(super::triangles(&[0, 1], 5).len() + super::triangles(&[], 6).len(), 0);
    }
}
