//! Where chosen AOVs lie: rows of a slot behind the radiance, and sums of a film's pixel.
//!
//! A vector takes one row: the sum over the block's samples, and in w how many hit a surface. Light groups take one each. Ids take four: one word a sample. The film
//! sums a vector's channels in f64 (f32 sums lose nothing there below 2^29 of them), and one count of hits for all.

use super::{AOVS, Aovs, Mean, Source};
use crate::film::slot::BLOCK_SAMPLES;
use crate::prepare::records::NONE;
use crate::reference::path::Sample;

/// Rows of ids.
const ID_ROWS: usize = BLOCK_SAMPLES as usize / 4;

/// One AOV in the slots.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Entry {
    /// Place in `AOVS`.
    pub index: usize,
    /// Which light group; 0 for all others.
    pub part: usize,
    /// First row behind the radiance's rows.
    pub row: usize,
    /// First of its sums, or which of the id counts it is.
    pub at: usize,
    /// Channels; 0 for ids.
    pub width: usize,
}

#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Layout {
    pub entries: Vec<Entry>,
    /// Rows behind the radiance's rows.
    pub rows: usize,
    /// Sums a pixel; the last one counts hits.
    pub sums: usize,
    /// Lists of ids a pixel.
    pub ids: usize,
}

impl Layout {
    pub fn of(aovs: Aovs) -> Self {
        let mut layout = Self::default();
        for (index, aov) in aovs.iter() {
            match aov.source {
                Source::Film(_) => {}
                Source::Ids { .. } => {
                    layout.entries.push(Entry { index, part: 0, row: layout.rows, at: layout.ids, width: 0 });
                    layout.rows += ID_ROWS;
                    layout.ids += 1;
                }
                _ => {
                    let width = aov.channels.len();
                    let parts = if let Source::Groups = aov.source { aovs.group_count() as usize } else { 1 };
                    for part in 0..parts {
                        layout.entries.push(Entry { index, part, row: layout.rows, at: layout.sums, width });
                        layout.rows += 1;
                        layout.sums += width;
                    }
                }
            }
        }
        layout.sums += usize::from(layout.sums > 0);
        layout
    }

    pub fn entry(&self, index: usize) -> Option<&Entry> {
        self.part(index, 0)
    }

    /// The entry of a light group.
    pub fn part(&self, index: usize, part: usize) -> Option<&Entry> {
        self.entries.iter().find(|e| (e.index, e.part) == (index, part))
    }

    /// Bytes of a film's pixel: sums, and for each list of ids its own and room for two entries.
    pub fn bytes_a_pixel(&self) -> usize {
        self.sums * size_of::<f64>() + self.ids * (size_of::<IdCounts>() + 4 * size_of::<(u32, u32)>())
    }

    /// Adds a slot's rows (those behind the radiance) to a pixel's sums and ids.
    pub fn add(&self, rows: &[[u32; 4]], sums: &mut [f64], ids: &mut [IdCounts]) {
        let mut hits = None;
        for e in &self.entries {
            if e.width == 0 {
                rows[e.row..e.row + ID_ROWS].iter().flatten().for_each(|&id| ids[e.at].add(id));
                continue;
            }
            let row = rows[e.row].map(|w| f64::from(f32::from_bits(w)));
            (0..e.width).for_each(|c| sums[e.at + c] += row[c]);
            if matches!(AOVS[e.index].source, Source::Surface { .. }) {
                hits = hits.or(Some(row[3]));
            }
        }
        if let (Some(hits), Some(total)) = (hits, sums.last_mut()) {
            *total += hits;
        }
    }

    /// Adds the rows of a slot of one sample, number `sample` of its block, to those of the block's slot.
    pub fn join(&self, whole: &mut [[u32; 4]], part: &[[u32; 4]], sample: usize) {
        for e in &self.entries {
            if e.width == 0 {
                let at = e.row + sample / 4;
                whole[at][sample % 4] = part[at][sample % 4];
                continue;
            }
            for c in 0..4 {
                let sum = f32::from_bits(whole[e.row][c]) + f32::from_bits(part[e.row][c]);
                whole[e.row][c] = sum.to_bits();
            }
        }
    }

    /// The mean of an entry over a pixel's samples.
    pub fn mean(&self, e: &Entry, sums: &[f64], samples: f64) -> [f64; 3] {
        let hits = sums.last().copied().unwrap_or(0.0);
        let (count, missing) = match AOVS[e.index].source {
            Source::Surface { mean: Mean::OfHits { missing }, .. } => (hits, f64::from(missing)),
            Source::Surface { mean: Mean::Place, .. } => (hits, 0.0),
            _ => (samples, 0.0),
        };
        std::array::from_fn(|c| match c < e.width {
            true if count > 0.0 => sums[e.at + c] / count,
            true => missing,
            false => 0.0,
        })
    }
}

/// Which ids a pixel's samples met, and how often.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct IdCounts(Vec<(u32, u32)>);

impl IdCounts {
    pub fn from_entries(entries: Vec<(u32, u32)>) -> Self {
        Self(entries)
    }
    pub fn add(&mut self, id: u32) {
        self.add_count(id, 1);
    }
    pub fn add_count(&mut self, id: u32, count: u32) {
        match self.0.iter_mut().find(|entry| entry.0 == id) {
            Some(entry) => entry.1 += count,
            None => self.0.push((id, count)),
        }
    }
    pub fn iter(&self) -> impl Iterator<Item = (u32, u32)> + '_ {
        self.0.iter().copied()
    }
}

/// A block's AOVs on the CPU, in f64 until they become rows.
pub struct Block<'a> {
    layout: &'a Layout,
    sums: Vec<[f64; 4]>,
    ids: Vec<[u32; BLOCK_SAMPLES as usize]>,
    count: usize,
}

impl<'a> Block<'a> {
    pub fn new(layout: &'a Layout) -> Self {
        let sums = vec![[0.0; 4]; layout.entries.len()];
        Self { layout, sums, ids: vec![[NONE; BLOCK_SAMPLES as usize]; layout.ids], count: 0 }
    }

    /// Adds the block's next sample. A sample that is not finite brings no radiance, as in the picture.
    pub fn add(&mut self, sample: &Sample) {
        let hit = sample.first;
        for (e, sum) in self.layout.entries.iter().zip(&mut self.sums) {
            let (value, hits) = match AOVS[e.index].source {
                Source::Surface { value, .. } => {
                    (hit.map(|h| value(&h)).unwrap_or_default(), f64::from(u8::from(hit.is_some())))
                }
                Source::Path { value, .. } if sample.radiance.is_finite() => (value(sample), 0.0),
                Source::Groups if sample.radiance.is_finite() => (sample.groups[e.part], 0.0),
                Source::Ids { value, .. } => {
                    self.ids[e.at][self.count] = hit.map_or(NONE, |h| value(&h));
                    continue;
                }
                _ => continue,
            };
            (0..3).for_each(|c| sum[c] += value[c]);
            sum[3] += hits;
        }
        self.count += 1;
    }

    pub fn rows(&self) -> Vec<[u32; 4]> {
        let mut rows = Vec::with_capacity(self.layout.rows);
        for (e, sum) in self.layout.entries.iter().zip(&self.sums) {
            if e.width == 0 {
                rows.extend(self.ids[e.at].chunks_exact(4).map(|w| [w[0], w[1], w[2], w[3]]));
            } else {
                rows.push(sum.map(|v| (v as f32).to_bits()));
            }
        }
        rows
    }
}
