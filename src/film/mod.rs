//! The film: where blocks of samples are summed, and what is known of their error.
//!
//! Samples come in aligned blocks of 16. A device (or the CPU) delivers one slot for each (pixel, block) (`slot`); the host adds
//! each block's sum b and its square b^2 in block order with double-double accumulators (`dd`), so that the f32 result does
//! not depend on how blocks were grouped into passes, tiles or machines. b^2 of an f32 is exact in f64. Odd blocks are summed by
//! themselves too, in f64: they share no random numbers with even ones, and the difference of both means says how wrong the mean is.
//!
//! Memory a pixel: 124 bytes (`Film::BYTES_A_PIXEL`), and what the AOVs take (`aov::Layout`): 64 more for the usual ones. Tests:
//! film/tests.rs.

pub mod adaptive;
pub mod aov;
pub mod dd;
pub mod exposure;
pub mod filter;
mod join;
pub mod ledger;
#[cfg(test)]
pub(crate) mod noise;
pub mod slot;
pub mod source;
pub mod spans;
pub mod store;

use std::ops::Range;

use rayon::prelude::*;

use crate::error::Error;
use adaptive::Adaptive;
use aov::layout::{IdCounts, Layout};
use aov::{Aovs, Names};
use dd::Dd;
use ledger::{BadSample, Ledger};
use slot::{BLOCK_SAMPLES, SLOT_ROWS, SlotRecord};

/// Sums of block sums, of their squares, and of the sums of odd blocks for one pixel, per channel.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
struct PixelSums {
    sum: [Dd; 3],
    square: [Dd; 3],
    odd: [f64; 3],
}

/// A rectangle of an image's pixels; row-major, row 0 on top.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Tile {
    pub x: u32,
    pub y: u32,
    pub width: u32,
    pub height: u32,
}

impl Tile {
    /// All of an image.
    pub const fn image(width: u32, height: u32) -> Self {
        Self { x: 0, y: 0, width, height }
    }
    pub fn pixel_count(&self) -> usize {
        self.width as usize * self.height as usize
    }
    /// It has pixels, and all of them lie in an image of this size.
    pub fn is_inside(&self, width: u32, height: u32) -> bool {
        let fits = |start: u32, length: u32, limit: u32| length > 0 && start < limit && length <= limit - start;
        fits(self.x, self.width, width) && fits(self.y, self.height, height)
    }
}

/// All samples taken so far of a window of the image, summed. Pixels are numbered within the window.
#[derive(Clone, Debug)]
pub struct Film {
    window: Tile,
    first_block: u64,
    sums: Vec<PixelSums>,
    /// Blocks added, by pixel: they differ when sampling is adaptive, or a pass was stopped between tiles.
    block_count: Vec<u32>,
    aovs: Aovs,
    layout: Layout,
    /// `layout.sums` numbers and `layout.ids` lists a pixel.
    aov_sums: Vec<f64>,
    aov_ids: Vec<IdCounts>,
    names: Names,
    ledger: Ledger,
    ray_count: u64,
    /// What decides over the blocks to come, where sampling is adaptive.
    adaptive: Option<Box<Adaptive>>,
}

impl Film {
    /// Host bytes for a pixel without AOVs.
    pub const BYTES_A_PIXEL: usize = size_of::<PixelSums>() + size_of::<u32>();

    /// An empty film of a whole image, whose blocks start at `first_block` (0 unless a range of samples is rendered).
    pub fn new(width: u32, height: u32, aovs: Aovs, first_block: u64) -> Self {
        Self::over(Tile::image(width, height), aovs, first_block)
    }

    /// The same for a part of an image.
    pub fn over(window: Tile, aovs: Aovs, first_block: u64) -> Self {
        let pixel_count = window.pixel_count();
        let layout = Layout::of(aovs);
        Self {
            window,
            first_block,
            sums: vec![PixelSums::default(); pixel_count],
            block_count: vec![0; pixel_count],
            aov_sums: vec![0.0; pixel_count * layout.sums],
            aov_ids: vec![IdCounts::default(); pixel_count * layout.ids],
            aovs,
            layout,
            names: Names::default(),
            ledger: Ledger::default(),
            ray_count: 0,
            adaptive: None,
        }
    }

    /// Whether a film of this size fits into the memory that is free now; else an error with both numbers.
    pub fn check_memory(width: u32, height: u32, aovs: Aovs) -> Result<(), Error> {
        let needed = width as u64 * height as u64 * Self::bytes_a_pixel(aovs) as u64;
        match available_bytes() {
            Some(available) if needed > available => Err(Error::Usage(format!(
                "a film of {width}x{height} needs {} MiB, but {} MiB of memory are free: choose a smaller --size, or --tiled to finish it band by band",
                needed >> 20,
                available >> 20
            ))),
            _ => Ok(()),
        }
    }

    /// Where its pixels lie in the image.
    pub fn window(&self) -> Tile {
        self.window
    }
    pub fn width(&self) -> u32 {
        self.window.width
    }
    pub fn height(&self) -> u32 {
        self.window.height
    }
    pub fn pixel_count(&self) -> usize {
        self.sums.len()
    }
    pub fn aovs(&self) -> Aovs {
        self.aovs
    }
    /// Names for the numbers of the id AOVs, and where the world's origin lies.
    pub fn names(&self) -> &Names {
        &self.names
    }
    pub fn set_names(&mut self, names: Names) {
        self.names = names;
    }
    /// Host bytes for a pixel with these AOVs.
    pub fn bytes_a_pixel(aovs: Aovs) -> usize {
        Self::BYTES_A_PIXEL + Layout::of(aovs).bytes_a_pixel()
    }
    pub fn ledger(&self) -> &Ledger {
        &self.ledger
    }
    pub fn ray_count(&self) -> u64 {
        self.ray_count
    }
    /// Host memory of the accumulators, bytes.
    pub fn bytes(&self) -> usize {
        self.pixel_count() * Self::bytes_a_pixel(self.aovs) + self.adaptive.as_ref().map_or(0, |a| a.bytes())
    }
    pub fn block_count(&self, pixel: usize) -> u32 {
        self.block_count[pixel]
    }
    /// Samples of all pixels together.
    pub fn sample_count(&self) -> u64 {
        self.block_count.iter().map(|&n| n as u64).sum::<u64>() * BLOCK_SAMPLES as u64
    }
    /// Fewest blocks that any pixel has.
    pub fn min_block_count(&self) -> u32 {
        self.block_count.iter().copied().min().unwrap_or(0)
    }

    /// Adds one block of one pixel. Blocks of a pixel come in order, without gaps.
    pub fn add_block(&mut self, pixel: usize, block: u64, slot: &SlotRecord) {
        let mut events = Events::default();
        let w = self.window;
        let position = (w.x + pixel as u32 % w.width, w.y + pixel as u32 / w.width);
        let next = self.first_block + self.block_count[pixel] as u64;
        add_slot(&mut self.sums[pixel], slot, block, next, position, &mut events);
        self.block_count[pixel] += 1;
        self.take(events);
    }

    /// Adds one block's AOV rows of one pixel.
    pub fn add_aov_rows(&mut self, pixel: usize, rows: &[[u32; 4]]) {
        let (sums, ids) = (self.layout.sums, self.layout.ids);
        self.layout.add(rows, &mut self.aov_sums[pixel * sums..][..sums], &mut self.aov_ids[pixel * ids..][..ids]);
    }

    /// Adds the slots of `tile` (of the image, inside the window) for all of `blocks`: slot index = (block - blocks.start) * tile pixels + pixel in the tile, each
    /// of `slot::rows(aovs)` rows. Returns the rays counted in them.
    pub fn add_tile(&mut self, tile: Tile, blocks: Range<u64>, rows: &[[u32; 4]]) -> u64 {
        let rows_a_slot = SLOT_ROWS + self.layout.rows;
        let tile_pixels = tile.pixel_count();
        let slot_count = tile_pixels * (blocks.end - blocks.start) as usize;
        assert!(rows.len() >= slot_count * rows_a_slot, "the tile's slots are all there");
        let (left, top) = ((tile.x - self.window.x) as usize, (tile.y - self.window.y) as usize);
        // One image row a job; events are joined in row order, so that their f64 sums do not depend on threads.
        let image_rows = self.image_rows(top..top + tile.height as usize);
        let events: Vec<Events> = (image_rows.into_par_iter().enumerate())
            .map(|(row, mut sums)| {
                let mut events = Events::default();
                for column in 0..tile.width as usize {
                    let position = (tile.x + column as u32, tile.y + row as u32);
                    for (step, block) in blocks.clone().enumerate() {
                        let slot = step * tile_pixels + row * tile.width as usize + column;
                        let rows = &rows[slot * rows_a_slot..][..rows_a_slot];
                        sums.add(left + column, position, block, rows, &mut events);
                    }
                }
                events
            })
            .collect();
        self.take_all(events)
    }

    /// The accumulators of these rows of the window.
    fn image_rows(&mut self, range: Range<usize>) -> Vec<ImageRow<'_>> {
        let (width, layout, first_block) = (self.window.width as usize, &self.layout, self.first_block);
        let (begin, end) = (range.start * width, range.end * width);
        let mut aov_sums = &mut self.aov_sums[begin * layout.sums..end * layout.sums];
        let mut aov_ids = &mut self.aov_ids[begin * layout.ids..end * layout.ids];
        let sums = self.sums[begin..end].chunks_mut(width);
        let rows = sums.zip(self.block_count[begin..end].chunks_mut(width)).map(|(sums, counts)| {
            let aov_sums = aov_sums.split_off_mut(..width * layout.sums).expect("every row was counted in");
            let aov_ids = aov_ids.split_off_mut(..width * layout.ids).expect("every row was counted in");
            ImageRow { sums, counts, aov_sums, aov_ids, layout, first_block }
        });
        rows.collect()
    }

    /// Joins what rows brought beside radiance; the rays in it.
    fn take_all(&mut self, events: Vec<Events>) -> u64 {
        let before = self.ray_count;
        events.into_iter().for_each(|e| self.take(e));
        self.ray_count - before
    }

    fn take(&mut self, events: Events) {
        self.ray_count += events.ray_count;
        self.ledger.join(&events.ledger);
    }

    /// Mean radiance of a pixel, W/(m2 sr); 0 without samples.
    pub fn mean(&self, pixel: usize) -> [f64; 3] {
        let samples = (self.block_count[pixel] * BLOCK_SAMPLES) as f64;
        let sum = &self.sums[pixel].sum;
        std::array::from_fn(|c| if samples > 0.0 { sum[c].value() / samples } else { 0.0 })
    }

    /// The image: the mean of every pixel, rounded to f32 once.
    pub fn mean_f32(&self) -> Vec<[f32; 3]> {
        (0..self.pixel_count()).into_par_iter().map(|i| self.mean(i).map(|v| v as f32)).collect()
    }

    /// Variance of a pixel's mean, from the spread of its block means; infinite below two blocks.
    pub fn variance_of_mean(&self, pixel: usize) -> [f64; 3] {
        let n = self.block_count[pixel] as f64;
        if n < 2.0 {
            return [f64::INFINITY; 3];
        }
        let sums = &self.sums[pixel];
        std::array::from_fn(|c| {
            // sum (b - mean b)^2 = sum b^2 - (sum b)^2 / n, in double-double: in f64 the difference may cancel to nothing.
            let spread = sums.square[c].minus(sums.sum[c].times(sums.sum[c]).over(n)).value().max(0.0);
            spread / (n * (n - 1.0)) / (BLOCK_SAMPLES as f64 * BLOCK_SAMPLES as f64)
        })
    }

    /// Variance of a pixel's mean, from the difference between the means of its even and of its odd blocks: without bias if there are as many
    /// of both, else by as much as its fall with n differs from 1/n. One degree of freedom. Infinite while there is one kind only.
    pub fn variance_by_halves(&self, pixel: usize) -> [f64; 3] {
        let n = u64::from(self.block_count[pixel]);
        let of_odd = ((n + self.first_block % 2) / 2) as f64;
        let of_even = n as f64 - of_odd;
        if of_odd == 0.0 || of_even == 0.0 {
            return [f64::INFINITY; 3];
        }
        let sums = &self.sums[pixel];
        std::array::from_fn(|c| {
            let even = (sums.sum[c].value() - sums.odd[c]) / of_even;
            let difference = (even - sums.odd[c] / of_odd) / f64::from(BLOCK_SAMPLES);
            difference * difference * of_even * of_odd / (n * n) as f64
        })
    }

    /// A pixel's mean of the AOV in row `index` of the table; None when the film does not keep it.
    pub fn aov_mean(&self, index: usize, pixel: usize) -> Option<[f64; 3]> {
        self.part_mean(index, 0, pixel)
    }

    /// The same of light group `part`.
    pub fn part_mean(&self, index: usize, part: usize, pixel: usize) -> Option<[f64; 3]> {
        let entry = self.layout.part(index, part).filter(|e| e.width > 0)?;
        let sums = &self.aov_sums[pixel * self.layout.sums..][..self.layout.sums];
        Some(self.layout.mean(entry, sums, f64::from(self.block_count[pixel] * BLOCK_SAMPLES)))
    }

    /// Share of a pixel's samples that hit a surface; 0 when no AOV counts them.
    pub fn hit_share(&self, pixel: usize) -> f64 {
        let samples = f64::from(self.block_count[pixel] * BLOCK_SAMPLES);
        let hits = self.aov_sums[pixel * self.layout.sums..][..self.layout.sums].last().copied();
        if samples > 0.0 { hits.unwrap_or(0.0) / samples } else { 0.0 }
    }

    /// Ids that a pixel's samples met in the AOV in row `index`, and how often each.
    pub fn ids(&self, index: usize, pixel: usize) -> impl Iterator<Item = (u32, u32)> + '_ {
        let entry = self.layout.entry(index).filter(|e| e.width == 0);
        entry.into_iter().flat_map(move |e| self.aov_ids[pixel * self.layout.ids + e.at].iter())
    }

    /// Mean over the image, per channel.
    pub fn image_mean(&self) -> [f64; 3] {
        let mut total = [0.0; 3];
        for pixel in 0..self.pixel_count() {
            let mean = self.mean(pixel);
            (0..3).for_each(|c| total[c] += mean[c]);
        }
        total.map(|t| t / self.pixel_count().max(1) as f64)
    }
}

/// What the system could hand out without swapping; None where it does not say.
fn available_bytes() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = text.lines().find_map(|l| l.strip_prefix("MemAvailable:"))?;
    Some(line.split_whitespace().next()?.parse::<u64>().ok()? * 1024)
}

/// What a row of slots adds beside radiance.
#[derive(Default)]
struct Events {
    ray_count: u64,
    ledger: Ledger,
}

/// The accumulators of one row of the window.
struct ImageRow<'a> {
    sums: &'a mut [PixelSums],
    counts: &'a mut [u32],
    aov_sums: &'a mut [f64],
    aov_ids: &'a mut [IdCounts],
    layout: &'a Layout,
    first_block: u64,
}

impl ImageRow<'_> {
    /// Adds the rows of one slot to the pixel in column `x` of the window, which lies at `position` in the image.
    fn add(&mut self, x: usize, position: (u32, u32), block: u64, rows: &[[u32; 4]], events: &mut Events) {
        let slot: &SlotRecord = bytemuck::cast_ref(array2(rows));
        let next = self.first_block + u64::from(self.counts[x]);
        add_slot(&mut self.sums[x], slot, block, next, position, events);
        let layout = self.layout;
        if layout.rows > 0 {
            let sums = &mut self.aov_sums[x * layout.sums..][..layout.sums];
            layout.add(&rows[SLOT_ROWS..], sums, &mut self.aov_ids[x * layout.ids..][..layout.ids]);
        }
        self.counts[x] += 1;
    }
}

fn add_slot(sums: &mut PixelSums, slot: &SlotRecord, block: u64, next: u64, position: (u32, u32), events: &mut Events) {
    debug_assert_eq!(block, next, "blocks of a pixel come in order, without gaps");
    for c in 0..3 {
        let b = slot.sum[c] as f64;
        // Sixteen finite samples can still overflow f32: counted like an infinite sample, never stored.
        if b.is_finite() {
            sums.sum[c].add(b);
            sums.square[c].add(b * b);
            sums.odd[c] += if block % 2 == 1 { b } else { 0.0 };
        } else {
            events.ledger.count_overflow(BadSample {
                x: position.0,
                y: position.1,
                sample: block * BLOCK_SAMPLES as u64,
            });
        }
    }
    events.ray_count += slot.rays as u64;
    events.ledger.add_slot(slot, position);
}

/// The first two rows.
fn array2(rows: &[[u32; 4]]) -> &[[u32; 4]; 2] {
    rows.first_chunk().expect("a slot has two rows at least")
}

#[cfg(test)]
mod join_tests;
#[cfg(test)]
mod tests;
