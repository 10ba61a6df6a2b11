//! `group`: the light group of a lamp, of the sky, and of what shines on shapes and in models.

use ::toml::de::DeValue;

use super::table::Table;
use super::{Builder, keys};
use crate::scene::{Error, Material, Sky, SkyRadiance};

/// The key `group`: a name that a layer of a picture can have.
pub fn group(table: &Table<'_>) -> Result<Option<String>, Error> {
    let Some(name) = table.text("group")? else { return Ok(None) };
    let is_plain = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    if !(1..=32).contains(&name.len()) || !name.chars().all(is_plain) {
        return Err(table.error("group", "must be 1 to 32 letters, digits, _ or -: it becomes the name of a layer"));
    }
    Ok(Some(name.to_owned()))
}

const DARK: &str = "names the light group of what this emits, and it emits nothing";

impl<'a> Builder<'a> {
    /// A note for every `[[material]]` that has a group and shines nowhere: neither by itself, nor by the power of a shape.
    pub fn note_dark_groups(&mut self, top: &Table<'a>) -> Result<(), Error> {
        // Not where `[material."Name"]` patches what a model brought.
        let all = top.get("material").and_then(|item| item.get_ref().as_array());
        for item in all.into_iter().flat_map(|array| array.iter()) {
            let DeValue::Table(entries) = item.get_ref() else { continue };
            let table = Table::over(self.source, keys::MATERIAL.name, item.span(), entries);
            let (Some(group), Some(name)) = (group(&table)?, table.text("name")?) else { continue };
            let shines = |m: &Material| m.name == name && m.emits();
            if !self.scene.materials.iter().any(shines) {
                let reason = format!("(\"{group}\") {DARK}");
                self.scene.notes.push(table.error("group", reason).to_string());
            }
        }
        Ok(())
    }

    /// The sky's group, with a note where the sky is black.
    pub fn sky_group(&mut self, table: &Table<'a>, sky: &Sky) -> Result<(), Error> {
        self.scene.sky_group = group(table)?;
        let is_black = sky.scale == 0.0 || matches!(sky.radiance, SkyRadiance::Uniform(r) if r.max_element() == 0.0);
        if is_black && self.scene.sky_group.is_some() {
            self.scene.notes.push(table.error("group", DARK).to_string());
        }
        Ok(())
    }

    /// The material, or its copy in the group that `table` names. Equal ones share a copy.
    pub fn in_group(&mut self, table: &Table<'a>, material: usize) -> Result<usize, Error> {
        let Some(name) = group(table)? else { return Ok(material) };
        let own = &self.scene.materials[material];
        if !own.emits() {
            return Err(table.error("group", format!("{DARK}; remove it")));
        }
        if own.group.as_deref() == Some(&name) {
            return Ok(material);
        }
        let next = self.scene.materials.len();
        let number = *self.grouped.entry((material, name.clone())).or_insert(next);
        if number == next {
            let copy = Material { group: Some(name), ..own.clone() };
            self.scene.materials.push(copy);
        }
        Ok(number)
    }
}
