//! The oracle as a renderer: fills film slots on the host's cores with rayon. With the replay world it is `--device cpu`.
//!
//! A sample is summed in f64 inside its block and rounded once to the slot's f32. NaN and infinity are counted and
//! replaced by 0, like the device's. Bands of image rows are the unit of work and of stopping.

use std::ops::Range;
use std::time::Instant;

use glam::DVec3;
use rayon::prelude::*;

use super::path::{World, trace};
use crate::error::Error;
use crate::film::aov::{self, Aovs, Layout};
use crate::film::slot::{self, BLOCK_SAMPLES, SlotRecord};
use crate::film::source::{DeviceInfo, PassStats, SampleSource};
use crate::film::spans::{Parts, Span};
use crate::film::{Film, Tile};
use crate::integrator::Settings;
use crate::prepare::records::NONE;

/// Samples a band is made of, about: a tenth of a second on two cores, so that stopping is prompt.
const BAND_SAMPLES: usize = 1 << 15;

/// A world with settings, ready to be sampled.
pub struct Renderer<W> {
    pub world: W,
    pub settings: Settings,
}

impl<W: World> Renderer<W> {
    pub fn new(world: W, settings: Settings) -> Self {
        Self { world, settings }
    }

    /// The slot of one (pixel, block), and its AOV rows.
    pub fn block(&self, pixel: [u32; 2], block: u64, layout: &Layout) -> (SlotRecord, Vec<[u32; 4]>) {
        let mut slot = SlotRecord { first_bad: NONE, ..SlotRecord::default() };
        let mut aov = aov::Block::new(layout);
        let (mut sum, mut lost) = (DVec3::ZERO, 0.0);
        for k in 0..u64::from(BLOCK_SAMPLES) {
            let index = block * u64::from(BLOCK_SAMPLES) + k;
            let sample = trace(&self.world, &self.settings, pixel, index, |_| ());
            slot.rays += sample.rays;
            slot::LEDGER_DISAGREE.add(&mut slot, sample.disagreements);
            slot::LEDGER_DEPTH.add(&mut slot, u32::from(sample.is_cut));
            slot::LEDGER_ALPHA_OVERFLOW.add(&mut slot, sample.overflows.alpha);
            slot::LEDGER_MEDIA_OVERFLOW.add(&mut slot, sample.overflows.media);
            lost += sample.lost;
            let cause = match sample.radiance {
                r if r.is_nan() => Some(slot::LEDGER_NAN),
                r if !r.is_finite() => Some(slot::LEDGER_INF),
                r if r.min_element() < 0.0 => Some(slot::LEDGER_NEGATIVE),
                _ => None,
            };
            if let Some(counter) = cause {
                counter.add(&mut slot, 1);
                slot.first_bad = slot.first_bad.min(index as u32);
            }
            // A negative sample is counted and kept: without it the mean would be biased.
            if sample.radiance.is_finite() {
                sum += sample.radiance;
            }
            aov.add(&sample);
        }
        slot.sum = sum.as_vec3().to_array();
        slot.lost_energy = lost as f32;
        (slot, aov.rows())
    }

    /// Rows of the slots of `tile`, in the film's order.
    fn tile(&self, tile: Tile, blocks: Range<u64>) -> Vec<[u32; 4]> {
        let pixels = tile.pixel_count();
        self.slots(pixels * (blocks.end - blocks.start) as usize, |i| {
            let at = i % pixels;
            let pixel = [tile.x + at as u32 % tile.width, tile.y + at as u32 / tile.width];
            (pixel, blocks.start + (i / pixels) as u64)
        })
    }

    /// Rows of `count` slots, each of the pixel and block that `place` says.
    fn slots(&self, count: usize, place: impl Fn(usize) -> ([u32; 2], u64) + Sync) -> Vec<[u32; 4]> {
        let layout = Layout::of(self.settings.aovs);
        let rows_of = |i: usize| {
            let (pixel, block) = place(i);
            let (slot, more) = self.block(pixel, block, &layout);
            let rows: [[u32; 4]; slot::SLOT_ROWS] = bytemuck::cast(slot);
            rows.into_iter().chain(more)
        };
        // Indexed, so that slots land in order whichever thread made them.
        let parts: Vec<_> = (0..count).into_par_iter().map(rows_of).collect();
        parts.into_iter().flatten().collect()
    }
}

impl<W: World> SampleSource for Renderer<W> {
    fn resolution(&self) -> (u32, u32) {
        let [width, height] = self.world.size();
        (width, height)
    }

    fn aovs(&self) -> Aovs {
        self.settings.aovs
    }

    fn render_blocks(
        &mut self,
        blocks: Range<u64>,
        film: &mut Film,
        stop: &dyn Fn() -> bool,
    ) -> Result<PassStats, Error> {
        let start = Instant::now();
        let window = film.window();
        let samples_a_row = window.width as usize * BLOCK_SAMPLES as usize;
        let mut stats = PassStats::default();
        for block in blocks {
            let rows = (BAND_SAMPLES / samples_a_row).clamp(1, window.height as usize) as u32;
            for y in (0..window.height).step_by(rows as usize) {
                if stop() {
                    stats.device_time_s = start.elapsed().as_secs_f64();
                    return Ok(stats);
                }
                let tile = Tile { y: window.y + y, height: rows.min(window.height - y), ..window };
                stats.rays += film.add_tile(tile, block..block + 1, &self.tile(tile, block..block + 1));
            }
        }
        stats.device_time_s = start.elapsed().as_secs_f64();
        Ok(stats)
    }

    fn render_spans(&mut self, spans: &[Span], film: &mut Film, stop: &dyn Fn() -> bool) -> Result<PassStats, Error> {
        let start = Instant::now();
        let window = film.window();
        let mut stats = PassStats::default();
        let mut parts = Parts::of(spans);
        while let Some(part) = parts.next(BAND_SAMPLES / BLOCK_SAMPLES as usize) {
            if stop() {
                break;
            }
            let of_span = |s: &Span| {
                let pixel = [window.x + s.pixel % window.width, window.y + s.pixel / window.width];
                (s.first..s.first + u64::from(s.count)).map(move |block| (pixel, block))
            };
            let places: Vec<([u32; 2], u64)> = part.iter().flat_map(of_span).collect();
            stats.rays += film.add_spans(&part, &self.slots(places.len(), |i| places[i]));
        }
        stats.device_time_s = start.elapsed().as_secs_f64();
        Ok(stats)
    }

    fn describe(&self) -> DeviceInfo {
        DeviceInfo {
            kind: "cpu".to_owned(),
            family: "cpu".to_owned(),
            name: format!("CPU reference, f64, {} threads", rayon::current_num_threads()),
            driver: format!("steradian {}", env!("CARGO_PKG_VERSION")),
            ..DeviceInfo::default()
        }
    }
}

/// Renders `block_count` blocks of every pixel.
pub fn film<W: World>(world: W, settings: Settings, block_count: u64) -> Film {
    let mut renderer = Renderer::new(world, settings);
    let (width, height) = renderer.resolution();
    let mut film = Film::new(width, height, settings.aovs, 0);
    renderer.render_blocks(0..block_count, &mut film, &|| false).expect("the CPU needs nothing that could be missing");
    film
}
