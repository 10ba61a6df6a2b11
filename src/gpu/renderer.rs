//! A prepared scene on a device: tables uploaded, the kernel compiled for its features, tiles of slots rendered and handed to the film.
//!
//! A dispatch covers a tile of pixels and a range of blocks, sized to a time budget by the rate measured so far, so that a stop is
//! seen soon and no dispatch runs into a driver's time limit.

mod list;
mod retake;

use std::borrow::Cow;
use std::ops::Range;
use std::time::Instant;

use crate::error::Error;
use crate::film::aov::{Aovs, Layout};
use crate::film::slot::{BLOCK_SAMPLES, SLOT_ROWS};
use crate::film::source::{DeviceInfo, PassStats, SampleSource};
use crate::film::spans::Span;
use crate::film::{Film, Tile};
use crate::gpu::{Buffer, Device, Pipeline, Table};
use crate::integrator::Settings;
use crate::prepare::features::Features;
use crate::prepare::records::NONE;
use crate::prepare::{self, Prepared};
use crate::shader::assemble::{self, Push, WORKGROUP};
use crate::shader::cache::Cache;
use crate::shader::compile::{Edit, compile};

/// Seconds a dispatch should take.
const DISPATCH_S: f64 = 0.25;
/// Slots of the first dispatch, before any rate is known.
const FIRST_SLOTS: usize = 8 * 1024;
/// Bytes of the slots' buffer.
const SLOT_BYTES: usize = 32 << 20;

/// How a kernel is made.
#[derive(Clone, Debug, Default)]
pub struct KernelOptions {
    /// Every model, light and feature is compiled in.
    pub everything: bool,
    /// SPIR-V is not looked up nor kept on disk.
    pub no_cache: bool,
    /// Slots come from a list, as adaptive sampling needs it; else from tiles.
    pub by_list: bool,
    /// Changes to the text, for gates that need another kernel (one sample a slot, a deliberate fault). A kernel with edits
    /// that does not fit or does not compile is an error.
    pub edits: Vec<Edit>,
}

/// Renders one scene on one device.
pub struct Renderer {
    device: Device,
    pipeline: Pipeline,
    tables: Vec<Table>,
    slots: Buffer,
    /// Pixel and block of each slot, where the kernel takes them from a list.
    jobs: Option<Buffer>,
    width: u32,
    height: u32,
    aovs: Aovs,
    /// First row of a slot's object ids, and what the primitives belong to (`Prepared::objects`).
    objects: Option<(usize, Vec<(u32, u32)>)>,
    slot_rows: usize,
    seed: u32,
    /// Slots a second, measured; 0 before the first dispatch.
    rate: f64,
    /// The driver ends loops so often that every sample gets an invocation of its own.
    takes_singles: bool,
    pub stats: KernelStats,
    notes: Vec<String>,
}

/// What making the kernel cost.
#[derive(Clone, Debug, Default, serde::Serialize)]
pub struct KernelStats {
    pub spirv_words: usize,
    pub kernel_hash: String,
    /// SPIR-V came from the disk cache.
    pub from_cache: bool,
    /// GLSL to SPIR-V and the pipeline; a driver may compile on at the first dispatch.
    pub compile_s: f64,
    pub upload_s: f64,
    /// The first dispatch, which on lavapipe holds the JIT.
    pub first_dispatch_s: f64,
    pub table_bytes: Vec<(&'static str, u64)>,
}

impl Renderer {
    /// Uploads `prepared` and compiles its kernel. If a specialised text does not compile, everything-on is used and said.
    pub fn new(
        device: &Device,
        prepared: &Prepared,
        settings: &Settings,
        options: &KernelOptions,
    ) -> Result<Self, Error> {
        let features = Features { by_list: options.by_list, ..Features::of(prepared, settings) };
        if !options.edits.is_empty() && !options.everything {
            return Self::with_features(device, prepared, settings, features, options);
        }
        if options.everything {
            return Self::with_features(device, prepared, settings, features.everything(), options);
        }
        match Self::with_features(device, prepared, settings, features.clone(), options) {
            Err(Error::Shader(message)) => {
                let mut renderer = Self::with_features(device, prepared, settings, features.everything(), options)?;
                renderer.notes.push(format!("the specialised kernel failed ({message}); everything-on is used"));
                Ok(renderer)
            }
            other => other,
        }
    }

    fn with_features(
        device: &Device,
        prepared: &Prepared,
        settings: &Settings,
        features: Features,
        options: &KernelOptions,
    ) -> Result<Self, Error> {
        let start = Instant::now();
        // A table that everything-on names but the scene lacks is one row of zeros.
        let rows: Vec<(&'static str, Cow<'_, [[u32; 4]]>)> = features
            .tables()
            .map(|t| {
                let rows = (t.rows)(prepared);
                (t.name, if rows.is_empty() { Cow::Owned(vec![[0; 4]; 8]) } else { rows })
            })
            .collect();
        let size = |name: &str| rows.iter().find(|(n, _)| *n == name).map_or(0, |(_, r)| r.len());
        let mut program = assemble::assemble(&features, settings, prepared, device.info(), size)?;
        for edit in &options.edits {
            program.source.apply(edit).map_err(|e| Error::Shader(e.to_string()))?;
        }
        let mut tables = Vec::new();
        for ((name, rows), (_, body)) in rows.into_iter().zip(&program.tables) {
            tables.push(device.table(name, &rows, *body)?);
        }
        let upload_s = start.elapsed().as_secs_f64();

        let start = Instant::now();
        let cache = if options.no_cache { Cache::off() } else { Cache::user() };
        let spirv = compile(&program.source, &cache).map_err(|e| Error::Shader(e.to_string()))?;
        let pipeline = device.pipeline(&spirv, &program.constants)?;
        let compile_s = start.elapsed().as_secs_f64();

        let slot_rows = assemble::slot_rows(&features);
        let pixel_count = prepared.width as usize * prepared.height as usize;
        // Small images keep several blocks in a dispatch; more than 64 blocks would only cost memory.
        let slot_count = (SLOT_BYTES / (slot_rows * 16)).min(pixel_count * 64);
        let slots = device.buffer("slots", (slot_count * slot_rows * 16) as u64)?;
        let jobs = match features.by_list {
            true => Some(device.buffer("jobs", (slot_count * size_of::<list::Job>()) as u64)?),
            false => None,
        };
        let stats = KernelStats {
            spirv_words: spirv.words().len(),
            kernel_hash: spirv.key().to_owned(),
            from_cache: spirv.was_cached(),
            compile_s,
            upload_s,
            first_dispatch_s: 0.0,
            table_bytes: program.tables.iter().zip(&tables).map(|((name, _), t)| (*name, t.bytes())).collect(),
        };
        Ok(Self {
            device: device.clone(),
            pipeline,
            tables,
            slots,
            jobs,
            width: prepared.width,
            height: prepared.height,
            aovs: features.aovs,
            objects: object_rows(features.aovs).map(|row| (row, prepared.objects.clone())),
            slot_rows,
            seed: settings.seed,
            rate: 0.0,
            takes_singles: false,
            stats,
            notes: Vec::new(),
        })
    }

    /// Other random numbers from here on, with the same kernel: what `Renderer::new` with this seed would give.
    pub fn set_seed(&mut self, seed: u32) {
        self.seed = seed;
    }

    /// Renders one tile and block range, and returns its slots' rows. What the driver left out by ending loops is taken again,
    /// sample by sample; the result is the same to the bit.
    pub fn render_tile(&mut self, tile: Tile, blocks: Range<u64>) -> Result<(Vec<[u32; 4]>, f64), Error> {
        if self.takes_singles {
            return self.render_joined(tile, blocks);
        }
        let (mut rows, mut time) = self.render_slots(tile, blocks.clone(), BLOCK_SAMPLES)?;
        self.name_objects(&mut rows);
        let cut = self.cut_slots(&rows);
        if self.takes_singles {
            let (rows, again) = self.render_joined(tile, blocks)?;
            return Ok((rows, time + again));
        }
        let pixels = tile.pixel_count();
        for index in cut {
            let (x, y) = ((index % pixels) as u32 % tile.width, (index % pixels) as u32 / tile.width);
            let pixel = Tile { x: tile.x + x, y: tile.y + y, width: 1, height: 1 };
            let block = blocks.start + (index / pixels) as u64;
            let (slot, seconds) = self.render_joined(pixel, block..block + 1)?;
            rows[index * self.slot_rows..][..self.slot_rows].copy_from_slice(&slot);
            time += seconds;
        }
        Ok((rows, time))
    }

    /// One slot for each sample: sample by sample, and in each pixel by pixel.
    pub fn render_singles(&mut self, tile: Tile, samples: Range<u64>) -> Result<(Vec<[u32; 4]>, f64), Error> {
        self.render_slots(tile, samples, 1)
    }

    /// One dispatch. `blocks` are of `block_samples` samples each.
    fn render_slots(
        &mut self,
        tile: Tile,
        blocks: Range<u64>,
        block_samples: u32,
    ) -> Result<(Vec<[u32; 4]>, f64), Error> {
        if self.jobs.is_some() {
            return self.dispatch_jobs(&list::of_tile(tile, blocks, self.width), block_samples);
        }
        let push = Push {
            tile_x: tile.x,
            tile_y: tile.y,
            tile_width: tile.width,
            tile_pixels: tile.pixel_count() as u32,
            first_block: blocks.start as u32,
            block_count: (blocks.end - blocks.start) as u32,
            block_samples,
            seed: self.seed,
        };
        self.dispatch(&push)
    }

    /// Runs the kernel for all slots that `push` speaks of; their rows, and seconds.
    fn dispatch(&mut self, push: &Push) -> Result<(Vec<[u32; 4]>, f64), Error> {
        let (slot_count, block_samples) = ((push.tile_pixels * push.block_count) as usize, push.block_samples);
        let mut bindings: Vec<_> = self.tables.iter().map(Table::binding).collect();
        bindings.push(self.slots.binding());
        bindings.extend(self.jobs.iter().map(Buffer::binding));
        let groups = [(slot_count as u32).div_ceil(WORKGROUP), 1, 1];
        let time = self.device.dispatch(&self.pipeline, &bindings, bytemuck::bytes_of(push), groups)?.as_secs_f64();
        if self.stats.first_dispatch_s == 0.0 {
            self.stats.first_dispatch_s = time;
        } else if block_samples == BLOCK_SAMPLES || self.takes_singles {
            self.rate = slot_count as f64 * f64::from(block_samples) / f64::from(BLOCK_SAMPLES) / time.max(1e-6);
        }
        let rows = self.slots.read::<[u32; 4]>(0..slot_count * self.slot_rows)?;
        Ok((rows, time))
    }

    /// Slots that the next dispatch should hold.
    fn slot_budget(&self) -> usize {
        let wanted = if self.rate > 0.0 { (self.rate * DISPATCH_S) as usize } else { FIRST_SLOTS };
        wanted.clamp(WORKGROUP as usize, self.capacity())
    }

    /// The device writes primitives; the film counts objects.
    fn name_objects(&self, rows: &mut [[u32; 4]]) {
        let Some((first, objects)) = &self.objects else { return };
        for slot in rows.chunks_exact_mut(self.slot_rows) {
            for word in slot[*first..first + BLOCK_SAMPLES as usize / 4].iter_mut().flatten().filter(|w| **w != NONE) {
                *word = prepare::object_of(objects, *word);
            }
        }
    }

    /// Slots that the buffer holds.
    fn capacity(&self) -> usize {
        self.slots.bytes() as usize / (self.slot_rows * 16)
    }
}

/// First row of a slot's object ids.
fn object_rows(aovs: Aovs) -> Option<usize> {
    let (index, _) = aovs.iter().find(|(_, a)| a.name == "object")?;
    Layout::of(aovs).entry(index).map(|e| SLOT_ROWS + e.row)
}

impl SampleSource for Renderer {
    fn resolution(&self) -> (u32, u32) {
        (self.width, self.height)
    }

    fn aovs(&self) -> Aovs {
        self.aovs
    }

    fn render_blocks(
        &mut self,
        blocks: Range<u64>,
        film: &mut Film,
        stop: &dyn Fn() -> bool,
    ) -> Result<PassStats, Error> {
        let mut stats = PassStats::default();
        let mut block = blocks.start;
        let window = film.window();
        let (right, bottom) = (window.x + window.width, window.y + window.height);
        while block < blocks.end {
            let step = (self.slot_budget() / window.pixel_count()).clamp(1, (blocks.end - block) as usize) as u64;
            let mut y = window.y;
            while y < bottom {
                let budget = self.slot_budget() / step as usize;
                let height = ((budget / window.width as usize) as u32).clamp(1, bottom - y);
                let mut x = window.x;
                while x < right {
                    // A row longer than the budget is cut; else the tile is as wide as the window.
                    let width = if height > 1 { window.width } else { (budget as u32).clamp(1, right - x) };
                    let tile = Tile { x, y, width, height };
                    let (rows, time) = self.render_tile(tile, block..block + step)?;
                    stats.rays += film.add_tile(tile, block..block + step, &rows);
                    stats.device_time_s += time;
                    if stop() {
                        return Ok(stats);
                    }
                    x += width;
                }
                y += height;
            }
            block += step;
        }
        Ok(stats)
    }

    fn render_spans(&mut self, spans: &[Span], film: &mut Film, stop: &dyn Fn() -> bool) -> Result<PassStats, Error> {
        self.render_list(spans, film, stop)
    }

    fn describe(&self) -> DeviceInfo {
        let info = self.device.info();
        let kind = if info.is_software { "software" } else { "gpu" };
        DeviceInfo {
            kind: kind.to_owned(),
            family: format!("{kind} {}", info.driver),
            name: info.name.clone(),
            driver: format!("{} {}", info.driver, info.driver_version),
            kernel_hash: self.stats.kernel_hash.clone(),
            peak_bytes: self.device.peak_bytes(),
            compile_s: self.stats.compile_s,
            upload_s: self.stats.upload_s,
            notes: self.notes.clone(),
        }
    }
}
