//! `[[model]]`: other files brought into the scene, and how patches find what they brought.

use std::collections::HashMap;
use std::ops::Range;

use ::toml::de::DeValue;

use super::table::Table;
use super::transform::transform;
use super::{Builder, keys};
use crate::scene::format::load_model;
use crate::scene::{Choice, Error, Instance, MAX_RADIANCE, Scene, Shape, SkyRadiance, Texture, Value};

/// What one model added to the scene's lists.
pub struct Brought {
    file: String,
    materials: Range<usize>,
    /// For each of `materials`, its number in the file.
    material_source: Vec<Option<usize>>,
    instances: Range<usize>,
    /// For each of `instances`, its node's number in the file.
    node_source: Vec<usize>,
    lights: Range<usize>,
    /// For each of `lights`, its node's path and number in the file.
    light_source: Vec<(String, usize)>,
}

impl<'a> Builder<'a> {
    pub fn models(&mut self, top: &Table<'a>) -> Result<Vec<Brought>, Error> {
        let mut brought = Vec::new();
        let mut meshes = HashMap::new();
        for item in top.tables("model")? {
            let table = Table::open(self.source, item, &[&keys::MODEL], &[])?;
            let file = table.text("file")?.ok_or_else(|| table.missing("file"))?;
            let path = self.path(&table, "file", file)?;
            let place = transform(&table)?;
            let scene = table.whole("scene", 0..1 << 32)?.map(|n| n as usize);
            let choice = Choice { variant: table.text("variant")?, scene };
            let loaded = load_model(&path, choice).map_err(|e| table.error("file", format!("cannot be used: {e}")))?;
            let mut model = loaded.scene;
            let copies = self.copies(&table, &|_| Ok(()))?;
            let own = std::mem::take(&mut model.instances);
            for copy in &copies {
                model
                    .instances
                    .extend(own.iter().map(|i| Instance { to_world: *copy * place * i.to_world, ..i.clone() }));
            }
            model.camera.to_world = copies[0] * place * model.camera.to_world;
            let light_scale = table.number("light_scale")?.unwrap_or(1.0);
            if light_scale < 0.0 {
                return Err(table.error("light_scale", "must not be negative"));
            }
            let lights = std::mem::take(&mut model.lights);
            for copy in &copies {
                for light in &lights {
                    let mut light = light.clone();
                    light.lamp.model_mut().place(&(*copy * place));
                    light.lamp.model_mut().brighten(light_scale);
                    // A power of 4 pi sr at most for each unit of strength.
                    if light.lamp.model().power(1.0).max_element() > 4.0 * std::f64::consts::PI * MAX_RADIANCE {
                        let reason =
                            format!("makes the light \"{}\" stronger than {MAX_RADIANCE:e}; lower it", light.name);
                        return Err(table.error("light_scale", reason));
                    }
                    model.lights.push(light);
                }
            }
            if let Some(group) = super::group::group(&table)? {
                model.lights.iter_mut().for_each(|l| l.group = Some(group.clone()));
                model.materials.iter_mut().for_each(|m| m.group = Some(group.clone()));
            }
            let (materials, instances) = (self.scene.materials.len(), self.scene.instances.len());
            let first_light = self.scene.lights.len();
            // A file that was brought before has its meshes here already: both places share them.
            let first_mesh = *meshes.entry((path, table.text("variant")?, scene)).or_insert(self.scene.meshes.len());
            if first_mesh < self.scene.meshes.len() {
                model.meshes.clear();
            }
            append(&mut self.scene, model, first_mesh);
            brought.push(Brought {
                file: file.to_string(),
                materials: materials..self.scene.materials.len(),
                material_source: loaded.material_source,
                instances: instances..self.scene.instances.len(),
                node_source: loaded.node_source.repeat(copies.len()),
                lights: first_light..self.scene.lights.len(),
                light_source: vec![loaded.light_source; copies.len()].concat(),
            });
        }
        Ok(brought)
    }

    pub fn patch_nodes(&mut self, top: &Table<'a>, brought: &[Brought]) -> Result<(), Error> {
        let Some(item) = top.get("node") else { return Ok(()) };
        let DeValue::Table(entries) = item.get_ref() else {
            return Err(self.source.error(item.span(), "write [node.\"path/name\"], with the node's name"));
        };
        let all = Table::over(self.source, keys::NODE.name, item.span(), entries);
        let instance_count = self.scene.instances.len();
        // Of instances, then of lights.
        let mut hidden = vec![false; instance_count + self.scene.lights.len()];
        for (key, item) in all.entries() {
            let table = Table::open(self.source, item, &[&keys::NODE], &[])?;
            let found = find_nodes(&self.scene, brought, key.get_ref())
                .map_err(|reason| self.source.error(key.span(), reason))?;
            if table.boolean("visible")? == Some(false) {
                found.iter().for_each(|i| hidden[*i] = true);
            }
            if let Some(name) = table.text("material")? {
                let material = self.named(&self.materials, &table, "material", name)?;
                let of_shapes = || found.iter().filter(|i| **i < instance_count);
                if of_shapes().next().is_none() {
                    return Err(table.error("material", "is given to a node that has a light and no shape; remove it"));
                }
                of_shapes().for_each(|i| self.scene.instances[*i].material = material);
            }
            if let Some(name) = super::group::group(&table)? {
                self.group_nodes(&table, &found, &name)?;
            }
        }
        let mut is_hidden = hidden.into_iter();
        self.scene.instances.retain(|_| is_hidden.next() != Some(true));
        self.scene.lights.retain(|_| is_hidden.next() != Some(true));
        Ok(())
    }
}

impl<'a> Builder<'a> {
    /// Puts what shines of a node into a light group.
    fn group_nodes(&mut self, table: &Table<'a>, found: &[usize], name: &str) -> Result<(), Error> {
        let instance_count = self.scene.instances.len();
        let mut is_any = false;
        for &index in found {
            if let Some(light) = index.checked_sub(instance_count) {
                self.scene.lights[light].group = Some(name.to_owned());
                is_any = true;
            } else if self.scene.materials[self.scene.instances[index].material].emits() {
                self.scene.instances[index].material = self.in_group(table, self.scene.instances[index].material)?;
                is_any = true;
            }
        }
        let reason = "names the light group of what the node emits, and it emits nothing; remove it";
        if is_any { Ok(()) } else { Err(table.error("group", reason)) }
    }
}

/// Materials of this name, else of this number; one material of a file may stand in the scene several times.
pub fn find_materials(scene: &Scene, brought: &[Brought], name: &str) -> Result<Vec<usize>, String> {
    let entries = brought.iter().enumerate().flat_map(|(model, b)| {
        b.materials.clone().zip(&b.material_source).map(move |(index, source)| (index, model, *source))
    });
    let entries: Vec<_> = entries
        .map(|(index, model, source)| Candidate { index, model, source, name: scene.materials[index].name.clone() })
        .collect();
    find(entries, brought, name, "material")
}

/// Instances of the node with this path, else this last name, else this number; its lights are numbered after all instances.
pub fn find_nodes(scene: &Scene, brought: &[Brought], name: &str) -> Result<Vec<usize>, String> {
    let entries = brought.iter().enumerate().flat_map(|(model, b)| {
        b.instances.clone().zip(&b.node_source).map(move |(index, source)| (index, model, Some(*source)))
    });
    let lights = brought.iter().enumerate().flat_map(|(model, b)| {
        b.lights.clone().zip(&b.light_source).map(move |(light, (path, source))| (light, model, *source, path))
    });
    let mut entries: Vec<_> = entries
        .map(|(index, model, source)| Candidate { index, model, source, name: scene.instances[index].name.clone() })
        .collect();
    entries.extend(lights.map(|(light, model, source, path)| Candidate {
        index: scene.instances.len() + light,
        model,
        source: Some(source),
        name: path.clone(),
    }));
    if !entries.iter().any(|e| e.name == name) {
        for entry in &mut entries {
            let last = entry.name.rsplit('/').next().unwrap_or("").to_string();
            if last == name {
                entry.name = last;
            }
        }
    }
    find(entries, brought, name, "node")
}

struct Candidate {
    index: usize,
    model: usize,
    source: Option<usize>,
    name: String,
}

fn find(entries: Vec<Candidate>, brought: &[Brought], name: &str, what: &str) -> Result<Vec<usize>, String> {
    let mut found: Vec<&Candidate> = entries.iter().filter(|e| e.name == name).collect();
    if found.is_empty()
        && let Ok(number) = name.parse::<usize>()
    {
        found = entries.iter().filter(|e| e.source == Some(number)).collect();
    }
    let Some(first) = found.first() else {
        let mut names: Vec<&str> = entries.iter().map(|e| e.name.as_str()).collect();
        names.sort_unstable();
        names.dedup();
        return Err(format!("no model brought a {what} \"{name}\"; {}", super::nearest(name, names.into_iter())));
    };
    if let Some(other) = found.iter().find(|e| (e.model, e.source) != (first.model, first.source)) {
        let place = |c: &Candidate| format!("{} of {}", c.source.unwrap_or(0), brought[c.model].file);
        return Err(format!(
            "\"{name}\" is both {what} {} and {what} {}; name it by number, or rename one",
            place(first),
            place(other)
        ));
    }
    Ok(found.iter().map(|e| e.index).collect())
}

/// Adds everything of `other` behind what `scene` has; its camera and sky only where there is none. Its mesh 0 is the scene's `meshes`.
fn append(scene: &mut Scene, mut other: Scene, meshes: usize) {
    let (images, textures) = (scene.images.len(), scene.textures.len());
    let materials = scene.materials.len();
    for texture in &mut other.textures {
        if let Texture::Image { image, .. } = texture {
            *image += images;
        }
    }
    for material in &mut other.materials {
        use crate::scene::Alpha;
        material.inputs.iter_mut().for_each(|v| shift(v, textures));
        material.emission.iter_mut().for_each(|v| shift(v, textures));
        material.normal_map.iter_mut().for_each(|v| shift(&mut v.0, textures));
        if let Alpha::Mask { value, .. } | Alpha::Blend { value } = &mut material.alpha {
            shift(value, textures);
        }
    }
    for instance in &mut other.instances {
        instance.material += materials;
        if let Shape::Mesh(mesh) = &mut instance.shape {
            *mesh += meshes;
        }
    }
    if let Some(sky) = &mut other.sky
        && let SkyRadiance::Image(image) = &mut sky.radiance
    {
        *image += images;
    }
    scene.images.append(&mut other.images);
    scene.textures.append(&mut other.textures);
    scene.materials.append(&mut other.materials);
    scene.meshes.append(&mut other.meshes);
    scene.instances.append(&mut other.instances);
    scene.variants.append(&mut other.variants);
    scene.notes.append(&mut other.notes);
    scene.lights.append(&mut other.lights);
    if !scene.camera.is_placed && other.camera.is_placed {
        scene.camera = other.camera;
    }
    scene.sky = scene.sky.take().or(other.sky);
}

fn shift(value: &mut Value, textures: usize) {
    match value {
        Value::Texture { texture, .. } => *texture += textures,
        Value::Multiply(a, b) => {
            shift(a, textures);
            shift(b, textures);
        }
        Value::Channel(a, _) | Value::Share(a) | Value::Rest(a) => shift(a, textures),
        Value::Constant(_) | Value::Curve(_) | Value::VertexColor => {}
    }
}
