//! glTF 2.0 (ISO/IEC 12113:2022), .gltf and .glb: the default scene as triangles, materials, textures and a camera.
//!
//! Shaded: metallic-roughness with all its textures, vertex colours, two coordinate sets, normal maps (tangents from
//! the file, else MikkTSpace), emission, alpha masks and blending, and the extensions in `SHADED`. Read and reported, but
//! left out: points, lines, skins, animations, morph targets, further coordinate sets, and the extensions in `PLAINER`. What
//! a file requires and this does not shade is an error. Everything reported is in `Scene::notes`. An unlit material
//! (KHR_materials_unlit) is black and shines with its base colour, 1 for white, so that no light changes how it looks; as what
//! shines here lights its surroundings, it does so too.
//! Single-sided surfaces are seen from both sides; their emission leaves the front only.
//! Tests: tests/formats, on files made to be wrong and on the sample models.

mod buffers;
mod container;
mod document;
mod layers;
mod lights;
mod materials;
mod meshes;
mod nodes;
mod textures;
mod variants;

use std::collections::{BTreeSet, HashMap};
use std::path::Path;

use glam::{DAffine3, DMat3};

use super::Choice;
use super::toml::is_invertible;
use crate::scene::{Camera, Error, Instance, Projection, Scene, Shape};
use buffers::File;
use document::{Document, Node};
use materials::Wear;

/// Extensions whose meaning reaches the picture.
const SHADED: &[&str] = &[
    "EXT_mesh_gpu_instancing",
    "EXT_texture_webp",
    "KHR_lights_punctual",
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_variants",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_node_visibility",
    "KHR_texture_transform",
];

/// Extensions that say nothing about a still picture.
const SILENT: &[&str] = &["KHR_animation_pointer", "KHR_xmp", "KHR_xmp_json_ld"];

/// Extensions that may be left out without the file losing its shape: the surface looks plainer, a light is missing.
const PLAINER: &[&str] = &[
    "KHR_materials_diffuse_transmission",
    "KHR_materials_dispersion",
    "KHR_materials_iridescence",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_sheen",
    "KHR_materials_volume_scatter",
];

/// A model, and where its parts stand in the file.
pub struct Loaded {
    pub scene: Scene,
    /// For each material, its number in the file; None for the default one.
    pub material_source: Vec<Option<usize>>,
    /// For each instance, its node's number.
    pub node_source: Vec<usize>,
    /// For each light, its node's path and number.
    pub light_source: Vec<(String, usize)>,
}

pub fn load(path: &Path, choice: Choice<'_>) -> Result<Loaded, Error> {
    let file = container::open(path)?;
    let mut scene = Scene { source: path.to_path_buf(), ..Default::default() };
    check_extensions(&file, &mut scene.notes)?;
    note_motion(&file.document, &mut scene.notes);
    let variant = variants::chosen(&file, choice.variant, &mut scene)?;
    let placed = nodes::placed(&file, choice.scene, &mut scene.notes)?;
    let mut builder = Builder {
        file: &file,
        scene,
        variant,
        primitives: HashMap::new(),
        uses: Vec::new(),
        node_source: Vec::new(),
        light_source: Vec::new(),
    };
    for entry in &placed {
        builder.node(entry)?;
    }
    builder.finish()
}

struct Builder<'f> {
    file: &'f File<'f>,
    scene: Scene,
    /// Number of the variant that materials are taken from.
    variant: Option<usize>,
    /// (mesh, primitive) of the file to a mesh of the scene; None where nothing could be seen.
    primitives: HashMap<(usize, usize), Option<usize>>,
    /// For each instance, the material of the file it wears, and how.
    uses: Vec<(Option<usize>, Wear)>,
    node_source: Vec<usize>,
    light_source: Vec<(String, usize)>,
}

impl Builder<'_> {
    fn node(&mut self, placed: &nodes::Placed) -> Result<(), Error> {
        let node = &self.file.document.nodes[placed.node];
        if let Some(camera) = node.camera {
            self.camera(camera, placed)?;
        }
        if let Some(light) = &node.extensions.light {
            self.scene.lights.push(lights::read(self.file, light.light, placed, &mut self.scene.notes)?);
            self.light_source.push((placed.path.clone(), placed.node));
        }
        let Some(mesh) = node.mesh else { return Ok(()) };
        let place = nodes::place(self.file, placed.node);
        let entry = self.file.at(&self.file.document.meshes, mesh, "mesh", &place)?;
        let transforms = instancing(self.file, node, &place)?;
        for number in 0..entry.primitives.len() {
            let Some(index) = self.primitive(mesh, number)? else { continue };
            let material = variants::material(&entry.primitives[number], self.variant);
            if let Some(material) = material {
                let place = meshes::place(&self.file.document, mesh, number);
                self.file.at(&self.file.document.materials, material, "material", &place)?;
            }
            let shape = &self.scene.meshes[index];
            let wear = Wear { has_color: shape.colors.is_some(), has_tangents: shape.tangents.is_some() };
            for local in &transforms {
                let to_world = placed.to_world * *local;
                if !(to_world.is_finite() && is_invertible(&to_world.matrix3)) {
                    let reason = "its transform has no inverse (a scale of 0, or axes that fall together); give it a size, or remove the node";
                    return Err(self.file.error(place, reason));
                }
                self.scene.instances.push(Instance {
                    name: placed.path.clone(),
                    shape: Shape::Mesh(index),
                    to_world,
                    material: 0,
                });
                self.uses.push((material, wear));
                self.node_source.push(placed.node);
            }
        }
        Ok(())
    }

    fn primitive(&mut self, mesh: usize, number: usize) -> Result<Option<usize>, Error> {
        if let Some(known) = self.primitives.get(&(mesh, number)) {
            return Ok(*known);
        }
        let material = variants::material(&self.file.document.meshes[mesh].primitives[number], self.variant);
        let index = match meshes::read(self.file, (mesh, number), material, &mut self.scene.notes)? {
            meshes::Read::Nothing => None,
            meshes::Read::Mesh(mesh) => {
                self.scene.meshes.push(*mesh);
                Some(self.scene.meshes.len() - 1)
            }
        };
        self.primitives.insert((mesh, number), index);
        Ok(index)
    }

    /// The first camera places the scene's; its scale is no part of the view.
    fn camera(&mut self, index: usize, placed: &nodes::Placed) -> Result<(), Error> {
        let place = nodes::place(self.file, placed.node);
        let entry = self.file.at(&self.file.document.cameras, index, "camera", &place)?;
        if self.scene.camera.is_placed {
            self.scene.notes.push("the file has several cameras, the first is taken".into());
            return Ok(());
        }
        let fail = |reason: &str| Err(self.file.error(format!("camera {index}"), reason.to_owned()));
        let projection = match (entry.r#type.as_str(), &entry.perspective, &entry.orthographic) {
            ("perspective", Some(p), _) if p.yfov > 0.0 && p.yfov < std::f64::consts::PI => {
                Projection::Perspective { fov_y_rad: p.yfov }
            }
            ("perspective", Some(_), _) => return fail("`yfov` must be above 0 and below pi; correct it"),
            // Half extents; their sign mirrors nothing here.
            ("orthographic", _, Some(o)) if [o.xmag, o.ymag].iter().all(|m| m.is_finite() && *m != 0.0) => {
                Projection::Orthographic { half_width: o.xmag.abs(), half_height: o.ymag.abs() }
            }
            ("orthographic", _, Some(_)) => return fail("`xmag` and `ymag` must not be 0; correct them"),
            (kind, ..) => {
                self.scene.notes.push(format!("{place}: camera of type \"{kind}\" without its parameters left out"));
                return Ok(());
            }
        };
        let m = placed.to_world.matrix3;
        let back = m.z_axis.normalize_or_zero();
        let right = m.y_axis.cross(back).normalize_or_zero();
        let matrix3 = DMat3::from_cols(right, back.cross(right), back);
        if !is_invertible(&matrix3) {
            return Err(self.file.error(place, "its camera has no orientation (a scale of 0); give it a size"));
        }
        self.scene.camera = Camera {
            to_world: DAffine3 { matrix3, translation: placed.to_world.translation },
            projection,
            is_placed: true,
        };
        Ok(())
    }

    /// Textures and materials of what was placed, one material for each way in which it is worn.
    fn finish(mut self) -> Result<Loaded, Error> {
        let document = &self.file.document;
        let used: BTreeSet<usize> = self.uses.iter().filter_map(|u| u.0).collect();
        let infos = used.iter().flat_map(|m| document.materials[*m].texture_infos());
        let textures: BTreeSet<usize> = infos.map(|info| info.index).collect();
        let textures: Vec<usize> = textures.into_iter().collect();
        let mut textures = textures::Textures::read(self.file, &textures, &mut self.scene)?;
        let mut numbers: HashMap<(Option<usize>, Wear), usize> = HashMap::new();
        let mut material_source = Vec::new();
        for (instance, (source, wear)) in self.uses.iter().enumerate() {
            let entry = source.map(|s| &document.materials[s]);
            let maps_normals = entry.is_some_and(|e| e.normal_texture.is_some());
            let follows_tangent = entry.is_some_and(|e| e.follows_tangent());
            let key = (*source, Wear { has_tangents: wear.has_tangents && follows_tangent, ..*wear });
            let number = match numbers.get(&key) {
                Some(number) => *number,
                None => {
                    let material = materials::build(self.file, *source, key.1, &mut textures, &mut self.scene)?;
                    if maps_normals && !wear.has_tangents {
                        let name = &material.name;
                        self.scene.notes.push(format!(
                            "{name}: normal map left out where a mesh has no texture coordinates for it"
                        ));
                    }
                    self.scene.materials.push(material);
                    material_source.push(*source);
                    numbers.insert(key, self.scene.materials.len() - 1);
                    self.scene.materials.len() - 1
                }
            };
            self.scene.instances[instance].material = number;
        }
        dedup(&mut self.scene.notes);
        Ok(Loaded {
            scene: self.scene,
            material_source,
            node_source: self.node_source,
            light_source: self.light_source,
        })
    }
}

/// EXT_mesh_gpu_instancing: one transform an instance; a node without it is one instance of itself.
fn instancing(file: &File<'_>, node: &Node, place: &str) -> Result<Vec<DAffine3>, Error> {
    let Some(instancing) = &node.extensions.instancing else { return Ok(vec![DAffine3::IDENTITY]) };
    let get = |key: &str| instancing.attributes.get(key).copied();
    let translation = get("TRANSLATION").map(|a| file.floats::<3>(a, place)).transpose()?;
    let rotation = get("ROTATION").map(|a| file.floats::<4>(a, place)).transpose()?;
    let scale = get("SCALE").map(|a| file.floats::<3>(a, place)).transpose()?;
    let lengths = [translation.as_ref().map(Vec::len), rotation.as_ref().map(Vec::len), scale.as_ref().map(Vec::len)];
    let count = lengths.iter().flatten().copied().max().unwrap_or(0);
    if lengths.iter().flatten().any(|l| *l != count) {
        return Err(file.error(place, "its instance attributes differ in length; export it again"));
    }
    let mut transforms = Vec::with_capacity(count);
    for i in 0..count {
        let t = translation.as_ref().map_or([0.0; 3], |l| l[i].map(f64::from));
        let r = rotation.as_ref().map_or([0.0, 0.0, 0.0, 1.0], |l| l[i].map(f64::from));
        let s = scale.as_ref().map_or([1.0; 3], |l| l[i].map(f64::from));
        transforms.push(nodes::trs(t, r, s).map_err(|reason| file.error(format!("{place} instance {i}"), reason))?);
    }
    Ok(transforms)
}

fn check_extensions(file: &File<'_>, notes: &mut Vec<String>) -> Result<(), Error> {
    let document = &file.document;
    let is_read = |name: &str| SHADED.contains(&name) || SILENT.contains(&name);
    let is_plainer = |name: &str| PLAINER.contains(&name);
    if let Some(name) = document.extensions_required.iter().find(|n| !is_read(n)) {
        let why = if is_plainer(name) { "which is not shaded yet" } else { "which is not supported" };
        let reason = format!("the file requires {name}, {why}; export it without, or convert it");
        return Err(file.error("extensionsRequired", reason));
    }
    let named = |keep: &dyn Fn(&str) -> bool| {
        let names: BTreeSet<&str> = document.extensions_used.iter().map(String::as_str).filter(|n| keep(n)).collect();
        names.into_iter().collect::<Vec<_>>().join(", ")
    };
    let plain = named(&is_plainer);
    if !plain.is_empty() {
        notes.push(format!("extensions known but not shaded yet: {plain}"));
    }
    let unknown = named(&|n| !is_read(n) && !is_plainer(n));
    if !unknown.is_empty() {
        notes.push(format!("optional extensions not supported, left out: {unknown}"));
    }
    Ok(())
}

fn note_motion(document: &Document, notes: &mut Vec<String>) {
    if !document.animations.is_empty() {
        notes.push(format!("{} animations left out, the pose at rest is taken", document.animations.len()));
    }
    let skinned = document.nodes.iter().filter(|n| n.skin.is_some() && n.mesh.is_some()).count();
    if skinned > 0 {
        notes.push(format!("{skinned} skinned meshes stand in their bind pose, as modelled"));
    }
}

fn dedup(notes: &mut Vec<String>) {
    let mut seen = std::collections::HashSet::new();
    notes.retain(|n| seen.insert(n.clone()));
}
