//! `[[material]]` and its values; and patches, `[material."Name"]`, of materials that models brought.
//!
//! TOML reads `[material."Name"]` after a `[[material]]` as a sub-table of that entry. Such a sub-table is told from a
//! value by how it was opened: values are written in braces, patches under a header.

use std::ops::Range;
use std::sync::Arc;

use ::toml::de::{DeTable, DeValue};
use glam::{DAffine2, DMat2, DVec2, DVec3};

use super::model::Brought;
use super::table::{Item, Table};
use super::{Builder, keys};
use crate::bsdf::MODELS;
use crate::math::spectrum::LUMEN_PER_WATT;
use crate::scene::{Alpha, Curve, Encoding, Error, MAX_ABSORPTION, MAX_RADIANCE, Material, Medium, Texture, Value};

/// Complex indices at red, green and blue (sRGB primaries), fitted to the reflectance of measured metals.
const METALS: &[(&str, [f64; 3], [f64; 3])] = &[
    ("gold", [0.1834, 0.4215, 1.3731], [3.4291, 2.3457, 1.7704]),
    ("copper", [0.2004, 0.9240, 1.1022], [3.9129, 2.4528, 2.1421]),
    ("aluminium", [1.6574, 0.8803, 0.5212], [9.2238, 6.2695, 4.8370]),
];

/// Keys of a value, and those that may stand beside them.
const ALONE: [(&str, &[&str]); 3] =
    [("metal", &[]), ("curve", &[]), ("vertex_color", &["channel", "factor", "texture"])];

/// A patch waiting for the models: its name in the file and its table.
pub struct Patch<'a> {
    name: &'a str,
    at: Range<usize>,
    entries: &'a DeTable<'a>,
}

/// Number in `MODELS`, or None.
pub fn model_number(keyword: &str) -> Option<usize> {
    MODELS.iter().position(|m| m.keyword == keyword)
}

/// `name` with a model's inputs at their defaults.
pub fn plain(name: &str, bsdf: usize) -> Material {
    let inputs = MODELS[bsdf].inputs.iter().map(|i| Value::rgb(i.default[0], i.default[1], i.default[2])).collect();
    Material {
        name: name.into(),
        bsdf,
        inputs,
        emission: None,
        emission_two_sided: false,
        group: None,
        alpha: Alpha::Opaque,
        normal_map: None,
        interior: None,
        priority: 0,
        parts: Vec::new(),
    }
}

impl<'a> Builder<'a> {
    /// Adds the file's own materials and returns the patches found among them.
    pub fn materials(&mut self, top: &Table<'a>) -> Result<Vec<Patch<'a>>, Error> {
        let mut patches = Vec::new();
        let Some(item) = top.get("material") else { return Ok(patches) };
        match item.get_ref() {
            // Only patches: [material."A"] without any [[material]].
            DeValue::Table(entries) => {
                let table = Table::over(self.source, keys::MATERIAL.name, item.span(), entries);
                self.collect_patches(&table, &mut patches)?;
            }
            _ => {
                for item in top.tables("material")? {
                    let DeValue::Table(entries) = item.get_ref() else {
                        return Err(self.source.error(item.span(), "a [[material]] must be a table"));
                    };
                    let table = Table::over(self.source, keys::MATERIAL.name, item.span(), entries);
                    let name = table.text("name")?.ok_or_else(|| table.missing("name"))?;
                    let material = self.material(&table, None, name, &mut patches)?;
                    if self.materials.insert(name.to_string(), self.scene.materials.len()).is_some() {
                        return Err(
                            table.error("name", format!("\"{name}\" is taken by another material; choose another"))
                        );
                    }
                    self.scene.materials.push(material);
                }
            }
        }
        Ok(patches)
    }

    fn collect_patches(&self, table: &Table<'a>, patches: &mut Vec<Patch<'a>>) -> Result<(), Error> {
        for (key, item) in table.entries() {
            match item.get_ref() {
                DeValue::Table(entries) => patches.push(Patch { name: key.get_ref(), at: key.span(), entries }),
                _ => {
                    return Err(
                        table.unknown(key, "write [[material]] for a material, [material.\"Name\"] for a patch")
                    );
                }
            }
        }
        Ok(())
    }

    /// A material from its table, starting from `base` for a patch. Sub-tables under headers go to `patches`.
    fn material(
        &self,
        table: &Table<'a>,
        base: Option<&Material>,
        name: &str,
        patches: &mut Vec<Patch<'a>>,
    ) -> Result<Material, Error> {
        let keyword = table.text("type")?;
        let bsdf = match keyword {
            None => base.map_or(0, |b| b.bsdf),
            Some("mix") => 0,
            Some(word) => model_number(word).ok_or_else(|| {
                let hint = super::nearest(word, MODELS.iter().map(|m| m.keyword).chain(["mix"]));
                table.error("type", format!("is \"{word}\", which is no material type; {hint}"))
            })?,
        };
        let mut material = match base {
            Some(base) if keyword.is_none() => base.clone(),
            Some(base) => Material { bsdf, inputs: plain(name, bsdf).inputs, ..base.clone() },
            None => plain(name, bsdf),
        };
        let is_mixture = keyword == Some("mix");
        if is_mixture {
            if base.is_some() {
                return Err(table.error("type", "cannot become \"mix\" in a patch; write a [[material]] of that type"));
            }
            material = self.mixture(table, name)?;
        } else if let Some(key) = ["materials", "factor", "weights"].into_iter().find(|k| table.get(k).is_some()) {
            return Err(table.error(key, "is for type = \"mix\" only; remove it, or set the type"));
        }
        let inputs: Vec<&'static str> =
            if is_mixture { Vec::new() } else { MODELS[bsdf].inputs.iter().map(|i| i.name).collect() };
        for (key, item) in table.entries() {
            let word: &str = key.get_ref();
            if let Some(slot) = inputs.iter().position(|i| *i == word) {
                material.inputs[slot] = self.value(table, word, item)?;
                self.within(table, word, &material.inputs[slot], MODELS[bsdf].inputs[slot].range)?;
                if is_metal(item) && !inputs.contains(&"k") {
                    return Err(table.error(word, "names a metal, whose index is complex: use type = \"conductor\""));
                }
            } else if !keys::MATERIAL.keys.iter().any(|k| k.name == word) {
                match item.get_ref() {
                    DeValue::Table(entries) if base.is_none() && !self.source.is_inline(&item.span()) => {
                        patches.push(Patch { name: word, at: key.span(), entries });
                    }
                    _ => {
                        let names = keys::MATERIAL.keys.iter().map(|k| k.name).chain(inputs.iter().copied());
                        let hint = super::nearest(word, names);
                        return Err(table.unknown(
                            key,
                            &format!("of type \"{}\"; {hint}", keyword.unwrap_or(MODELS[bsdf].keyword)),
                        ));
                    }
                }
            }
        }
        if base.is_some() && table.get("name").is_some() {
            return Err(table.error("name", "cannot be changed by a patch; remove it"));
        }
        self.surroundings(table, &mut material)?;
        Ok(material)
    }

    /// The keys that every type has.
    fn surroundings(&self, table: &Table<'a>, material: &mut Material) -> Result<(), Error> {
        let value = |key: &str| table.get(key).map(|item| self.value(table, key, item)).transpose();
        let emission_nt = value("emission_nt")?.map(|v| match v {
            Value::Constant(c) => Value::Constant(c.map(|x| x / LUMEN_PER_WATT)),
            v => Value::Multiply(Box::new(Value::scalar(1.0 / LUMEN_PER_WATT)), Box::new(v)),
        });
        if emission_nt.is_some() && table.get("emission").is_some() {
            return Err(table.error("emission_nt", "stands beside `emission`; keep one of the two"));
        }
        let key = if emission_nt.is_some() { "emission_nt" } else { "emission" };
        if let Some(emission) = emission_nt.or(value("emission")?) {
            let bounds = self.scene.bounds_of(&emission);
            if bounds.least < 0.0 {
                return Err(table.error(key, "must not be negative"));
            }
            if bounds.most > MAX_RADIANCE {
                return Err(table.error(
                    key,
                    format!(
                        "comes to a radiance of {:.3e} W/(m2 sr), and {MAX_RADIANCE:e} is the most; lower it",
                        bounds.most
                    ),
                ));
            }
            material.emission = Some(emission);
        }
        if let Some(two_sided) = table.boolean("emission_two_sided")? {
            material.emission_two_sided = two_sided;
        }
        if let Some(name) = super::group::group(table)? {
            material.group = Some(name);
        }
        let cutoff = table.number("alpha_cutoff")?;
        if cutoff.is_some_and(|c| !(0.0..=1.0).contains(&c)) {
            return Err(table.error("alpha_cutoff", "must lie from 0 to 1"));
        }
        let own = value("alpha")?;
        if let Some(value) = &own {
            self.within(table, "alpha", value, (0.0, 1.0))?;
        }
        let alpha = match (own, &material.alpha) {
            (Some(alpha), _) => Some(alpha),
            (None, Alpha::Mask { value, .. } | Alpha::Blend { value }) => Some(value.clone()),
            (None, Alpha::Opaque) => None,
        };
        material.alpha = match (alpha, cutoff) {
            (Some(value), Some(cutoff)) => Alpha::Mask { value, cutoff },
            (Some(value), None) if table.get("alpha").is_some() => Alpha::Blend { value },
            (None, Some(_)) => return Err(table.error("alpha_cutoff", "stands without `alpha`; add it")),
            _ => material.alpha.clone(),
        };
        if let Some(item) = table.get("normal_map") {
            let map = Table::open(self.source, item, &[&keys::VALUE], &[])?;
            if map.text("texture")?.is_none() {
                return Err(map.missing("texture"));
            }
            let strength = map.number("strength")?.unwrap_or(1.0);
            let lookup = self.lookup(&map)?;
            let Value::Texture { texture, .. } = lookup else {
                return Err(
                    map.error("texture", "of a normal map takes neither `channel` nor `factor`; use `strength`")
                );
            };
            if matches!(self.scene.textures[texture], Texture::Image { encoding: Encoding::Srgb, .. }) {
                return Err(map
                    .error("texture", "holds directions, no colours: write encoding = \"linear\" in its [[texture]]"));
            }
            material.normal_map = Some((lookup, strength));
        }
        if let Some(absorption) = table.splat::<3>("absorption")? {
            if absorption.iter().any(|x| !(0.0..=MAX_ABSORPTION).contains(x)) {
                return Err(table.error("absorption", format!("must lie from 0 to {MAX_ABSORPTION:e} 1/m")));
            }
            material.interior = Some(Medium { absorption: absorption.into() });
        }
        if let Some(priority) = table.whole("priority", 0..1 << 32)? {
            material.priority = priority as u32;
        }
        for key in ["absorption", "priority"].into_iter().filter(|k| table.get(k).is_some()) {
            if !material.transmits() || material.is_thin() {
                return Err(table.error(key, "is of what lies behind a surface that refracts, and this one lets no light into a body; remove it, or choose type = \"dielectric\""));
            }
        }
        if table.get("priority").is_some() && material.emits() {
            return Err(table.error(
                "priority",
                "has no meaning on a surface that shines: it bounds no medium that nests; remove it",
            ));
        }
        Ok(())
    }

    /// A value lies in a range. What an image or a mesh decides may reach beyond an end, and is cut there; a sign is never meant.
    fn within(&self, table: &Table<'a>, key: &str, value: &Value, (least, most): (f64, f64)) -> Result<(), Error> {
        let bounds = self.scene.bounds_of(value);
        let is_below = bounds.least < if bounds.is_met { least } else { least.min(0.0) };
        if is_below || (bounds.is_met && bounds.most > most) {
            return Err(table.error(key, format!("must lie from {least} to {most}")));
        }
        Ok(())
    }

    /// A number, a colour, or a table of keys from `[value]`.
    pub fn value(&self, table: &Table<'a>, key: &str, item: &'a Item<'a>) -> Result<Value, Error> {
        if !item.get_ref().is_table() {
            return Ok(Value::Constant(color(table, key, item)?));
        }
        let value = Table::open(self.source, item, &[&keys::VALUE], &[])?;
        if value.get("strength").is_some() {
            return Err(value.error("strength", "belongs to `normal_map` only"));
        }
        for (key, with) in ALONE {
            if value.get(key).is_some_and(|k| k.get_ref().as_bool() != Some(false))
                && let Some((other, _)) =
                    value.entries().find(|(k, _)| *k.get_ref() != *key && !with.iter().any(|w| k.get_ref() == w))
            {
                return Err(
                    value.error(other.get_ref(), format!("has no meaning beside `{key}`; remove one of the two"))
                );
            }
        }
        if let Some(metal) = value.text("metal")? {
            let Some((_, eta, k)) = METALS.iter().find(|m| m.0 == metal) else {
                let hint = super::nearest(metal, METALS.iter().map(|m| m.0));
                return Err(value.error("metal", format!("is \"{metal}\", which is not known; {hint}")));
            };
            return match key {
                "eta" => Ok(Value::rgb(eta[0], eta[1], eta[2])),
                "k" => Ok(Value::rgb(k[0], k[1], k[2])),
                _ => Err(value.error("metal", "is an index of refraction: it belongs to `eta` and `k`")),
            };
        }
        if let Some(rows) = value.rows::<2>("curve")? {
            return curve(&value, &rows);
        }
        self.lookup(&value)
    }

    fn lookup(&self, value: &Table<'a>) -> Result<Value, Error> {
        let is_vertex_color = value.boolean("vertex_color")?.unwrap_or(false);
        let mut result = match (value.text("texture")?, is_vertex_color) {
            (Some(_), true) => return Err(value.error("vertex_color", "stands beside `texture`; keep one of the two")),
            (None, true) => Value::VertexColor,
            (None, false) => return Err(value.missing("texture")),
            (Some(name), false) => {
                let scale = DVec2::from(value.splat::<2>("scale")?.unwrap_or([1.0; 2]));
                let angle = value.number("rotate_deg")?.unwrap_or(0.0).to_radians();
                let offset = DVec2::from(value.numbers::<2>("offset")?.unwrap_or([0.0; 2]));
                Value::Texture {
                    texture: self.named(&self.textures, value, "texture", name)?,
                    uv_set: value.whole("uv_set", 0..2)?.unwrap_or(0) as u8,
                    uv_transform: uv_transform(offset, angle, scale),
                }
            }
        };
        if value.get("channel").is_some() {
            let channel = super::choice(value, "channel", &[("r", 0), ("g", 1), ("b", 2), ("a", 3)])?;
            result = Value::Channel(Box::new(result), channel);
        }
        if let Some(item) = value.get("factor") {
            let factor = color(value, "factor", item)?;
            result = Value::Multiply(Box::new(Value::Constant(factor)), Box::new(result));
        }
        Ok(result)
    }

    /// Applies `[material."Name"]` to what the models brought: by name, else by the number in its file.
    pub fn patch_materials(&mut self, patches: &[Patch<'a>], brought: &[Brought]) -> Result<(), Error> {
        for patch in patches {
            let table = Table::over(self.source, keys::MATERIAL.name, patch.at.clone(), patch.entries);
            let found = super::model::find_materials(&self.scene, brought, patch.name)
                .map_err(|reason| self.source.error(patch.at.clone(), reason))?;
            for index in found {
                let base = self.scene.materials[index].clone();
                self.scene.materials[index] = self.material(&table, Some(&base), &base.name, &mut Vec::new())?;
            }
        }
        Ok(())
    }
}

fn is_metal(item: &Item<'_>) -> bool {
    item.get_ref().get("metal").is_some()
}

/// `[[nm, value], ...]`.
fn curve(value: &Table<'_>, rows: &[[f64; 2]]) -> Result<Value, Error> {
    let is_ascending = rows.windows(2).all(|w| w[0][0] < w[1][0]);
    if rows.is_empty() || !is_ascending || rows[0][0] <= 0.0 || rows.iter().any(|r| r[1] < 0.0) {
        return Err(value.error("curve", "must be [[nm, value], ...] with rising wavelengths and no negative value"));
    }
    let (wavelength_nm, values) = rows.iter().map(|r| (r[0], r[1])).unzip();
    Ok(Value::Curve(Arc::new(Curve { wavelength_nm, value: values })))
}

/// `offset + R * (scale * uv)`, the matrix of KHR_texture_transform. v runs down, so that R turns u towards -v.
pub fn uv_transform(offset: DVec2, angle_rad: f64, scale: DVec2) -> DAffine2 {
    let (sin, cos) = angle_rad.sin_cos();
    DAffine2 {
        matrix2: DMat2::from_cols(DVec2::new(cos, -sin) * scale.x, DVec2::new(sin, cos) * scale.y),
        translation: offset,
    }
}

/// A number for all channels, `[r, g, b]` or `[r, g, b, a]`.
pub fn color(table: &Table<'_>, key: &str, item: &Item<'_>) -> Result<[f64; 4], Error> {
    match item.get_ref().as_array().map(|a| a.iter().count()) {
        None => Ok([table.number_of(key, item)?; 4]),
        Some(4) => table.numbers_of(key, item),
        Some(_) => {
            let c = DVec3::from(table.numbers_of::<3>(key, item)?);
            Ok([c.x, c.y, c.z, 1.0])
        }
    }
}
