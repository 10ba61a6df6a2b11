//! The kernel's text for exactly these features: parts in order, macros, table bodies, specialisation constants, push constants.
//!
//! Structure is text, numbers of the render are specialisation constants, numbers of a dispatch are push constants.

use crate::bsdf;
use crate::camera;
use crate::film::slot;
use crate::gpu::{DeviceInfo, GpuError, TableBody};
use crate::integrator::{SamplerKind, Settings};
use crate::light;
use crate::prepare::Prepared;
use crate::prepare::features::Features;
use crate::shader::compile::Source;
use crate::shader::{aovs, dispatch, tables};

/// A kernel before compilation.
#[derive(Clone, Debug)]
pub struct Program {
    /// Text and macros; generated parts have names in angle brackets.
    pub source: Source,
    /// Tables in binding order with their bodies; the slots' buffer has the binding after them, then comes the list of jobs if there is one.
    pub tables: Vec<(&'static str, TableBody)>,
    /// (constant_id, bits) of the render.
    pub constants: Vec<(u32, u32)>,
}

/// Numbers fixed for a render. The id is the place in the list.
const CONSTANTS: [&str; 7] =
    ["WIDTH", "MAX_DEPTH", "ROULETTE_EDGE", "LIGHT_COUNT", "ELEMENT_COUNT", "SUN_COUNT", "SKY_GROUP"];

/// Specialisation constants by name, in the order of their ids. Pure.
pub fn constants(settings: &Settings, prepared: &Prepared) -> [(&'static str, u32); CONSTANTS.len()] {
    let (edges, roulette_edge) = (settings.edges(), settings.first_roulette_edge());
    let (lights, elements) = (prepared.lights.len() as u32, prepared.sensor_elements.len() as u32);
    let suns = prepared.lights.iter().filter(|l| l.kind == light::LIGHT_SUN).count() as u32;
    let values = [prepared.width, edges, roulette_edge, lights, elements, suns, prepared.sky_group];
    std::array::from_fn(|id| (CONSTANTS[id], values[id]))
}

/// Invocations a workgroup; on lavapipe 8 to 256 made no difference above noise.
pub const WORKGROUP: u32 = 64;

/// What changes with each dispatch.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Push {
    /// Corner and size of the tile in pixels. Where slots come from a list, one pixel, and as many blocks as the list has.
    pub tile_x: u32,
    pub tile_y: u32,
    pub tile_width: u32,
    pub tile_pixels: u32,
    pub first_block: u32,
    pub block_count: u32,
    /// Samples an invocation takes, and of which a block here consists: 16, or 1 where a driver ends long loops.
    pub block_samples: u32,
    /// Here and not a constant: a replicate with another seed finds the driver's compilation done.
    pub seed: u32,
}

const PUSH_GLSL: &str = "\
layout(push_constant) uniform Push {
    uint tile_x;
    uint tile_y;
    uint tile_width;
    uint tile_pixels;
    uint first_block;
    uint block_count;
    uint block_samples;
    uint seed;
} push;
";

/// GLSL files of a kernel with these features, in order. Pure.
pub fn includes(f: &Features) -> Vec<String> {
    let mut list: Vec<String> =
        ["core/math", "core/exp", "core/trig", "core/random", "core/frame", "core/warp"].map(str::to_owned).to_vec();
    list.push(match f.sampler {
        SamplerKind::Sobol => "sampler/sobol".to_owned(),
        SamplerKind::Independent => "sampler/independent".to_owned(),
    });
    let mut add = |is_needed: bool, stem: &str| {
        if is_needed {
            list.push(stem.to_owned());
        }
    };
    add(f.image_textures, "texture/image");
    add(f.checker_textures, "texture/checker");
    add(true, "bvh/node");
    add(f.triangles, "bvh/triangle");
    add(f.spheres, "bvh/sphere");
    add(f.discs, "bvh/disc");
    add(true, "bvh/spawn");
    add(f.instances, "bvh/instance");
    add(f.instances, "bvh/placed");
    add(true, "bvh/space");
    add(true, "bvh/closest");
    add(f.next_event() && !f.alpha && !f.media_stack, "bvh/any");
    add(true, "bsdf/common");
    let mut seen: Vec<&str> = Vec::new();
    for shared in f.shared_bsdf_files() {
        if !seen.contains(&shared.file) {
            seen.push(shared.file);
            add(true, shared.file.trim_end_matches(".glsl"));
        }
    }
    for &b in &f.bsdfs {
        add(true, &format!("bsdf/{}", bsdf::MODELS[b].keyword));
    }
    add(f.filter, "film/filter");
    add(true, "film/position");
    list
}

/// GLSL files of the camera, which follow the lights: a surface meter reads an alias table too. Pure.
pub fn camera_includes(f: &Features) -> Vec<String> {
    let element = ["sensor_element"].into_iter().filter(|_| f.sensor_elements());
    let own = f.cameras.iter().map(|&k| camera::MODELS[k].keyword);
    ["common"].into_iter().chain(element).chain(own).map(|stem| format!("camera/{stem}")).collect()
}

/// GLSL files of the lights, which follow the surfaces and the path's state. Pure.
pub fn light_includes(f: &Features) -> Vec<String> {
    let is_needed = |stem: &&str| f.next_event() || (*stem == "alias" && f.sensor_elements());
    let shared = ["alias", "choose"].into_iter().filter(is_needed);
    let common = ["common"].into_iter().filter(|_| f.next_event() || f.emission || f.backgrounds().next().is_some());
    let mut list: Vec<String> = shared.chain(common).map(|stem| format!("light/{stem}")).collect();
    for kind in f.light_texts() {
        for stem in kind.shared.iter().map(|s| (*s).to_owned()).chain([format!("light/{}", kind.keyword)]) {
            if !list.contains(&stem) {
                list.push(stem);
            }
        }
    }
    list
}

/// The whole text. `table_rows` gives the size of each needed table, for the choice of its body.
pub fn assemble(
    f: &Features,
    settings: &Settings,
    prepared: &Prepared,
    device: &DeviceInfo,
    rows_of: impl Fn(&str) -> usize,
) -> Result<Program, GpuError> {
    let mut tables = Vec::new();
    for entry in f.tables() {
        tables.push((entry.name, TableBody::choose(device, entry.name, rows_of(entry.name))?));
    }
    let integrator = format!("integrator/{}", settings.integrator.description().keyword);
    let mut source = Source::new("render");
    for (name, is_on) in f.defines() {
        source = source.define(name, is_on);
    }
    source = source.part("<head>", head(f, &tables));
    for stem in includes(f) {
        source = file(source, &stem);
    }
    source = file(source, "integrator/surface_point");
    source = source.part("<patterns>", dispatch::patterns(f)).part("<bsdfs>", dispatch::bsdfs(f));
    source = source.part("<aov sums>", aovs::sums(f.aovs));
    let surface = ["hit_point", "surface", "state"].map(|stem| format!("integrator/{stem}"));
    for stem in surface.into_iter().chain(light_includes(f)) {
        source = file(source, &stem);
    }
    source = source.part("<lights>", dispatch::lights(f));
    for stem in camera_includes(f) {
        source = file(source, &stem);
    }
    source = source.part("<cameras>", dispatch::cameras(f));
    let stack = f.media_stack.then_some("media_stack");
    for stem in ["footprint", "visibility"].into_iter().chain(stack).chain(["media", "emission", "scatter"]) {
        source = file(source, &format!("integrator/{stem}"));
    }
    source = file(source.part("<aovs>", aovs::functions(f.aovs)), "integrator/tally");
    if f.receiver() {
        source = file(source, "integrator/receiver");
    }
    for stem in [&*integrator, "integrator/vertex", "film/slot", "kernel/render"] {
        source = file(source, stem);
    }
    Ok(Program { source, tables, constants: (0..).zip(constants(settings, prepared).map(|c| c.1)).collect() })
}

fn file(source: Source, stem: &str) -> Source {
    source.file(&format!("{stem}.glsl")).expect("every part named by the assembler is embedded, which a test checks")
}

fn head(f: &Features, tables: &[(&'static str, TableBody)]) -> String {
    let mut text = format!("layout(local_size_x = {WORKGROUP}) in;\n#define Spectrum vec3\n");
    text += &tables::shared_constants();
    text += &crate::sampler::glsl_dimensions();
    for (id, name) in CONSTANTS.iter().enumerate() {
        text += &format!("layout(constant_id = {id}) const uint {name} = 1u;\n");
    }
    text += &aovs::head(f.aovs);
    text += PUSH_GLSL;
    text += &format!("const uint BVH_STACK = {}u;\n", f.bvh_stack);
    text += &format!("const float CONE_SHARE = {:?};\n", crate::texture::CONE_SHARE);
    for ((binding, (name, body)), entry) in tables.iter().enumerate().zip(f.tables()) {
        text += &body.glsl(name, binding as u32);
        if let Some(loader) = entry.loader {
            text += &loader(name);
        }
    }
    let binding = tables.len();
    text += &format!("layout(set = 0, binding = {binding}, std430) buffer slots_block {{ uvec4 rows[]; }} slots;\n");
    if f.by_list {
        // Pixel of the image, and block, of each slot: `gpu::renderer::list::Job`.
        let binding = binding + 1;
        text += &format!(
            "layout(set = 0, binding = {binding}, std430) readonly buffer jobs_block {{ uvec2 rows[]; }} jobs;\n"
        );
    }
    text
}

/// Rows of a slot with these features.
pub fn slot_rows(f: &Features) -> usize {
    slot::rows(f.aovs)
}
