//! Many renders of one scene with one kernel: nothing but the seed changes from one to the next.

use crate::error::Error;
use crate::film::Film;
use crate::film::source::{DeviceInfo, PassStats, SampleSource};
use crate::gpu::Device;
use crate::gpu::renderer::{KernelOptions, Renderer};
use crate::integrator::Settings;
use crate::prepare;
use crate::scene::Scene;

pub struct Replicates {
    renderer: Renderer,
}

impl Replicates {
    pub fn new(device: &Device, scene: &Scene, settings: &Settings) -> Result<Self, Error> {
        let prepared = prepare::prepare(scene, settings).map_err(|e| Error::Scene(format!("{}: {e}", scene.name)))?;
        Ok(Self { renderer: Renderer::new(device, &prepared, settings, &KernelOptions::default())? })
    }

    /// `blocks` blocks of `seed`, and what they took.
    pub fn film(&mut self, seed: u32, blocks: u64) -> Result<(Film, PassStats), Error> {
        let mut film = self.empty();
        self.renderer.set_seed(seed);
        let stats = self.renderer.render_blocks(0..blocks, &mut film, &|| false)?;
        Ok((film, stats))
    }

    /// One film of `seed`, seen after each of `levels` (ascending numbers of blocks).
    pub fn levels(&mut self, seed: u32, levels: &[u64], see: &mut dyn FnMut(usize, &Film)) -> Result<(), Error> {
        let mut film = self.empty();
        self.renderer.set_seed(seed);
        let mut done = 0;
        for (index, &blocks) in levels.iter().enumerate() {
            self.renderer.render_blocks(done..blocks, &mut film, &|| false)?;
            done = blocks;
            see(index, &film);
        }
        Ok(())
    }

    pub fn describe(&self) -> DeviceInfo {
        self.renderer.describe()
    }

    fn empty(&self) -> Film {
        let (width, height) = self.renderer.resolution();
        Film::new(width, height, self.renderer.aovs(), 0)
    }
}

/// The default ones, to the scene's own depth.
pub fn settings(scene: &Scene) -> Settings {
    let default = Settings::default();
    Settings { max_depth: scene.film.max_depth.unwrap_or(default.max_depth), ..default }
}

/// The scene `height` pixels high, as wide as its shape asks for.
pub fn resized(scene: &Scene, height: u32) -> Scene {
    let mut small = scene.clone();
    let shape = f64::from(scene.film.width) / f64::from(scene.film.height.max(1));
    (small.film.width, small.film.height) = ((f64::from(height) * shape).round().max(1.0) as u32, height);
    small.film.crop = None;
    small
}
