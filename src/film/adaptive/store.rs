//! The state of adaptive sampling as bytes, behind a film's: mean, floor and which statistics are noted (a bit for each power of two
//! blocks) as u64, then each pixel's count at the epoch's beginning (u32) and the statistics (two f32). Shares are made again.

use std::io::{self, Read, Write};

use super::{Adaptive, FIRST_FLOOR, Noted};
use crate::film::Film;
use crate::film::store::{MAX_BLOCKS, ReadError};

impl Adaptive {
    pub fn store(&self, out: &mut dyn Write) -> io::Result<()> {
        let is_noted = |(power, noted): (usize, &Vec<Noted>)| u64::from(!noted.is_empty()) << power;
        let which: u64 = self.noted.iter().enumerate().map(is_noted).sum();
        for number in [self.mean, u64::from(self.floor), which] {
            out.write_all(&number.to_le_bytes())?;
        }
        out.write_all(bytemuck::cast_slice(&self.base))?;
        self.noted.iter().try_for_each(|noted| out.write_all(bytemuck::cast_slice(noted)))
    }

    /// Reads what `store` wrote for this film, `bytes` of it. Nothing is taken on trust.
    pub fn restore(film: &Film, input: &mut dyn Read, bytes: u64) -> Result<Self, ReadError> {
        let mut numbers = [0u64; 3];
        if bytes < size_of_val(&numbers) as u64 {
            return Err(ReadError::Content("the state of its adaptive sampling is missing"));
        }
        input.read_exact(bytemuck::cast_slice_mut(&mut numbers))?;
        let [mean, floor, which] = numbers;
        let first = u64::from(FIRST_FLOOR);
        let powers = || (0..64).filter(move |power| which >> power & 1 == 1);
        let mut adaptive = Self::new(film.window());
        let a_pixel = 4 + 8 * u64::from(which.count_ones());
        let is_floor = |n: u64| n.is_power_of_two() && n >= first;
        let is_right = bytes == 24 + adaptive.pixel_count as u64 * a_pixel
            && mean <= MAX_BLOCKS
            && (floor == 0 && mean < first || is_floor(floor) && which & floor != 0)
            && powers().all(|power| (1 << power) >= first.max(floor) && (1 << power) <= MAX_BLOCKS);
        if !is_right {
            return Err(ReadError::Content("the state of its adaptive sampling cannot be"));
        }
        (adaptive.mean, adaptive.floor) = (mean, floor as u32);
        input.read_exact(bytemuck::cast_slice_mut(&mut adaptive.base))?;
        for power in powers() {
            let mut noted = vec![Noted::default(); adaptive.pixel_count];
            input.read_exact(bytemuck::cast_slice_mut(&mut noted))?;
            adaptive.noted[power as usize] = noted;
        }
        // What pixels have passed was noted, and they have what they had at the epoch's beginning.
        let counts = || (0..adaptive.pixel_count).map(|pixel| u64::from(film.block_count(pixel)));
        let (least, most) = (counts().min().unwrap_or(0), counts().max().unwrap_or(0));
        let passed = (0..64).filter(|&power| is_floor(1 << power) && (1 << power) >= floor && (1 << power) <= most);
        let is_ahead = |(pixel, &base): (usize, &u32)| base > film.block_count(pixel);
        let is_begun = !adaptive.base.iter().enumerate().any(is_ahead);
        if !is_begun || least < floor || passed.into_iter().any(|power| which >> power & 1 == 0) {
            return Err(ReadError::Content("its samples are not where its adaptive sampling puts them"));
        }
        if floor > 0 {
            adaptive.share();
        }
        Ok(adaptive)
    }
}
