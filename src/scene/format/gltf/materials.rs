//! glTF's surface as a material of the bsdf model `gltf`: metallic-roughness with emissive strength, index of
//! refraction, transmission and volume; layers.rs has the rest. Inputs are looked up by name, so that the model's order is its own.
//!
//! base colour = (factor * texture) * vertex colour. Emission is factor * strength * texture, on both sides of
//! double-sided materials. `thin` is 0 only where KHR_materials_volume gives a thickness: then light refracts into the
//! medium behind, with absorption = -ln(attenuation colour) / attenuation distance. An unlit material is emission only.

use glam::DVec3;

use super::buffers::File;
use super::document::{Material as Entry, TextureInfo, Volume};
use super::layers;
use super::textures::Textures;
use crate::bsdf::MODELS;
use crate::scene::format::toml::plain_material;
use crate::scene::{Alpha, Encoding, Error, MAX_ABSORPTION, MAX_RADIANCE, Material, Medium, Scene, Value};

/// What of a material depends on the mesh that wears it.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct Wear {
    pub has_color: bool,
    /// Normal maps and anisotropy need texture coordinates.
    pub has_tangents: bool,
}

/// Builds the material; `index` None is glTF's default one.
pub fn build(
    file: &File<'_>,
    index: Option<usize>,
    wear: Wear,
    textures: &mut Textures,
    scene: &mut Scene,
) -> Result<Material, Error> {
    let default = Entry::default();
    let entry = index.map_or(&default, |i| &file.document.materials[i]);
    let place = index.map_or("default material".into(), |i| place(entry, i));
    check_numbers(entry)
        .and_then(|()| layers::check(entry))
        .map_err(|key| file.error(&place, format!("`{key}` is out of its range; correct it")))?;
    let model = MODELS.iter().position(|m| m.keyword == "gltf").expect("bsdf_list! holds gltf");
    let name = entry.name.clone().unwrap_or_else(|| place.clone());
    let mut material = plain_material(&name, model);
    let mut look_up = |info: &TextureInfo, encoding| textures.value(file, info, encoding, scene);
    let pbr = &entry.pbr_metallic_roughness;
    let mut base_color = Value::Constant(pbr.base_color_factor);
    if let Some(info) = &pbr.base_color_texture {
        base_color = times(base_color, look_up(info, Encoding::Srgb)?);
    }
    if wear.has_color {
        base_color = times(base_color, Value::VertexColor);
    }
    if entry.extensions.unlit.is_some() {
        let alpha = alpha(entry, &base_color, &place, &mut scene.notes);
        return Ok(unlit(&name, base_color, alpha));
    }
    let (mut metallic, mut roughness) = (Value::scalar(pbr.metallic_factor), Value::scalar(pbr.roughness_factor));
    if let Some(info) = &pbr.metallic_roughness_texture {
        let texture = look_up(info, Encoding::Linear)?;
        metallic = times(metallic, Value::Channel(Box::new(texture.clone()), 2));
        roughness = times(roughness, Value::Channel(Box::new(texture), 1));
    }
    let extensions = &entry.extensions;
    let mut transmission = Value::scalar(0.0);
    if let Some(t) = &extensions.transmission {
        transmission = Value::scalar(t.transmission_factor);
        if let Some(info) = t.transmission_texture.as_ref().filter(|_| t.transmission_factor > 0.0) {
            transmission = times(transmission, Value::Channel(Box::new(look_up(info, Encoding::Linear)?), 0));
        }
    }
    if let Some(factor) = emission_factor(entry) {
        let mut emission = Value::rgb(factor.x, factor.y, factor.z);
        if let Some(info) = &entry.emissive_texture {
            emission = times(emission, look_up(info, Encoding::Srgb)?);
        }
        material.emission = Some(emission);
        material.emission_two_sided = entry.double_sided;
    }
    if let Some(info) = entry.normal_texture.as_ref().filter(|_| wear.has_tangents) {
        material.normal_map = Some((look_up(info, Encoding::Linear)?, info.scale));
    }
    material.alpha = alpha(entry, &base_color, &place, &mut scene.notes);
    let volume = extensions.volume.as_ref().filter(|v| v.thickness_factor > 0.0);
    if let Some(volume) = volume {
        material.interior = absorption(volume, &place, &mut scene.notes);
        if volume.thickness_texture.is_some() {
            scene.notes.push(format!("{place}: thickness texture left out, the real geometry is traced"));
        }
    }
    let mut ior = extensions.ior.as_ref().map_or(1.5, |i| i.ior);
    // 0 means "all is reflected", in the extension and in the model.
    if ior != 0.0 && !(1.0..=10.0).contains(&ior) {
        let taken = ior.clamp(1.0, 10.0);
        scene.notes.push(format!("{place}: index of refraction {ior} taken as {taken}"));
        ior = taken;
    }
    let look_up = |info: &TextureInfo, encoding| textures.value(file, info, encoding, scene);
    let mut notes = Vec::new();
    let more = layers::inputs(entry, &place, wear.has_tangents, &mut notes, look_up)?;
    scene.notes.append(&mut notes);
    for (input, slot) in MODELS[model].inputs.iter().zip(&mut material.inputs) {
        *slot = match input.name {
            "base_color" => base_color.clone(),
            "metallic" => metallic.clone(),
            "roughness" => roughness.clone(),
            "transmission" => transmission.clone(),
            "ior" => Value::scalar(ior),
            "thin" => Value::scalar(if volume.is_some() { 0.0 } else { 1.0 }),
            name => match more.iter().find(|m| m.0 == name) {
                Some((_, value)) => value.clone(),
                None => continue,
            },
        };
    }
    Ok(material)
}

/// A black surface that shines with its base colour on both sides.
fn unlit(name: &str, base_color: Value, alpha: Alpha) -> Material {
    let model = MODELS.iter().position(|m| m.keyword == "lambert").expect("bsdf_list! holds lambert");
    let mut material = plain_material(name, model);
    material.inputs.fill(Value::scalar(0.0));
    let is_black = matches!(&base_color, Value::Constant(c) if c[..3] == [0.0; 3]);
    material.emission = (!is_black).then_some(base_color);
    Material { emission_two_sided: true, alpha, ..material }
}

pub fn place(entry: &Entry, index: usize) -> String {
    match &entry.name {
        Some(name) => format!("material {index} \"{name}\""),
        None => format!("material {index}"),
    }
}

pub fn times(a: Value, b: Value) -> Value {
    Value::Multiply(Box::new(a), Box::new(b))
}

fn emission_factor(entry: &Entry) -> Option<DVec3> {
    let strength = entry.extensions.emissive_strength.as_ref().map_or(1.0, |e| e.emissive_strength);
    let factor = DVec3::from(entry.emissive_factor) * strength;
    (factor != DVec3::ZERO).then_some(factor)
}

/// The name of a number that no surface can have.
fn check_numbers(entry: &Entry) -> Result<(), &'static str> {
    let unit = |x: f64| (0.0..=1.0).contains(&x);
    let pbr = &entry.pbr_metallic_roughness;
    let extensions = &entry.extensions;
    let checks = [
        ("baseColorFactor", pbr.base_color_factor.iter().all(|x| unit(*x))),
        ("metallicFactor", unit(pbr.metallic_factor)),
        ("roughnessFactor", unit(pbr.roughness_factor)),
        ("emissiveFactor", entry.emissive_factor.iter().all(|x| *x >= 0.0)),
        ("emissiveStrength", extensions.emissive_strength.as_ref().is_none_or(|e| e.emissive_strength >= 0.0)),
        (
            "emissiveFactor times emissiveStrength",
            emission_factor(entry).is_none_or(|e| e.max_element() <= MAX_RADIANCE),
        ),
        ("alphaCutoff", entry.alpha_cutoff >= 0.0),
        ("ior", extensions.ior.as_ref().is_none_or(|e| e.ior >= 0.0)),
        ("transmissionFactor", extensions.transmission.as_ref().is_none_or(|t| unit(t.transmission_factor))),
        ("thicknessFactor", extensions.volume.as_ref().is_none_or(|v| v.thickness_factor >= 0.0)),
        (
            "attenuationDistance",
            extensions.volume.as_ref().is_none_or(|v| v.attenuation_distance.is_none_or(|d| d >= 0.0)),
        ),
        ("attenuationColor", extensions.volume.as_ref().is_none_or(|v| v.attenuation_color.iter().all(|x| unit(*x)))),
    ];
    checks.iter().find(|c| !c.1).map_or(Ok(()), |c| Err(c.0))
}

fn alpha(entry: &Entry, base_color: &Value, place: &str, notes: &mut Vec<String>) -> Alpha {
    let value = match base_color {
        Value::Constant(c) => Value::scalar(c[3]),
        other => Value::Channel(Box::new(other.clone()), 3),
    };
    let is_present = matches!(&value, Value::Constant([a, ..]) if *a >= 1.0);
    match entry.alpha_mode.as_deref() {
        None | Some("OPAQUE") => Alpha::Opaque,
        Some("BLEND") if is_present => Alpha::Opaque,
        Some("BLEND") => Alpha::Blend { value },
        Some("MASK") => match &value {
            Value::Constant([a, ..]) if *a >= entry.alpha_cutoff => Alpha::Opaque,
            _ => Alpha::Mask { value, cutoff: entry.alpha_cutoff },
        },
        Some(other) => {
            notes.push(format!("{place}: alpha mode \"{other}\" does not exist, opaque taken"));
            Alpha::Opaque
        }
    }
}

/// Beer-Lambert: what is left after the attenuation distance is the attenuation colour. No distance means no absorption.
fn absorption(volume: &Volume, place: &str, notes: &mut Vec<String>) -> Option<Medium> {
    let distance = volume.attenuation_distance?;
    let color = DVec3::from(volume.attenuation_color);
    if color == DVec3::ONE || distance.is_infinite() {
        return None;
    }
    let absorption = color.to_array().map(|c| if c >= 1.0 { 0.0 } else { (-c.ln() / distance).min(MAX_ABSORPTION) });
    if absorption.contains(&MAX_ABSORPTION) {
        notes.push(format!("{place}: attenuation colour or distance of 0: absorption of {MAX_ABSORPTION:e} 1/m taken"));
    }
    Some(Medium { absorption: absorption.into() })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn absorbed(distance: Option<f64>, color: [f64; 3]) -> Option<[f64; 3]> {
        let volume = Volume {
            thickness_factor: 1.0,
            attenuation_distance: distance,
            attenuation_color: color,
            ..Default::default()
        };
        absorption(&volume, "m", &mut Vec::new()).map(|m| m.absorption.to_array())
    }

    #[test]
    fn absorption_at_the_ends_of_its_range() {
        assert_eq!(absorbed(None, [0.5; 3]), None);
        assert_eq!(absorbed(Some(2.0), [1.0; 3]), None);
        let [r, g, b] = absorbed(Some(2.0), [0.5, 1.0, 0.0]).unwrap();
        assert!((r - 0.5f64.ln().abs() / 2.0).abs() < 1e-15 && g == 0.0 && b == MAX_ABSORPTION);
        assert_eq!(absorbed(Some(0.0), [0.5, 1.0, 0.5]), Some([MAX_ABSORPTION, 0.0, MAX_ABSORPTION]));
    }
}
