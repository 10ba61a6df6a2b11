//! What a scene needs and what its kernel leaves out, measured against the kernel with everything compiled in.

use serde::Serialize;

use crate::bsdf;
use crate::bvh::Node4;
use crate::error::Error;
use crate::gpu::Device;
use crate::gpu::renderer::{KernelOptions, KernelStats, Renderer};
use crate::integrator::Settings;
use crate::prepare::Prepared;
use crate::prepare::features::Features;
use crate::prepare::records::InstanceRecord;
use crate::shader::assemble;
use crate::shader::tables::TABLES;

/// The report of `inspect`.
#[derive(Debug, Serialize)]
pub struct Inspection {
    /// In the table: those of a placed mesh once.
    pub triangles: usize,
    /// Placed meshes; 0 in a scene of one level.
    pub placements: usize,
    pub placed_meshes: usize,
    /// Triangles that the placements stand for.
    pub placed_triangles: u64,
    /// What a placement costs, with its share of the upper tree; 0 without any.
    pub bytes_a_placement: f64,
    pub spheres: usize,
    pub discs: usize,
    pub materials: usize,
    /// Distinct pattern functions that the materials share.
    pub patterns: usize,
    pub textures: usize,
    /// Material variants that the scene's files offer.
    pub variants: Vec<String>,
    pub lights: usize,
    pub bvh_nodes: usize,
    pub bvh_depth: u32,
    pub features_in: Vec<String>,
    pub features_out: Vec<String>,
    /// Name and bytes of the tables the kernel reads.
    pub tables: Vec<(&'static str, u64)>,
    pub tables_out: Vec<&'static str>,
    pub bytes: u64,
    /// Geometry tables and tree by triangle; 0 without triangles.
    pub bytes_a_triangle: f64,
    /// Absent without a Vulkan device.
    pub kernels: Option<Kernels>,
}

/// The same scene's kernel both ways.
#[derive(Debug, Serialize)]
pub struct Kernels {
    pub device: String,
    pub specialised: KernelStats,
    pub everything: KernelStats,
}

/// Inspects without a device: features, tables and their bytes.
pub fn inspect(prepared: &Prepared, settings: &Settings) -> Inspection {
    let features = Features::of(prepared, settings);
    let mut features_in = Vec::new();
    let mut features_out = Vec::new();
    for (name, is_in) in features.names() {
        if is_in { &mut features_in } else { &mut features_out }.push(name);
    }
    let tables: Vec<(&'static str, u64)> =
        features.tables().map(|t| (t.name, (t.rows)(prepared).len() as u64 * 16)).collect();
    let geometry = ["bvh", "instances", "triangles", "faces", "normals", "tangents", "uvs", "colors"];
    let placements = prepared.instances.len().saturating_sub(1);
    let upper_nodes = prepared.bvh.roots.first().map_or(0, |&first| first as usize);
    let upper_bytes = size_of::<InstanceRecord>() * placements + size_of::<Node4>() * upper_nodes;
    let geometry_bytes: u64 = tables.iter().filter(|(name, _)| geometry.contains(name)).map(|(_, b)| b).sum();
    Inspection {
        triangles: prepared.triangles.len(),
        placements,
        placed_meshes: prepared.bvh.roots.len(),
        placed_triangles: prepared.placed_triangle_count(),
        bytes_a_placement: upper_bytes as f64 / placements.max(1) as f64,
        spheres: prepared.spheres.len(),
        discs: prepared.discs.len(),
        materials: prepared.materials.len(),
        patterns: prepared.structures.len(),
        textures: prepared.textures.len(),
        variants: Vec::new(),
        lights: prepared.lights.len(),
        bvh_nodes: prepared.bvh.nodes.len(),
        bvh_depth: prepared.bvh.depth,
        features_in,
        features_out,
        bytes: tables.iter().map(|(_, b)| b).sum(),
        bytes_a_triangle: geometry_bytes as f64 / prepared.triangles.len().max(1) as f64,
        tables_out: TABLES.iter().filter(|t| !(t.is_needed)(&features)).map(|t| t.name).collect(),
        tables,
        kernels: None,
    }
}

/// Compiles both kernels without the cache, so that their compile times can be compared.
pub fn kernels(device: &Device, prepared: &Prepared, settings: &Settings) -> Result<Kernels, Error> {
    let make = |everything| {
        let options = KernelOptions { everything, no_cache: true, ..KernelOptions::default() };
        Renderer::new(device, prepared, settings, &options).map(|r| r.stats)
    };
    Ok(Kernels { device: device.info().name.clone(), specialised: make(false)?, everything: make(true)? })
}

/// The assembled GLSL of the specialised kernel.
pub fn glsl(device: &Device, prepared: &Prepared, settings: &Settings) -> Result<String, Error> {
    let features = Features::of(prepared, settings);
    let rows = |name: &str| TABLES.iter().find(|t| t.name == name).map_or(0, |t| (t.rows)(prepared).len());
    Ok(assemble::assemble(&features, settings, prepared, device.info(), rows)?.source.text())
}

impl Features {
    /// Every feature by name, and whether it is in the text.
    pub fn names(&self) -> Vec<(String, bool)> {
        let mut names: Vec<(String, bool)> =
            self.defines().into_iter().map(|(name, is_in)| (name.to_lowercase(), is_in)).collect();
        names.push(("texture_image".to_owned(), self.image_textures));
        names.push(("texture_checker".to_owned(), self.checker_textures));
        for (number, model) in bsdf::MODELS.iter().enumerate() {
            names.push((format!("bsdf_{}", model.keyword), self.bsdfs.contains(&number)));
        }
        names
    }
}

impl Inspection {
    /// For people: what is in, what is out, and what that saved.
    pub fn text(&self) -> String {
        let mut text = format!(
            "{} triangles, {} spheres, {} discs, {} materials in {} patterns, {} textures, {} lights; tree of {} nodes, depth {}\n",
            self.triangles,
            self.spheres,
            self.discs,
            self.materials,
            self.patterns,
            self.textures,
            self.lights,
            self.bvh_nodes,
            self.bvh_depth
        );
        if !self.variants.is_empty() {
            text += &format!("material variants: {}\n", self.variants.join(", "));
        }
        if self.placements > 0 {
            text += &format!(
                "{} placements of {} meshes stand for {} triangles, {:.0} bytes each\n",
                self.placements, self.placed_meshes, self.placed_triangles, self.bytes_a_placement
            );
        }
        text += &format!("in:  {}\nout: {}\n", self.features_in.join(" "), self.features_out.join(" "));
        text += "table            bytes\n";
        for (name, bytes) in &self.tables {
            text += &format!("{name:<14}{bytes:>8}\n");
        }
        text += &format!("total         {:>8}; {:.0} bytes a triangle\n", self.bytes, self.bytes_a_triangle);
        text += &format!("without {}\n", self.tables_out.join(", "));
        if let Some(k) = &self.kernels {
            let ratio = |a: f64, b: f64| format!("{:.2}", a / b.max(1e-9));
            let (s, e) = (&k.specialised, &k.everything);
            let bytes = |k: &KernelStats| k.table_bytes.iter().map(|(_, b)| *b).sum::<u64>();
            text += &format!("{:<24}{:>12}{:>14}{:>8}\n", k.device, "specialised", "everything-on", "ratio");
            text += &format!(
                "SPIR-V words            {:>12}{:>14}{:>8}\n",
                s.spirv_words,
                e.spirv_words,
                ratio(s.spirv_words as f64, e.spirv_words as f64)
            );
            text += &format!(
                "compile, cold, s        {:>12.3}{:>14.3}{:>8}\n",
                s.compile_s,
                e.compile_s,
                ratio(s.compile_s, e.compile_s)
            );
            text += &format!(
                "device bytes of tables  {:>12}{:>14}{:>8}\n",
                bytes(s),
                bytes(e),
                ratio(bytes(s) as f64, bytes(e) as f64)
            );
        }
        text
    }
}
