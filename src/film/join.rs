//! Films put together: ranges of samples that follow each other, and pixels that lack blocks where a pass was stopped.
//!
//! A film of one block added to another leaves the very bits that the block itself would have left. One of several blocks adds its
//! sums: radiance and its squares are double-double, and exact unless blocks of a pixel differ by more than 2^29; then both ways
//! differ by 2^-104 of the sum, far below the f32 of a picture. Sums of AOVs and of odd blocks are f64, and a mean may differ in the last
//! bit of its f32 with odds of about 2^-28. Tests: film/tests.rs; whole renders: tests/cli/resume.rs.

use super::{Film, Tile};

impl Film {
    /// Block that every pixel begins with.
    pub fn first_block(&self) -> u64 {
        self.first_block
    }

    /// Most blocks that any pixel has.
    pub fn max_block_count(&self) -> u32 {
        self.block_count.iter().copied().max().unwrap_or(0)
    }

    /// Adds a film of the same AOVs over some or all of these pixels; its blocks go on where those of each pixel end. Pixels
    /// without blocks in `next` stay as they are.
    pub fn add_film(&mut self, next: &Self) {
        assert_eq!(self.aovs, next.aovs, "films of one render are added");
        let (sum_count, id_count) = (self.layout.sums, self.layout.ids);
        let (left, top) = (next.window.x - self.window.x, next.window.y - self.window.y);
        for from in (0..next.pixel_count()).filter(|&p| next.block_count[p] > 0) {
            let (x, y) = (from % next.window.width as usize, from / next.window.width as usize);
            let to = (top as usize + y) * self.window.width as usize + left as usize + x;
            let end = self.first_block + u64::from(self.block_count[to]);
            debug_assert_eq!(next.first_block, end, "blocks of a pixel come in order, without gaps");
            for c in 0..3 {
                self.sums[to].sum[c] = self.sums[to].sum[c].plus(next.sums[from].sum[c]);
                self.sums[to].square[c] = self.sums[to].square[c].plus(next.sums[from].square[c]);
                self.sums[to].odd[c] += next.sums[from].odd[c];
            }
            for k in 0..sum_count {
                self.aov_sums[to * sum_count + k] += next.aov_sums[from * sum_count + k];
            }
            for k in 0..id_count {
                for (id, count) in next.aov_ids[from * id_count + k].iter() {
                    self.aov_ids[to * id_count + k].add_count(id, count);
                }
            }
            self.block_count[to] += next.block_count[from];
        }
        self.ray_count += next.ray_count;
        self.ledger.join(&next.ledger);
    }

    /// Rectangles of the image that hold the pixels with the fewest blocks, and no others.
    pub fn lowest(&self) -> Vec<Tile> {
        let (least, width) = (self.min_block_count(), self.window.width as usize);
        let mut tiles: Vec<Tile> = Vec::new();
        // Tiles that reach down to the row before, from this one on.
        let mut open = 0;
        for (row, counts) in self.block_count.chunks_exact(width.max(1)).enumerate() {
            let y = self.window.y + row as u32;
            let (above, begun) = (open..tiles.len(), tiles.len());
            let mut grown = Vec::new();
            let mut x = 0;
            while x < width {
                let length = counts[x..].iter().take_while(|&&n| n == least).count();
                if length > 0 {
                    let run = Tile { x: self.window.x + x as u32, y, width: length as u32, height: 1 };
                    let is_above = |t: &Tile| (t.x, t.width) == (run.x, run.width) && t.y + t.height == y;
                    match above.clone().find(|&k| is_above(&tiles[k])) {
                        Some(k) => grown.push(k),
                        None => tiles.push(run),
                    }
                }
                x += length.max(1);
            }
            grown.iter().for_each(|&k| tiles[k].height += 1);
            open = grown.iter().copied().min().unwrap_or(begun);
        }
        tiles
    }
}
