//! What a scene and its settings need: the one value from which text, tables and constants of the kernel follow.
//!
//! Everything here is structure. Numbers of the render are specialisation constants, numbers of a dispatch push constants.

use super::Prepared;
use super::pattern::{Node, Role, Structure};
use super::records::*;
use crate::camera;
use crate::film::aov::{Aovs, GROUP_LIMIT, GROUPS};
use crate::integrator::{Estimator, IntegratorKind, SamplerKind, Settings};
use crate::light;
use crate::{bsdf, texture};

/// Derived once by `Features::of`.
#[derive(Clone, Debug, PartialEq)]
pub struct Features {
    pub integrator: IntegratorKind,
    pub sampler: SamplerKind,
    pub estimator: Estimator,
    pub aovs: Aovs,
    /// Light groups of the scene, asked for or not.
    pub group_count: u32,
    /// Cameras in the text, ascending numbers of `camera::MODELS`: the scene's.
    pub cameras: Vec<usize>,
    /// Slots are those of a list; else of a tile and a range of blocks. Only how a kernel is asked says so (`KernelOptions`), so that
    /// `everything` leaves it.
    pub by_list: bool,
    /// Film positions come from the filter's table; else the box of one pixel.
    pub filter: bool,
    pub triangles: bool,
    pub spheres: bool,
    pub discs: bool,
    /// Meshes are placed: a tree of two levels.
    pub instances: bool,
    pub sky: bool,
    pub sky_image: bool,
    /// Kinds of light that next-event estimation can choose, ascending numbers of `light::KINDS`.
    pub lights: Vec<usize>,
    /// Suns, which rays that leave the scene see whether they are sampled or not.
    pub suns: bool,
    pub smooth_normals: bool,
    pub tangents: bool,
    pub uvs: bool,
    pub colors: bool,
    pub emission: bool,
    pub alpha: bool,
    pub normal_maps: bool,
    pub media: bool,
    /// Media may overlap: a path keeps a stack of them.
    pub media_stack: bool,
    /// Some surface lets light through, so that frames keep an outside.
    pub transmission: bool,
    /// Models present, ascending numbers of `bsdf::MODELS`.
    pub bsdfs: Vec<usize>,
    /// Slots: (model, number among equal models of one mixture).
    pub lobes: Vec<(usize, usize)>,
    /// Some material mixes surfaces. Not switched on by `everything`: then all lobes would be added up at every surface.
    pub mixtures: bool,
    /// Macros the models ask for, name and whether it is on.
    pub bsdf_macros: Vec<(&'static str, bool)>,
    pub image_textures: bool,
    pub checker_textures: bool,
    pub texture_half: bool,
    pub texture_wide: bool,
    /// Some texture is read by footprint: paths carry a cone.
    pub texture_mips: bool,
    pub texture_srgb: bool,
    pub texture_nearest: bool,
    pub texture_mirror: bool,
    pub texture_clamp: bool,
    pub structures: Vec<Structure>,
    /// Entries of the traversal stack.
    pub bvh_stack: u32,
}

impl Features {
    pub fn of(p: &Prepared, settings: &Settings) -> Self {
        let has = |bit: u32| p.materials.iter().any(|m| m.flags & bit != 0);
        let uses_lights = settings.estimator != Estimator::Bsdf;
        let mut lights: Vec<usize> = p.lights.iter().filter(|_| uses_lights).map(|l| l.kind as usize).collect();
        lights.sort_unstable();
        lights.dedup();
        let has_texture = |bit: u32| p.textures.iter().any(|t| t.flags & bit != 0);
        let wrap = |mode: u32| {
            p.textures
                .iter()
                .any(|t| (t.flags >> TEXTURE_WRAP_U_SHIFT) & 3 == mode || (t.flags >> TEXTURE_WRAP_V_SHIFT) & 3 == mode)
        };
        let mut lobes: Vec<(usize, usize)> = p.structures.iter().flat_map(Structure::lobes).collect();
        lobes.sort_unstable();
        lobes.dedup();
        let bsdfs = lobes.iter().filter(|l| l.1 == 0).map(|l| l.0).collect();
        let mut f = Self {
            integrator: settings.integrator,
            sampler: settings.sampler,
            estimator: settings.estimator,
            aovs: settings.aovs,
            group_count: p.group_count,
            cameras: vec![p.camera.kind as usize],
            by_list: false,
            filter: !p.filter.is_empty(),
            triangles: !p.triangles.is_empty(),
            spheres: !p.spheres.is_empty(),
            discs: !p.discs.is_empty(),
            instances: !p.instances.is_empty(),
            sky: p.has_sky,
            sky_image: !p.sky_texels.is_empty(),
            lights,
            suns: p.lights.iter().any(|l| l.kind == light::LIGHT_SUN),
            smooth_normals: !p.normals.is_empty(),
            tangents: has(MATERIAL_TANGENT) && !(p.tangents.is_empty() && p.spheres.is_empty() && p.discs.is_empty()),
            uvs: false,
            colors: !p.colors.is_empty(),
            emission: has(MATERIAL_EMITS),
            alpha: has(MATERIAL_MASK | MATERIAL_BLEND),
            normal_maps: has(MATERIAL_NORMAL_MAP),
            media: !p.media.is_empty(),
            media_stack: p.nests,
            transmission: has(MATERIAL_TRANSMITS),
            bsdfs,
            lobes,
            mixtures: p.structures.iter().any(|s| matches!(s.role, Role::Mix(_))),
            bsdf_macros: p.bsdf_macros.clone(),
            image_textures: false,
            checker_textures: false,
            texture_half: has_texture(TEXTURE_HALF),
            texture_wide: has_texture(TEXTURE_WIDE),
            texture_mips: p.textures.iter().any(texture::follows_footprint),
            texture_srgb: has_texture(TEXTURE_SRGB),
            texture_nearest: has_texture(TEXTURE_NEAREST | TEXTURE_MIN_NEAREST),
            texture_mirror: wrap(1),
            texture_clamp: wrap(2),
            structures: p.structures.clone(),
            bvh_stack: p.bvh.stack_size(),
        };
        for structure in &f.structures {
            structure.visit(&mut |node| match node {
                Node::Image { .. } => f.image_textures = true,
                Node::Checker { .. } => f.checker_textures = true,
                _ => {}
            });
        }
        // Spheres and discs have coordinates without any vertex that carries them.
        f.uvs = f.image_textures || f.checker_textures || f.aovs.has("uv");
        f
    }

    /// The same scene with every model, light and feature compiled in (`--everything`).
    pub fn everything(mut self) -> Self {
        // More groups than slots hold are left out: no one asked for them.
        let groups = self.group_count;
        let all = if groups <= GROUP_LIMIT as u32 { Aovs::ALL } else { Aovs::ALL.without(GROUPS) };
        self.aovs = all.with_groups(groups);
        for flag in [
            &mut self.filter,
            &mut self.triangles,
            &mut self.spheres,
            &mut self.discs,
            &mut self.instances,
            &mut self.sky,
            &mut self.suns,
            &mut self.smooth_normals,
            &mut self.tangents,
            &mut self.uvs,
            &mut self.colors,
            &mut self.emission,
            &mut self.alpha,
            &mut self.normal_maps,
            &mut self.media,
            &mut self.media_stack,
            &mut self.transmission,
            &mut self.image_textures,
            &mut self.checker_textures,
            &mut self.texture_half,
            &mut self.texture_wide,
            &mut self.texture_mips,
            &mut self.texture_srgb,
            &mut self.texture_nearest,
            &mut self.texture_mirror,
            &mut self.texture_clamp,
        ] {
            *flag = true;
        }
        if self.estimator != Estimator::Bsdf {
            self.lights = (0..light::KINDS.len()).collect();
        }
        self.bsdf_macros.iter_mut().for_each(|m| m.1 = true);
        for (model, description) in bsdf::MODELS.iter().enumerate() {
            if !self.bsdfs.contains(&model) {
                // An absent model gets a pattern of constants that no material names.
                let outputs = (0..description.inputs.len() as u32).map(|row| Node::Constant { row }).collect();
                self.structures.push(Structure { role: Role::Bsdf(model), outputs });
            }
        }
        self.bsdfs = (0..bsdf::MODELS.len()).collect();
        self.lobes.extend(self.bsdfs.iter().map(|b| (*b, 0)));
        self.lobes.sort_unstable();
        self.lobes.dedup();
        // No picture is taken by a meter: only the scene's own is there.
        let own = self.cameras.clone();
        self.cameras = (0..camera::MODELS.len()).filter(|k| !camera::MODELS[*k].is_meter || own.contains(k)).collect();
        self
    }

    /// The start of a path is served by light sampling.
    pub fn receiver(&self) -> bool {
        self.next_event() && self.cameras.iter().any(|&k| camera::MODELS[k].receives)
    }

    /// A surface meter's tables are in the text.
    pub fn sensor_elements(&self) -> bool {
        self.cameras.iter().any(|&k| camera::MODELS[k].has_elements)
    }

    /// Light sampling is in the text.
    pub fn next_event(&self) -> bool {
        !self.lights.is_empty()
    }

    /// Lights of the kind with this number (`light::LIGHT_*`) are sampled.
    pub fn samples_light(&self, kind: u32) -> bool {
        self.lights.contains(&(kind as usize))
    }

    /// Some light that is sampled can also be run into on a surface.
    pub fn surface_lights(&self) -> bool {
        self.lights.iter().any(|&k| matches!(light::KINDS[k].reach, light::Reach::Surface(_)))
    }

    /// Kinds whose text a kernel needs: those sampled, and those that a ray leaving the scene sees.
    pub fn light_texts(&self) -> impl Iterator<Item = &'static light::Kind> {
        let is_needed = |k: usize| self.lights.contains(&k) || self.backgrounds().any(|b| b == k);
        (0..light::KINDS.len()).filter(move |&k| is_needed(k)).map(|k| &light::KINDS[k])
    }

    /// Kinds that a ray leaving the scene sees.
    pub fn backgrounds(&self) -> impl Iterator<Item = usize> {
        let sky = self.sky.then_some(light::LIGHT_SKY as usize);
        sky.into_iter().chain(self.suns.then_some(light::LIGHT_SUN as usize))
    }

    /// Every macro of the kernel's text, always 0 or 1.
    pub fn defines(&self) -> Vec<(&'static str, bool)> {
        let mut d = vec![
            ("AOVS", self.aovs.in_slots()),
            ("AOV_SPLIT", self.aovs.has("direct") || self.aovs.has("indirect")),
            ("LIGHT_GROUPS", self.aovs.group_count() > 0),
            ("BY_LIST", self.by_list),
            ("HAS_RECEIVER", self.receiver()),
            ("HAS_FILTER", self.filter),
            ("HAS_TRIANGLES", self.triangles),
            // Closed meshes stay closed where an edge function is exactly 0 in f32.
            ("TRIANGLE_EXACT_EDGES", true),
            ("HAS_SPHERES", self.spheres),
            ("HAS_DISCS", self.discs),
            ("HAS_INSTANCES", self.instances),
            ("HAS_SKY", self.sky),
            ("SKY_IMAGE", self.sky_image),
            ("HAS_BACKGROUND", self.backgrounds().next().is_some()),
            ("IN_KERNEL", true),
            ("NEXT_EVENT", self.next_event()),
            ("HAS_SURFACE_LIGHTS", self.surface_lights()),
            ("HAS_SIZED_LIGHTS", self.lights.iter().any(|&k| !light::KINDS[k].is_delta())),
            ("HAS_DELTA_LIGHTS", self.lights.iter().any(|&k| light::KINDS[k].is_delta())),
            ("ESTIMATOR_MIS", self.estimator == Estimator::Mis),
            ("ESTIMATOR_LIGHT", self.estimator == Estimator::Light),
            ("HAS_NORMALS", self.smooth_normals),
            ("HAS_TANGENTS", self.tangents),
            ("HAS_UVS", self.uvs),
            ("HAS_COLORS", self.colors),
            ("HAS_EMISSION", self.emission),
            ("HAS_ALPHA", self.alpha),
            ("HAS_NORMAL_MAPS", self.normal_maps),
            ("HAS_MEDIA", self.media),
            ("MEDIA_STACK", self.media_stack),
            ("HAS_TRANSMISSION", self.transmission),
            ("HAS_MIXTURES", self.mixtures),
            ("TEXTURE_HAS_HALF", self.texture_half),
            ("TEXTURE_HAS_WIDE", self.texture_wide),
            ("TEXTURE_HAS_MIPS", self.texture_mips),
            ("TEXTURE_HAS_SRGB", self.texture_srgb),
            ("TEXTURE_HAS_NEAREST", self.texture_nearest),
            ("TEXTURE_HAS_MIRROR", self.texture_mirror),
            ("TEXTURE_HAS_CLAMP", self.texture_clamp),
        ];
        d.extend(light::KINDS.iter().enumerate().map(|(k, kind)| (kind.has_macro, self.lights.contains(&k))));
        d.extend(self.bsdf_macros.iter().copied());
        d
    }
}
