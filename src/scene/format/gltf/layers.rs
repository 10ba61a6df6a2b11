//! KHR_materials_specular, _anisotropy and _clearcoat as inputs of the model `gltf`.
//!
//! Specular: factor * A of its texture, colour factor * its texture. Anisotropy: strength * B of the texture, direction from R
//! and G, and the rotation; without tangents it is left out. Clearcoat: factor * R, roughness factor * G; the coat follows the
//! normals of the base, so a texture of its own is left out.

use super::document::{Material as Entry, TextureInfo};
use super::materials::times;
use crate::scene::{Encoding, Error, Value};

/// Names of inputs and their values; inputs that keep the model's default are not in it.
pub fn inputs(
    entry: &Entry,
    place: &str,
    has_tangents: bool,
    notes: &mut Vec<String>,
    mut look_up: impl FnMut(&TextureInfo, Encoding) -> Result<Value, Error>,
) -> Result<Vec<(&'static str, Value)>, Error> {
    let mut list = Vec::new();
    let mut scaled = |factor: f64, info: &Option<TextureInfo>, channel: u8| -> Result<Value, Error> {
        match info.as_ref().filter(|_| factor > 0.0) {
            Some(info) => {
                let texture = look_up(info, Encoding::Linear)?;
                Ok(times(Value::scalar(factor), Value::Channel(Box::new(texture), channel)))
            }
            None => Ok(Value::scalar(factor)),
        }
    };
    let extensions = &entry.extensions;
    if let Some(s) = &extensions.specular {
        list.push(("specular", scaled(s.specular_factor, &s.specular_texture, 3)?));
    }
    if let Some(c) = &extensions.clearcoat {
        list.push(("clearcoat", scaled(c.clearcoat_factor, &c.clearcoat_texture, 0)?));
        list.push(("clearcoat_roughness", scaled(c.clearcoat_roughness_factor, &c.clearcoat_roughness_texture, 1)?));
        if c.clearcoat_normal_texture.is_some() && c.clearcoat_factor > 0.0 {
            notes.push(format!("{place}: the coat's own normal texture left out, it follows the normals below"));
        }
    }
    if let Some(s) = &extensions.specular {
        let [r, g, b] = s.specular_color_factor;
        let mut color = Value::rgb(r, g, b);
        if let Some(info) = &s.specular_color_texture {
            color = times(color, look_up(info, Encoding::Srgb)?);
        }
        list.push(("specular_color", color));
    }
    if let Some(a) = extensions.anisotropy.as_ref().filter(|a| a.anisotropy_strength > 0.0) {
        if !has_tangents {
            notes.push(format!(
                "{place}: anisotropy left out where a mesh has neither tangents nor texture coordinates"
            ));
            return Ok(list);
        }
        list.push(("anisotropy", Value::scalar(a.anisotropy_strength)));
        list.push(("anisotropy_rotation", Value::scalar(a.anisotropy_rotation % std::f64::consts::TAU)));
        if let Some(info) = &a.anisotropy_texture {
            list.push(("anisotropy_direction", look_up(info, Encoding::Linear)?));
        }
    }
    Ok(list)
}

/// The name of a number that no surface can have.
pub fn check(entry: &Entry) -> Result<(), &'static str> {
    let unit = |x: f64| (0.0..=1.0).contains(&x);
    let e = &entry.extensions;
    let checks = [
        ("specularFactor", e.specular.as_ref().is_none_or(|s| unit(s.specular_factor))),
        (
            "specularColorFactor",
            e.specular.as_ref().is_none_or(|s| s.specular_color_factor.iter().all(|x| (0.0..=1e6).contains(x))),
        ),
        ("anisotropyStrength", e.anisotropy.as_ref().is_none_or(|a| unit(a.anisotropy_strength))),
        ("anisotropyRotation", e.anisotropy.as_ref().is_none_or(|a| a.anisotropy_rotation.is_finite())),
        ("clearcoatFactor", e.clearcoat.as_ref().is_none_or(|c| unit(c.clearcoat_factor))),
        ("clearcoatRoughnessFactor", e.clearcoat.as_ref().is_none_or(|c| unit(c.clearcoat_roughness_factor))),
    ];
    checks.iter().find(|c| !c.1).map_or(Ok(()), |c| Err(c.0))
}
