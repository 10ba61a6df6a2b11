//! From `--device` to a sample source: a Vulkan device, or the double-precision reference on the CPU.

use steradian::film::source::SampleSource;
use steradian::gpu::{self, Choice, Selected};
use steradian::integrator::Settings;
use steradian::reference::independent::Independent;
use steradian::reference::render::Renderer;
use steradian::scene::Scene;

/// What `render` and `bench` ask of a device.
pub struct Options<'a> {
    pub device: &'a str,
}

/// Opens the device that `options` names.
pub fn open<'a>(
    scene: &'a Scene,
    settings: &Settings,
    options: &Options,
) -> anyhow::Result<Box<dyn SampleSource + 'a>> {
    match gpu::select(&Choice::from(options.device), &gpu::Options::default())? {
        Selected::Vulkan(_) => anyhow::bail!("rendering on Vulkan is not built yet: use --device cpu"),
        Selected::Cpu { .. } => Ok(Box::new(Renderer::new(Independent::new(scene), *settings))),
    }
}
