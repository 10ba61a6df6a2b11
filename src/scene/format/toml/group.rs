//! `group`: the light group of a lamp, of the sky, and of what shines on shapes and in models.

use super::Builder;
use super::table::Table;
use crate::scene::Error;

/// The key `group`: a name that a layer of a picture can have.
pub fn group(table: &Table<'_>) -> Result<Option<String>, Error> {
    let Some(name) = table.text("group")? else { return Ok(None) };
    let is_plain = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    if !(1..=32).contains(&name.len()) || !name.chars().all(is_plain) {
        return Err(table.error("group", "must be 1 to 32 letters, digits, _ or -: it becomes the name of a layer"));
    }
    Ok(Some(name.to_owned()))
}

impl<'a> Builder<'a> {
    /// The material, or its copy in the group that `table` names. Equal ones share a copy.
    pub fn in_group(&mut self, table: &Table<'a>, material: usize) -> Result<usize, Error> {
        let Some(name) = group(table)? else { return Ok(material) };
        let own = &self.scene.materials[material];
        if !own.emits() {
            return Err(
                table.error("group", "names the light group of what this emits, and it emits nothing; remove it")
            );
        }
        if own.group.as_deref() == Some(&name) {
            return Ok(material);
        }
        let next = self.scene.materials.len();
        let number = *self.grouped.entry((material, name.clone())).or_insert(next);
        if number == next {
            let copy = crate::scene::Material { group: Some(name), ..own.clone() };
            self.scene.materials.push(copy);
        }
        Ok(number)
    }
}
