//! Materials resolved: patterns and their constants, texture pages, media, and what of it the vertices must carry.
//!
//! A material that no shape has keeps its row, so that numbers stay the scene's, and brings nothing else: no pattern, texture, medium
//! or macro.

use std::collections::{BTreeMap, HashMap, HashSet};

use glam::DVec3;

use super::geometry::Wanted;
use super::media;
use super::pattern::{Context, Node, Patterns, Role, Structure};
use super::records::*;
use crate::bsdf;
use crate::scene::{Alpha, Encoding, Image, Material, Mesh, Pixels, Scene, Surface, Texture, TextureFilter, Value};
use crate::{math, scene::groups, texture};

/// What `prepare` needs of the materials.
#[derive(Default)]
pub struct Resolved {
    pub materials: Vec<MaterialRecord>,
    pub data: Vec<[u32; 4]>,
    pub structures: Vec<Structure>,
    pub textures: Vec<TextureRecord>,
    pub texels: Vec<[u32; 4]>,
    pub media: Vec<MediumRecord>,
    /// Bodies of refracting media may overlap.
    pub nests: bool,
    /// By priority.
    ranks: BTreeMap<u32, u32>,
    /// Mean emitted radiance of each material, for the choice of lights; positive wherever anything is emitted.
    pub emission: Vec<DVec3>,
    pub wanted: Wanted,
    pub macros: Vec<(&'static str, bool)>,
    pub notes: Vec<String>,
}

/// The row of a material that no shape has.
const UNUSED: MaterialRecord = MaterialRecord {
    pattern: NONE,
    data: 0,
    emission_pattern: NONE,
    emission_data: 0,
    alpha_pattern: NONE,
    alpha_data: 0,
    normal_pattern: NONE,
    normal_data: 0,
    bsdf: 0,
    flags: 0,
    alpha_cutoff: 0.0,
    normal_scale: 0.0,
    interior: NONE,
    priority: 0,
    group: 0,
    reserved: 0,
};

pub fn resolve(scene: &Scene) -> Resolved {
    let mut r = Resolved { nests: media::nest(scene), ranks: media::ranks(scene), ..Resolved::default() };
    let is_used = scene.used_materials();
    let used = || scene.materials.iter().zip(&is_used).filter(|(_, is_used)| **is_used).map(|(m, _)| m);
    let groups = scene.light_groups();
    let texture_rows = pack_textures(scene, &used().collect::<Vec<_>>(), &mut r);
    let context = Context { textures: &scene.textures, texture_rows: &texture_rows };
    let mut patterns = Patterns::default();
    for (material, is_used) in scene.materials.iter().zip(&is_used) {
        let record = match *is_used {
            true => resolve_material(material, &mut patterns, &context, &mut r),
            false => UNUSED,
        };
        r.materials.push(MaterialRecord { group: groups::number(&groups, material.group.as_deref()), ..record });
        r.emission.push(material.emission.as_ref().map_or(DVec3::ZERO, |v| mean(v, scene)));
    }
    r.data = patterns.rows;
    r.structures = patterns.structures;
    r.wanted.tangents = used().any(follows_tangent);
    // A tangent's handedness is kept in the row of the normal, on flat meshes too.
    let needs_normals = |m: &Mesh| m.normals.is_some() || (r.wanted.tangents && m.tangents.is_some());
    r.wanted.normals = scene.meshes.iter().any(needs_normals);
    for structure in &r.structures {
        structure.visit(&mut |node| match node {
            Node::Image { .. } | Node::Checker { .. } => r.wanted.uvs = true,
            Node::VertexColor => r.wanted.colors = true,
            _ => {}
        });
    }
    for model in bsdf::MODELS {
        let surfaces = || used().flat_map(|m| m.surfaces());
        for &(name, when) in model.macros {
            let asks = |s: Surface| bsdf::MODELS[s.bsdf].keyword == model.keyword && asks_for(&s, when);
            r.macros.push((name, surfaces().any(asks)));
        }
    }
    r
}

fn resolve_material(m: &Material, patterns: &mut Patterns, context: &Context, r: &mut Resolved) -> MaterialRecord {
    let resolved: Vec<Vec<Value>> = m.surfaces().iter().map(resolve_curves).collect();
    let (pattern, data) = match &m.parts[..] {
        [] => patterns.add(Role::Bsdf(m.bsdf), &resolved[0], context),
        parts => {
            let shares = parts.iter().map(|p| p.share.clone());
            let values: Vec<Value> = resolved
                .into_iter()
                .zip(shares)
                .flat_map(|(inputs, share)| inputs.into_iter().chain([share]))
                .collect();
            patterns.add(Role::Mix(parts.iter().map(|p| p.bsdf).collect()), &values, context)
        }
    };
    let mut record = MaterialRecord {
        pattern,
        data,
        emission_pattern: NONE,
        alpha_pattern: NONE,
        normal_pattern: NONE,
        bsdf: m.bsdf as u32,
        interior: NONE,
        priority: r.ranks.get(&m.priority).copied().unwrap_or(0),
        ..MaterialRecord::default()
    };
    if let Some(value) = m.emission.as_ref().filter(|_| m.emits()) {
        (record.emission_pattern, record.emission_data) =
            patterns.add(Role::Emission, std::slice::from_ref(value), context);
        record.flags |= MATERIAL_EMITS | if m.emission_two_sided { MATERIAL_EMITS_TWO_SIDED } else { 0 };
    }
    match &m.alpha {
        Alpha::Opaque => {}
        Alpha::Mask { value, cutoff } => {
            (record.alpha_pattern, record.alpha_data) = patterns.add(Role::Alpha, std::slice::from_ref(value), context);
            record.flags |= MATERIAL_MASK;
            record.alpha_cutoff = *cutoff as f32;
        }
        Alpha::Blend { value } => {
            (record.alpha_pattern, record.alpha_data) = patterns.add(Role::Alpha, std::slice::from_ref(value), context);
            record.flags |= MATERIAL_BLEND;
        }
    }
    if let Some((value, scale)) = &m.normal_map {
        (record.normal_pattern, record.normal_data) = patterns.add(Role::Normal, std::slice::from_ref(value), context);
        record.flags |= MATERIAL_NORMAL_MAP;
        record.normal_scale = *scale as f32;
    }
    if follows_tangent(m) {
        record.flags |= MATERIAL_TANGENT;
    }
    if m.transmits() {
        record.flags |= MATERIAL_TRANSMITS | if m.is_thin() { MATERIAL_THIN } else { 0 };
    }
    let absorption = m.interior.map_or(DVec3::ZERO, |i| i.absorption);
    // Where dielectrics overlap every one of them counts, clear or not.
    let has_inside = m.transmits() && !m.is_thin();
    if if r.nests { media::bounds_medium(m) } else { has_inside && absorption != DVec3::ZERO } {
        record.interior = r.media.len() as u32;
        let eta = if r.nests { media::index_of(m) as f32 } else { 1.0 };
        r.media.push(MediumRecord { absorption: absorption.as_vec3().to_array(), eta });
    } else if r.nests && has_inside && m.emits() && absorption != DVec3::ZERO {
        r.notes.push(format!(
            "{}: a surface that shines bounds no medium where bodies overlap: its absorption is left out",
            m.name
        ));
    }
    record
}

fn follows_tangent(m: &Material) -> bool {
    m.normal_map.is_some() || m.surfaces().iter().any(is_anisotropic)
}

fn is_anisotropic(s: &Surface) -> bool {
    s.input("roughness_y").is_some_and(|v| !matches!(v, Value::Constant([x, ..]) if *x < 0.0))
        || s.input("anisotropy").is_some_and(|v| !v.is_zero())
}

/// The surface may need the part of its model's text.
fn asks_for(s: &Surface, when: bsdf::When) -> bool {
    match when {
        bsdf::When::NotZero(inputs) => inputs.iter().all(|i| s.input(i).is_some_and(|v| !v.is_zero())),
        bsdf::When::NotDefault(names) => bsdf::MODELS[s.bsdf].inputs.iter().zip(s.inputs).any(|(input, value)| {
            names.contains(&input.name) && !matches!(value, Value::Constant(c) if c[..3] == input.default)
        }),
    }
}

/// Inputs with metals' curves replaced by the RGB (eta, k) that reflect the same light.
fn resolve_curves(m: &Surface) -> Vec<Value> {
    let mut inputs = m.inputs.to_vec();
    let place = |name: &str| bsdf::MODELS[m.bsdf].inputs.iter().position(|i| i.name == name);
    if let (Some(eta), Some(k)) = (place("eta"), place("k"))
        && let (Value::Curve(eta_curve), Value::Curve(k_curve)) = (&m.inputs[eta], &m.inputs[k])
    {
        let (e, kk) = math::spectrum::fit_conductor_rgb(eta_curve, k_curve);
        inputs[eta] = Value::rgb(e.x, e.y, e.z);
        inputs[k] = Value::rgb(kk.x, kk.y, kk.z);
    }
    inputs
}

/// Packs every image texture that a material reads once an image; returns the table row of each scene texture.
fn pack_textures(scene: &Scene, materials: &[&Material], r: &mut Resolved) -> Vec<Option<u32>> {
    let mut pages: HashMap<(usize, Option<(Encoding, bool)>), texture::Page> = HashMap::new();
    let mut is_read = HashSet::new();
    materials.iter().flat_map(|m| values(m)).for_each(|value| collect(value, &mut is_read));
    let by_alpha = presence_textures(materials);
    scene
        .textures
        .iter()
        .enumerate()
        .map(|(number, t)| {
            let Texture::Image { image, wrap, filter, minify, encoding } = t else { return None };
            if !is_read.contains(&number) {
                return None;
            }
            let pixels = &scene.images[*image];
            let minify = (scene.texture_filter == TextureFilter::Mipmap).then_some(*minify);
            let levels = minify.and_then(|m| m.levels).map(|_| (*encoding, by_alpha.contains(&number)));
            let page = *pages.entry((*image, levels)).or_insert_with(|| {
                let rows = match levels {
                    Some((encoding, is_weighted)) => texture::pack_levels(pixels, encoding, is_weighted),
                    None => texture::pack(pixels),
                };
                let before = if levels.is_some() { texture::mip::OFFSET_ROWS } else { 0 };
                let first_row = (r.texels.len() + before) as u32;
                r.texels.extend(rows);
                texture::Page { first_row, has_levels: levels.is_some() }
            });
            r.textures.push(texture::record(pixels, *wrap, *filter, minify, *encoding, page));
            Some(r.textures.len() as u32 - 1)
        })
        .collect()
}

/// Textures that a value reads.
fn collect(value: &Value, found: &mut HashSet<usize>) {
    match value {
        Value::Texture { texture, .. } => drop(found.insert(*texture)),
        Value::Multiply(a, b) => {
            collect(a, found);
            collect(b, found);
        }
        Value::Channel(a, _) | Value::Share(a) | Value::Rest(a) => collect(a, found),
        Value::Constant(_) | Value::Curve(_) | Value::VertexColor => {}
    }
}

/// Everything a material looks up.
fn values(m: &Material) -> Vec<&Value> {
    let inputs = m.surfaces().into_iter().flat_map(|s| s.inputs);
    let shares = m.parts.iter().map(|p| &p.share);
    let alpha = match &m.alpha {
        Alpha::Opaque => None,
        Alpha::Mask { value, .. } | Alpha::Blend { value } => Some(value),
    };
    let others = m.emission.iter().chain(alpha).chain(m.normal_map.iter().map(|n| &n.0));
    inputs.chain(shares).chain(others).collect()
}

/// Textures whose alpha says where a surface is.
fn presence_textures(materials: &[&Material]) -> HashSet<usize> {
    let mut found = HashSet::new();
    for material in materials {
        if let Alpha::Mask { value, .. } | Alpha::Blend { value } = &material.alpha {
            collect(value, &mut found);
        }
    }
    found
}

/// Mean of a value over its textures, linear; of a product the product of the means. Only the choice of lights depends on it.
fn mean(value: &Value, scene: &Scene) -> DVec3 {
    match value {
        Value::Constant(c) => DVec3::new(c[0], c[1], c[2]),
        Value::Curve(_) | Value::VertexColor => DVec3::ONE,
        Value::Multiply(a, b) => mean(a, scene) * mean(b, scene),
        Value::Share(a) => mean(a, scene),
        Value::Rest(a) => DVec3::ONE - mean(a, scene),
        Value::Channel(a, c) => DVec3::splat(mean(a, scene)[usize::from(*c).min(2)]),
        Value::Texture { texture, .. } => match &scene.textures[*texture] {
            Texture::Constant(c) => DVec3::new(c[0], c[1], c[2]),
            Texture::Checker { a, b, .. } => DVec3::from_slice(&a[..3]).lerp(DVec3::from_slice(&b[..3]), 0.5),
            Texture::Image { image, encoding, .. } => image_mean(&scene.images[*image], *encoding == Encoding::Srgb),
        },
    }
}

fn image_mean(image: &Image, is_srgb: bool) -> DVec3 {
    let count = (f64::from(image.width) * f64::from(image.height)).max(1.0);
    let decode = |x: f64| if is_srgb { math::special::srgb_decode(x) } else { x };
    let sum = match &image.pixels {
        Pixels::Rgba8(bytes) => {
            let table: Vec<f64> = (0..=255u8).map(|b| decode(f64::from(b) / 255.0)).collect();
            let rgb = |p: &[u8]| DVec3::new(table[p[0] as usize], table[p[1] as usize], table[p[2] as usize]);
            bytes.chunks_exact(4).map(rgb).sum()
        }
        Pixels::Rgba16(words) => {
            let rgb = |p: &[u16]| DVec3::new(p[0].into(), p[1].into(), p[2].into()) / 65535.0;
            words.chunks_exact(4).map(|p| rgb(p).map(decode)).sum()
        }
        Pixels::RgbF32(floats) => {
            floats.chunks_exact(3).fold(DVec3::ZERO, |sum, p| sum + DVec3::new(p[0].into(), p[1].into(), p[2].into()))
        }
    };
    sum / count
}

#[cfg(test)]
#[path = "materials_tests.rs"]
mod tests;
