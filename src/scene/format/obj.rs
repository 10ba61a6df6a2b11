//! Wavefront .obj (Alias|Wavefront, "Advanced Visualizer", appendix B1, 1995) with materials from .mtl files (see `material`).
//!
//! Read: v (with r g b behind it as sRGB colour), vt (v turned to run down), vn, f with any number of corners and with
//! negative indices, o, g, s, usemtl, mtllib. A group (the name of g, else of o) with one material becomes a mesh and an
//! instance. Corners without a normal are flat where smoothing is off, which is the format's default; within a smoothing
//! group they get the mean of the faces around their position, weighted by angle (Thürmer and Wüthrich 1998). Left out and
//! counted: points, lines, and free-form geometry. Tests: tests/formats/obj.rs.

mod build;
mod material;
mod parse;

use std::path::Path;

use super::gltf::Loaded;
use crate::scene::{Error, Instance, Scene, Shape};

pub fn load(path: &Path) -> Result<Loaded, Error> {
    let bytes = super::read_bytes(path)?;
    let file = parse::parse(path, &bytes)?;
    let mut scene = Scene { source: path.to_path_buf(), notes: file.notes.clone(), ..Default::default() };
    let used: Vec<&str> = file.parts.iter().map(|p| p.material.as_str()).collect();
    let worn = material::load(path, &file.libraries, &used, &mut scene)?;
    let (mut groups, mut node_source) = (Vec::new(), Vec::new());
    for part in &file.parts {
        let mut mesh = build::mesh(&file, part);
        super::clean::clean(&mut mesh, &mut scene.notes);
        if mesh.triangles.is_empty() {
            scene.notes.push(format!("group \"{}\": no triangle in it, left out", part.group));
            continue;
        }
        let group = groups.iter().position(|g| *g == &part.group).unwrap_or_else(|| {
            groups.push(&part.group);
            groups.len() - 1
        });
        node_source.push(group);
        scene.meshes.push(mesh);
        scene.instances.push(Instance {
            name: part.group.clone(),
            shape: Shape::Mesh(scene.meshes.len() - 1),
            to_world: glam::DAffine3::IDENTITY,
            material: worn[&part.material],
        });
    }
    if scene.instances.is_empty() {
        let reason = "holds no triangle that can be seen; it must have `v` and `f` lines with finite numbers".into();
        return Err(Error::Format { path: path.to_path_buf(), reason });
    }
    super::tangents::complete(&mut scene);
    let material_source = (0..scene.materials.len()).map(Some).collect();
    Ok(Loaded { scene, material_source, node_source, light_source: Vec::new() })
}
