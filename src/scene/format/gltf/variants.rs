//! KHR_materials_variants: a primitive may name another material for each variant of the file.

use super::buffers::File;
use super::document::Primitive;
use crate::scene::{Error, Scene};

/// The number of the variant called `name`; None for the materials that primitives name themselves. Tells the scene all names.
pub fn chosen(file: &File<'_>, name: Option<&str>, scene: &mut Scene) -> Result<Option<usize>, Error> {
    let list = file.document.extensions.variants.as_ref().map_or(&[][..], |v| &v.variants);
    scene.variants = list.iter().map(|v| v.name.clone()).collect();
    let all = scene.variants.join(", ");
    let Some(name) = name else {
        if !list.is_empty() {
            scene.notes.push(format!("variants: the file's own materials taken; --variant chooses one of {all}"));
        }
        return Ok(None);
    };
    let found = list.iter().position(|v| v.name == name);
    found.map(Some).ok_or_else(|| {
        let reason = match list.is_empty() {
            true => format!("has none, and \"{name}\" was asked for; leave the choice out"),
            false => format!("none is called \"{name}\"; choose one of {all}"),
        };
        file.error("variants", reason)
    })
}

/// The material of the variant, else the primitive's own.
pub fn material(primitive: &Primitive, variant: Option<usize>) -> Option<usize> {
    let mappings = primitive.extensions.variants.iter().flat_map(|v| &v.mappings);
    let mapped = variant.and_then(|n| mappings.into_iter().find(|m| m.variants.contains(&n)));
    mapped.map(|m| m.material).or(primitive.material)
}
