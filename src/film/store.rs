//! A film's accumulators as bytes: what memory holds, so that a film read back goes on to the same bits.
//!
//! In this order, pixel by pixel: counts of blocks (u32), sums of radiance and squares, and of odd blocks (fifteen f64), sums of AOVs (f64), and for each
//! list of ids its length (u32), then all lists' entries (two u32 each); where sampling is adaptive, its state. Little endian, as every machine that Vulkan runs on.

use std::io::{self, Read, Write};

use super::adaptive::Adaptive;
use super::aov::Aovs;
use super::aov::layout::{IdCounts, Layout};
use super::slot::BLOCK_SAMPLES;
use super::{Film, PixelSums, Tile};

const _: () = assert!(cfg!(target_endian = "little"), "films are stored as they are in memory");

/// Samples of a pixel are numbered and counted by 32 bits.
pub const MAX_BLOCKS: u64 = u32::MAX as u64 / BLOCK_SAMPLES as u64;

/// Entries of ids written at a time.
const CHUNK: usize = 4096;

/// Why a film could not be read.
#[derive(Debug)]
pub enum ReadError {
    Io(io::Error),
    /// What of its content cannot be.
    Content(&'static str),
}

impl From<io::Error> for ReadError {
    fn from(error: io::Error) -> Self {
        Self::Io(error)
    }
}

impl Film {
    /// Bytes of a stored film, without the entries of ids.
    pub fn stored_bytes(window: Tile, aovs: Aovs) -> u64 {
        let layout = Layout::of(aovs);
        let a_pixel = size_of::<u32>() + size_of::<PixelSums>() + layout.sums * size_of::<f64>() + layout.ids * 4;
        window.pixel_count() as u64 * a_pixel as u64
    }

    /// Writes everything but window, AOVs, first block, names, ledger, rays, and whether sampling is adaptive.
    pub fn store(&self, out: &mut dyn Write) -> io::Result<()> {
        out.write_all(bytemuck::cast_slice(&self.block_count))?;
        out.write_all(bytemuck::cast_slice(&self.sums))?;
        out.write_all(bytemuck::cast_slice(&self.aov_sums))?;
        let lengths: Vec<u32> = self.aov_ids.iter().map(|list| list.iter().count() as u32).collect();
        out.write_all(bytemuck::cast_slice(&lengths))?;
        let mut entries: Vec<[u32; 2]> = Vec::with_capacity(CHUNK);
        for list in &self.aov_ids {
            entries.extend(list.iter().map(|(id, count)| [id, count]));
            if entries.len() >= CHUNK {
                out.write_all(bytemuck::cast_slice(&entries))?;
                entries.clear();
            }
        }
        out.write_all(bytemuck::cast_slice(&entries))?;
        self.adaptive.as_ref().map_or(Ok(()), |adaptive| adaptive.store(out))
    }

    /// Reads what `store` wrote, `bytes` of it. Nothing is taken on trust, and no more is allocated than `bytes` justify.
    pub fn restore(
        window: Tile,
        aovs: Aovs,
        (first_block, is_adaptive): (u64, bool),
        input: &mut dyn Read,
        bytes: u64,
    ) -> Result<Self, ReadError> {
        let fixed = Self::stored_bytes(window, aovs);
        if fixed > bytes {
            return Err(ReadError::Content("its size in pixels is more than its bytes can hold"));
        }
        let mut film = Self::over(window, aovs, first_block);
        input.read_exact(bytemuck::cast_slice_mut(&mut film.block_count))?;
        input.read_exact(bytemuck::cast_slice_mut(&mut film.sums))?;
        input.read_exact(bytemuck::cast_slice_mut(&mut film.aov_sums))?;
        if film.block_count.iter().any(|&n| u64::from(n) > MAX_BLOCKS.saturating_sub(first_block)) {
            return Err(ReadError::Content("a pixel has samples beyond 2^32"));
        }
        let numbers: &[f64] = bytemuck::cast_slice(&film.sums);
        if !numbers.iter().all(|v| v.is_finite()) {
            return Err(ReadError::Content("a pixel's sum is not finite"));
        }
        let mut lengths = vec![0u32; film.aov_ids.len()];
        input.read_exact(bytemuck::cast_slice_mut(&mut lengths))?;
        let lists = u128::from(fixed) + lengths.iter().map(|&n| u128::from(n)).sum::<u128>() * 8;
        let rest = u128::from(bytes).checked_sub(lists).filter(|rest| is_adaptive || *rest == 0);
        let Some(rest) = rest else {
            return Err(ReadError::Content("its lists of ids are not as long as it says"));
        };
        let lists = film.layout.ids;
        for (k, &length) in lengths.iter().enumerate() {
            let mut entries = vec![[0u32; 2]; length as usize];
            input.read_exact(bytemuck::cast_slice_mut(&mut entries))?;
            let samples = u64::from(film.block_count[k / lists]) * u64::from(BLOCK_SAMPLES);
            if entries.iter().map(|e| u64::from(e[1])).sum::<u64>() != samples {
                return Err(ReadError::Content("its ids are not one for each sample"));
            }
            film.aov_ids[k] = IdCounts::from_entries(entries.into_iter().map(|[id, count]| (id, count)).collect());
        }
        if is_adaptive {
            film.adaptive = Some(Box::new(Adaptive::restore(&film, input, rest as u64)?));
        }
        Ok(film)
    }

    /// Gives a restored film what is kept apart from it.
    pub fn set_totals(&mut self, ray_count: u64, ledger: super::ledger::Ledger) {
        (self.ray_count, self.ledger) = (ray_count, ledger);
    }
}
