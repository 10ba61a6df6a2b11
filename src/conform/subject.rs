//! What the path gates examine: a device that renders a scene, as it is or with a deliberate fault.

use std::ops::Range;
use std::sync::Arc;

use crate::error::Error;
use crate::film::slot::SlotRecord;
use crate::film::source::SampleSource;
use crate::film::{Film, Tile};
use crate::gpu::Device;
use crate::gpu::renderer::{KernelOptions, KernelStats, Renderer};
use crate::integrator::Settings;
use crate::prepare::{self, Prepared};
use crate::scene::Scene;
use crate::shader::compile::Edit;

/// A deliberate fault.
#[derive(Clone, Copy, Debug)]
pub enum Fault {
    /// In the kernel's text.
    Text(Edit),
    /// In the records, after the oracle's copy was taken.
    Records(fn(&mut Prepared)),
    /// In the features: nothing is left out of any kernel.
    NothingLeftOut,
}

/// A device under test.
#[derive(Clone, Copy)]
pub struct Subject<'a> {
    pub device: &'a Device,
    pub fault: Option<Fault>,
    pub everything: bool,
}

impl<'a> Subject<'a> {
    pub fn new(device: &'a Device) -> Self {
        Self { device, fault: None, everything: false }
    }

    pub fn with_fault(device: &'a Device, fault: Fault) -> Self {
        Self { fault: Some(fault), ..Self::new(device) }
    }

    fn renderer(&self, prepared: &Prepared, settings: &Settings) -> Result<Renderer, Error> {
        let mut edits = Vec::new();
        let mut faulty = None;
        match self.fault {
            Some(Fault::Text(edit)) => edits.push(edit),
            Some(Fault::Records(change)) => change(faulty.insert(prepared.clone())),
            Some(Fault::NothingLeftOut) | None => {}
        }
        // A fault must not leave a kernel in the user's cache.
        let no_cache = self.fault.is_some();
        let everything = self.everything || matches!(self.fault, Some(Fault::NothingLeftOut));
        let options = KernelOptions { everything, no_cache, by_list: false, edits };
        Renderer::new(self.device, faulty.as_ref().unwrap_or(prepared), settings, &options)
    }

    /// Renders `block_count` blocks.
    pub fn film(&self, scene: &Scene, settings: &Settings, block_count: u64) -> Result<Film, Error> {
        Ok(self.film_and_kernel(scene, settings, block_count)?.0)
    }

    /// The same, and what is known of the kernel that rendered it.
    pub fn film_and_kernel(
        &self,
        scene: &Scene,
        settings: &Settings,
        block_count: u64,
    ) -> Result<(Film, KernelStats), Error> {
        let prepared = prepared(scene, settings)?;
        let mut renderer = self.renderer(&prepared, settings)?;
        let (width, height) = renderer.resolution();
        let mut film = Film::new(width, height, renderer.aovs(), 0);
        renderer.render_blocks(0..block_count, &mut film, &|| false)?;
        Ok((film, renderer.stats))
    }

    /// The same, a film for each block.
    pub fn films(&self, scene: &Scene, settings: &Settings, block_count: u64) -> Result<Vec<Film>, Error> {
        let mut renderer = self.renderer(&prepared(scene, settings)?, settings)?;
        let (width, height) = renderer.resolution();
        let block = |k: u64| {
            let mut film = Film::new(width, height, renderer.aovs(), k);
            renderer.render_blocks(k..k + 1, &mut film, &|| false).map(|_| film)
        };
        (0..block_count).map(block).collect()
    }

    /// Slots of single samples, sample by sample and in each pixel by pixel; and the sound records they were made from.
    pub fn samples(
        &self,
        scene: &Scene,
        settings: &Settings,
        samples: Range<u64>,
    ) -> Result<(Vec<SlotRecord>, Arc<Prepared>), Error> {
        let prepared = Arc::new(prepared(scene, settings)?);
        let mut renderer = self.renderer(&prepared, settings)?;
        let (width, height) = renderer.resolution();
        let tile = Tile { x: 0, y: 0, width, height };
        let mut slots = Vec::new();
        for sample in samples {
            let (rows, _) = renderer.render_singles(tile, sample..sample + 1)?;
            slots.extend(rows.chunks_exact(2).map(|r| bytemuck::cast::<[[u32; 4]; 2], SlotRecord>([r[0], r[1]])));
        }
        Ok((slots, prepared))
    }
}

fn prepared(scene: &Scene, settings: &Settings) -> Result<Prepared, Error> {
    prepare::prepare(scene, settings).map_err(|e| Error::Scene(format!("{}: {e}", scene.name)))
}
