//! A source of made-up blocks for tests: every number follows from pixel and block. It stops between tiles of three pixels.

use std::ops::Range;

use super::aov::{AOVS, Aovs, Layout};
use super::slot::SlotRecord;
use super::source::{DeviceInfo, PassStats, SampleSource};
use super::spans::Span;
use super::{Film, Tile};
use crate::error::Error;
use crate::prepare::records::NONE;

pub struct Noise {
    pub size: (u32, u32),
    pub aovs: Aovs,
}

/// 64 bits that look random.
pub fn hash(keys: [u64; 3]) -> u64 {
    keys.into_iter().fold(0x9e37_79b9_7f4a_7c15, |h: u64, key| {
        let h = (h ^ key.wrapping_mul(0xd1b5_4a32_d192_ed03)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        h ^ (h >> 29)
    })
}

impl Noise {
    /// Over six decades, so that sums in f32 or f64 alone would depend on their grouping.
    fn value(pixel: u64, block: u64, channel: u64) -> f32 {
        let u = (hash([pixel, block, channel]) >> 40) as f32 / (1u64 << 24) as f32;
        (13.8 * u).exp() * 1e-3
    }

    fn rows(&self, tile: Tile, blocks: Range<u64>) -> Vec<[u32; 4]> {
        let mut rows = Vec::new();
        for block in blocks {
            for at in 0..tile.pixel_count() as u32 {
                let (x, y) = (tile.x + at % tile.width, tile.y + at / tile.width);
                let pixel = u64::from(y) << 32 | u64::from(x);
                let sum = [0, 1, 2].map(|c| Self::value(pixel, block, c));
                let mut slot = SlotRecord { sum, rays: 16 + x, first_bad: NONE, ..Default::default() };
                if hash([pixel, block, 9]).is_multiple_of(50) {
                    super::slot::LEDGER_NAN.add(&mut slot, 1);
                    slot.first_bad = (block * 16) as u32;
                }
                rows.extend_from_slice(bytemuck::cast_ref::<_, [[u32; 4]; 2]>(&slot));
                for e in Layout::of(self.aovs).entries {
                    let word = |k: u64| hash([pixel, block, 20 + k]) as u32;
                    match e.width {
                        0 => rows.extend((0..4).map(|r| [0, 1, 2, 3].map(|c| word(4 * r + c) % 5))),
                        // Multiples of 1/16: sums of AOVs are exact then.
                        _ if AOVS[e.index].name.is_empty() => {}
                        _ => rows.push([0, 1, 2, 3].map(|c| ((word(c) % 256) as f32 / 16.0).to_bits())),
                    }
                }
            }
        }
        rows
    }
}

impl SampleSource for Noise {
    fn resolution(&self) -> (u32, u32) {
        self.size
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
        let (window, mut stats) = (film.window(), PassStats::default());
        for y in window.y..window.y + window.height {
            for x in (0..window.width).step_by(3) {
                let tile = Tile { x: window.x + x, y, width: 3.min(window.width - x), height: 1 };
                stats.rays += film.add_tile(tile, blocks.clone(), &self.rows(tile, blocks.clone()));
                if stop() {
                    return Ok(stats);
                }
            }
        }
        Ok(stats)
    }

    fn render_spans(&mut self, _: &[Span], _: &mut Film, _: &dyn Fn() -> bool) -> Result<PassStats, Error> {
        unreachable!("no test here asks for a list")
    }

    fn describe(&self) -> DeviceInfo {
        DeviceInfo { kind: "cpu".into(), name: "noise".into(), ..Default::default() }
    }
}

/// A film of `blocks` of every pixel.
pub fn film(window: Tile, aovs: Aovs, blocks: Range<u64>) -> Film {
    let size = (window.x + window.width, window.y + window.height);
    let mut film = Film::over(window, aovs, blocks.start);
    Noise { size, aovs }.render_blocks(blocks, &mut film, &|| false).expect("noise needs nothing");
    film
}

/// Every bit of a film's accumulators.
pub fn bits(film: &Film) -> Vec<u8> {
    let mut bytes = Vec::new();
    film.store(&mut bytes).expect("memory takes it");
    bytes
}
