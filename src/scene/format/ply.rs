//! .ply (Turk 1994, "The PLY polygon file format"): ascii, binary_little_endian and binary_big_endian 1.0.
//!
//! Read of `vertex`: x y z, nx ny nz, u v (or s t, texture_u texture_v, texture_s texture_t; v turned to run down), red green
//! blue alpha (integers as sRGB bytes or words, floats as linear). Of `face`: the list vertex_indices or vertex_index. All else is
//! skipped by its declared type. Without normals the surface is flat. One mesh with one grey material, named by the file; colours
//! of the vertices are its albedo. Counts are held against the bytes that are there before memory is taken.
//! Tests: tests/formats/ply.rs.

mod data;
mod header;

use std::path::Path;

use super::gltf::Loaded;
use super::polygon;
use super::toml::plain_material;
use crate::bsdf::MODELS;
use crate::math::special::srgb_decode;
use crate::scene::{Error, Instance, Mesh, Scene, Shape, Value};
use data::Reader;
use header::{Element, Header, Kind, Property};

pub fn load(path: &Path) -> Result<Loaded, Error> {
    let bytes = super::read_bytes(path)?;
    let mut mesh = read(&bytes).map_err(|reason| Error::Format { path: path.to_path_buf(), reason })?;
    let mut scene = Scene { source: path.to_path_buf(), ..Default::default() };
    mesh.name = path.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
    super::clean::clean(&mut mesh, &mut scene.notes);
    if mesh.triangles.is_empty() {
        let reason = "holds no triangle that can be seen; it must have faces with finite vertices".into();
        return Err(Error::Format { path: path.to_path_buf(), reason });
    }
    let lambert = MODELS.iter().position(|m| m.keyword == "lambert").expect("bsdf_list! holds lambert");
    let mut material = plain_material(&mesh.name, lambert);
    if mesh.colors.is_some() {
        material.inputs[0] = Value::VertexColor;
    }
    scene.materials.push(material);
    let (name, to_world) = (mesh.name.clone(), glam::DAffine3::IDENTITY);
    scene.instances.push(Instance { name, shape: Shape::Mesh(0), to_world, material: 0 });
    scene.meshes.push(mesh);
    Ok(Loaded { scene, material_source: vec![Some(0)], node_source: vec![0], light_source: Vec::new() })
}

/// What a property of a vertex is for: a slot of the twelve numbers that are kept.
const SLOTS: [&[&str]; 12] = [
    &["x"],
    &["y"],
    &["z"],
    &["nx"],
    &["ny"],
    &["nz"],
    &["u", "s", "texture_u", "texture_s"],
    &["v", "t", "texture_v", "texture_t"],
    &["red", "diffuse_red"],
    &["green", "diffuse_green"],
    &["blue", "diffuse_blue"],
    &["alpha"],
];

fn read(bytes: &[u8]) -> Result<Mesh, String> {
    let (header, body) = header::parse(bytes)?;
    let mut reader = Reader::new(&header, body);
    let mut mesh = Mesh::default();
    for element in &header.elements {
        reader.check_count(element)?;
        match element.name.as_str() {
            "vertex" => vertices(element, &mut reader, &mut mesh)?,
            "face" => faces(&header, element, &mut reader, &mut mesh)?,
            _ => (0..element.count).try_for_each(|row| reader.skip(element, row))?,
        }
    }
    Ok(mesh)
}

fn vertices(element: &Element, reader: &mut Reader, mesh: &mut Mesh) -> Result<(), String> {
    let slot = |p: &Property| SLOTS.iter().position(|names| names.contains(&p.name.as_str()));
    let slots: Vec<Option<usize>> = element.properties.iter().map(slot).collect();
    let is_list = |(p, slot): (&Property, &Option<usize>)| slot.is_some() && p.list.is_some();
    if let Some((property, _)) = element.properties.iter().zip(&slots).find(|&(p, slot)| is_list((p, slot))) {
        return Err(format!("the property {} of its vertices is a list, not a number; export it again", property.name));
    }
    let has = |range: std::ops::Range<usize>| range.into_iter().all(|k| slots.contains(&Some(k)));
    if !has(0..3) {
        return Err("its vertices have no x, y and z; export it again".into());
    }
    if element.count > u32::MAX as usize {
        return Err(format!("{} vertices are more than can be numbered; split it", element.count));
    }
    let (mut normals, mut uvs, mut colors) = (Vec::new(), Vec::new(), Vec::new());
    let linear = |value: f64, kind: Kind| match kind.largest() {
        Some(largest) => srgb_decode(value / largest) as f32,
        None => value as f32,
    };
    for row in 0..element.count {
        let mut v = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0];
        let mut color = [1.0f32; 4];
        for (property, slot) in element.properties.iter().zip(&slots) {
            if property.list.is_some() {
                reader.skip_list(element, property, row)?;
                continue;
            }
            let value = reader.number(property.kind, element, row)?;
            match slot {
                Some(k @ 8..=10) => color[k - 8] = linear(value, property.kind),
                Some(11) => color[3] = (value / property.kind.largest().unwrap_or(1.0)) as f32,
                Some(k) => v[*k] = value,
                None => {}
            }
        }
        let v = v.map(|x| x as f32);
        mesh.positions.push([v[0], v[1], v[2]]);
        normals.push([v[3], v[4], v[5]]);
        uvs.push([v[6], 1.0 - v[7]]);
        colors.push(color);
    }
    mesh.normals = has(3..6).then_some(normals);
    mesh.uvs[0] = has(6..8).then_some(uvs);
    mesh.colors = has(8..11).then_some(colors);
    Ok(())
}

fn faces(header: &Header, element: &Element, reader: &mut Reader, mesh: &mut Mesh) -> Result<(), String> {
    let is_indices = |p: &Property| p.list.is_some() && matches!(p.name.as_str(), "vertex_indices" | "vertex_index");
    let Some(at) = element.properties.iter().position(is_indices) else {
        return Err("its faces have no list vertex_indices; export it again as polygons".into());
    };
    if element.properties[at].kind.is_float() {
        return Err("its vertex_indices are not whole numbers; export it again".into());
    }
    let place = |name: &str| header.elements.iter().position(|e| e.name == name);
    if place("vertex") > place("face") || place("vertex").is_none() {
        return Err("its faces stand before its vertices; export it again".into());
    }
    let count = mesh.positions.len();
    let (mut corners, mut points) = (Vec::new(), Vec::new());
    for row in 0..element.count {
        for (k, property) in element.properties.iter().enumerate() {
            if k != at {
                reader.skip_property(element, property, row)?;
                continue;
            }
            let length = reader.list_length(element, property, row)?;
            if length > polygon::MAX_CORNERS {
                let most = polygon::MAX_CORNERS;
                return Err(format!(
                    "face {row} has {length} corners, and {most} are the most; cut it into smaller ones"
                ));
            }
            corners.clear();
            points.clear();
            for _ in 0..length {
                let index = reader.number(property.kind, element, row)?;
                if !(index >= 0.0 && index < count as f64 && index.fract() == 0.0) {
                    return Err(format!(
                        "face {row} refers to vertex {index}, and the file has {count}; export it again"
                    ));
                }
                corners.push(index as u32);
                points.push(mesh.positions[index as usize]);
            }
            if length >= 3 {
                mesh.triangles.extend(polygon::triangulate(&points).into_iter().map(|t| t.map(|i| corners[i])));
            }
        }
    }
    Ok(())
}
