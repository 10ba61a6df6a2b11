//! What the driver left out is taken again: lavapipe ends the loops of an invocation after 65535 passes, the kernel counts the samples
//! that a slot lacks for it (`LEDGER_CUT`), and an invocation for each sample has passes enough. The rows are the same to the bit.

use std::ops::Range;

use super::Renderer;
use crate::error::Error;
use crate::film::Tile;
use crate::film::slot::{self, BLOCK_SAMPLES};

/// One slot in so many may be taken again sample by sample; with more, all are.
const CUT_SHARE: usize = 64;

impl Renderer {
    /// Slots in which the driver ended loops, to be taken again; where they are many, every sample shall have its own invocation.
    pub(super) fn cut_slots(&mut self, rows: &[[u32; 4]]) -> Vec<usize> {
        let is_cut = |slot: &[[u32; 4]]| slot::LEDGER_CUT.read(&bytemuck::cast([slot[0], slot[1]])) > 0;
        let cut: Vec<usize> =
            (rows.chunks_exact(self.slot_rows).enumerate().filter(|s| is_cut(s.1))).map(|(index, _)| index).collect();
        if cut.len() * CUT_SHARE > rows.len() / self.slot_rows {
            self.takes_singles = true;
            let note = "the driver ends loops after 65535 passes, and paths here need more: each sample has its own invocation";
            self.notes.push(note.to_owned());
        }
        cut
    }

    /// The same rows as `render_tile`, from slots of single samples.
    pub(super) fn render_joined(&mut self, tile: Tile, blocks: Range<u64>) -> Result<(Vec<[u32; 4]>, f64), Error> {
        let samples = BLOCK_SAMPLES as usize;
        let (mut rows, mut time) = (Vec::new(), 0.0);
        for block in blocks {
            let first = block * BLOCK_SAMPLES as u64;
            for part in bands(tile, self.capacity() / samples) {
                let (singles, seconds) = self.render_singles(part, first..first + samples as u64)?;
                let (pixels, width) = (part.pixel_count(), self.slot_rows);
                for pixel in 0..pixels {
                    let of_pixel = |k: usize| singles[(k * pixels + pixel) * width..][..width].iter().copied();
                    rows.extend(slot::joined(&(0..samples).flat_map(of_pixel).collect::<Vec<_>>(), self.aovs));
                }
                time += seconds;
            }
        }
        self.name_objects(&mut rows);
        Ok((rows, time))
    }
}

/// Parts of a tile of at most `limit` pixels, whose pixels in order are those of the tile.
fn bands(tile: Tile, limit: usize) -> Vec<Tile> {
    let width = (limit as u32).clamp(1, tile.width);
    // A part is as wide as the tile or one row high.
    let height = if width < tile.width { 1 } else { (limit as u32 / tile.width).clamp(1, tile.height) };
    let rows = (0..tile.height).step_by(height as usize);
    let parts = rows.flat_map(|y| (0..tile.width).step_by(width as usize).map(move |x| (x, y)));
    parts
        .map(|(x, y)| Tile {
            x: tile.x + x,
            y: tile.y + y,
            width: width.min(tile.width - x),
            height: height.min(tile.height - y),
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::aov::Aovs;
    use crate::gpu::renderer::KernelOptions;
    use crate::gpu::{Choice, Device, Options};
    use crate::integrator::Settings;
    use crate::prepare::prepare;
    use crate::reference::scenes;

    #[test]
    fn bands_hold_the_tile_in_order() {
        let tile = Tile { x: 3, y: 5, width: 7, height: 4 };
        for limit in [1, 3, 7, 8, 15, 100] {
            let mut pixels = Vec::new();
            for part in bands(tile, limit) {
                assert!(part.pixel_count() <= limit);
                pixels.extend((0..part.height).flat_map(|y| (0..part.width).map(move |x| (part.x + x, part.y + y))));
            }
            let all: Vec<_> = (5..9).flat_map(|y| (3..10).map(move |x| (x, y))).collect();
            assert_eq!(pixels, all, "{limit}");
        }
    }

    #[test]
    fn slots_of_single_samples_join_to_the_same_bits() {
        let device = Device::open(&Choice::Auto, &Options::default()).unwrap();
        let settings =
            Settings { aovs: Aovs::parse("albedo,normal,depth,direct,object").unwrap(), ..Settings::default() };
        let prepared = prepare(&scenes::alpha_sheets(8), &settings).unwrap();
        let mut renderer = Renderer::new(&device, &prepared, &settings, &KernelOptions::default()).unwrap();
        let tile = Tile { x: 1, y: 2, width: 5, height: 6 };
        let whole = renderer.render_tile(tile, 1..3).unwrap().0;
        assert!(!renderer.takes_singles);
        assert_eq!(whole, renderer.render_joined(tile, 1..3).unwrap().0);
    }
}
