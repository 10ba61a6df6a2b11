//! From `--device` to a sample source: a Vulkan device, or the double-precision reference on the CPU.

use std::sync::Arc;
use std::time::Instant;

use steradian::film::source::SampleSource;
use steradian::gpu::renderer::{KernelOptions, Renderer};
use steradian::gpu::{self, Choice, Device, Selected};
use steradian::integrator::Settings;
use steradian::output::part;
use steradian::prepare::{self, Prepared};
use steradian::reference;
use steradian::reference::replay::Replay;
use steradian::scene::Scene;

/// What a command asks of a device.
#[derive(Default)]
pub struct Options<'a> {
    pub device: &'a str,
    pub kernel: KernelOptions,
    /// The scene's fingerprint is wanted: it reads all tables once.
    pub fingerprint: bool,
}

/// How the kernel is made, as flags.
#[derive(clap::Args)]
pub struct KernelArgs {
    /// Compiles every model, light and feature into the kernel, needed or not
    #[arg(long)]
    everything: bool,
    /// Neither reads nor writes the cache of compiled kernels
    #[arg(long)]
    no_cache: bool,
}

impl KernelArgs {
    pub fn everything(&self) -> bool {
        self.everything
    }

    pub fn options(&self) -> KernelOptions {
        KernelOptions { everything: self.everything, no_cache: self.no_cache, ..KernelOptions::default() }
    }
}

/// A source, and what was learned on the way to it.
pub struct Opened<'a> {
    pub source: Box<dyn SampleSource + 'a>,
    pub notes: Vec<String>,
    pub bvh_s: f64,
    /// Scene to records, without the BVH.
    pub prepare_s: f64,
    /// Where the origin of the records lies in the world.
    pub origin: glam::DVec3,
    /// Empty unless it was asked for.
    pub fingerprint: String,
}

/// Opens the device that `options` names and prepares `scene` for it.
pub fn open<'a>(scene: &'a Scene, settings: &Settings, options: &Options) -> anyhow::Result<Opened<'a>> {
    let selected = gpu::select(&Choice::from(options.device), &gpu::Options::default())?;
    let begun = Instant::now();
    let prepared = prepare::prepare(scene, settings)?;
    let prepare_s = begun.elapsed().as_secs_f64() - prepared.bvh_s;
    let origin = prepared.origin;
    let fingerprint = if options.fingerprint { part::fingerprint(&prepared) } else { String::new() };
    let (mut notes, bvh_s) = (prepared.notes.clone(), prepared.bvh_s);
    let source: Box<dyn SampleSource + 'a> = match selected {
        Selected::Vulkan(device) => Box::new(on_device(&device, &prepared, settings, &options.kernel)?),
        Selected::Cpu { reason } => {
            notes.extend(reason);
            if options.kernel.everything || options.kernel.no_cache {
                notes.push("the CPU reference has no kernel: --everything and --no-cache have no effect on it".into());
            }
            if prepared.placed_triangle_count() > u64::from(u32::MAX) {
                anyhow::bail!(
                    "the CPU reference numbers up to 2^32 triangles, and the scene places {}; use a Vulkan device",
                    prepared.placed_triangle_count()
                );
            }
            let world = Replay::new(Arc::new(prepared), settings);
            Box::new(reference::render::Renderer::new(world, *settings))
        }
    };
    Ok(Opened { source, notes, bvh_s, prepare_s, origin, fingerprint })
}

fn on_device(
    device: &Device,
    prepared: &Prepared,
    settings: &Settings,
    kernel: &KernelOptions,
) -> anyhow::Result<Renderer> {
    Ok(Renderer::new(device, prepared, settings, kernel)?)
}
