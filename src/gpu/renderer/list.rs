//! Slots from a list: what adaptive sampling renders. The kernel reads each slot's pixel and block from a buffer (`BY_LIST` in
//! shaders/kernel/render.glsl); all else is as with tiles, and a tile is a list too.

use std::ops::Range;

use super::{Push, Renderer};
use crate::error::Error;
use crate::film::slot::{self, BLOCK_SAMPLES};
use crate::film::source::PassStats;
use crate::film::spans::{Parts, Span};
use crate::film::{Film, Tile};

/// What one slot is for; `uvec2 jobs.rows[slot]` in the kernel.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Job {
    /// y * width + x in the whole image.
    pub pixel: u32,
    /// In blocks of as many samples as the dispatch says.
    pub block: u32,
}

/// The slots of a tile in the order of tiles.
pub fn of_tile(tile: Tile, blocks: Range<u64>, width: u32) -> Vec<Job> {
    let pixels = (tile.y..tile.y + tile.height).flat_map(|y| (tile.x..tile.x + tile.width).map(move |x| y * width + x));
    blocks.flat_map(|block| pixels.clone().map(move |pixel| Job { pixel, block: block as u32 })).collect()
}

impl Renderer {
    /// Renders the spans and adds them to the film, a time budget's worth at once.
    pub(super) fn render_list(
        &mut self,
        spans: &[Span],
        film: &mut Film,
        stop: &dyn Fn() -> bool,
    ) -> Result<PassStats, Error> {
        if self.jobs.is_none() {
            return Err(Error::Usage("this kernel was made for tiles and renders no list".to_owned()));
        }
        let (window, width) = (film.window(), self.width);
        let job = |s: &Span| {
            let (x, y) = (window.x + s.pixel % window.width, window.y + s.pixel / window.width);
            (s.first..s.first + u64::from(s.count)).map(move |b| Job { pixel: y * width + x, block: b as u32 })
        };
        let mut stats = PassStats::default();
        let mut parts = Parts::of(spans);
        while let Some(part) = parts.next(self.slot_budget()) {
            let jobs: Vec<Job> = part.iter().flat_map(job).collect();
            let (rows, time) = self.render_jobs(&jobs)?;
            stats += PassStats { rays: film.add_spans(&part, &rows), device_time_s: time };
            if stop() {
                break;
            }
        }
        Ok(stats)
    }

    /// The slots' rows, in the order of the jobs; what the driver cut is taken again (`render_tile`).
    fn render_jobs(&mut self, jobs: &[Job]) -> Result<(Vec<[u32; 4]>, f64), Error> {
        if self.takes_singles {
            return self.render_jobs_joined(jobs);
        }
        let (mut rows, mut time) = self.dispatch_jobs(jobs, BLOCK_SAMPLES)?;
        self.name_objects(&mut rows);
        let cut = self.cut_slots(&rows);
        let again: Vec<Job> = cut.iter().map(|&slot| jobs[slot]).collect();
        let (whole, seconds) = self.render_jobs_joined(if self.takes_singles { jobs } else { &again })?;
        time += seconds;
        if self.takes_singles {
            return Ok((whole, time));
        }
        for (&index, slot) in cut.iter().zip(whole.chunks_exact(self.slot_rows)) {
            rows[index * self.slot_rows..][..self.slot_rows].copy_from_slice(slot);
        }
        Ok((rows, time))
    }

    /// The same rows from slots of single samples.
    fn render_jobs_joined(&mut self, jobs: &[Job]) -> Result<(Vec<[u32; 4]>, f64), Error> {
        let samples = BLOCK_SAMPLES as usize;
        let (mut rows, mut time) = (Vec::new(), 0.0);
        for part in jobs.chunks((self.capacity() / samples).max(1)) {
            let of_job = |j: &Job| {
                let (pixel, first) = (j.pixel, j.block * BLOCK_SAMPLES);
                (first..first + BLOCK_SAMPLES).map(move |block| Job { pixel, block })
            };
            let singles: Vec<Job> = part.iter().flat_map(of_job).collect();
            let (single_rows, seconds) = self.dispatch_jobs(&singles, 1)?;
            let blocks = single_rows.chunks_exact(samples * self.slot_rows);
            rows.extend(blocks.flat_map(|block| slot::joined(block, self.aovs)));
            time += seconds;
        }
        self.name_objects(&mut rows);
        Ok((rows, time))
    }

    /// One dispatch of at most as many jobs as there is room for slots.
    pub(super) fn dispatch_jobs(&mut self, jobs: &[Job], block_samples: u32) -> Result<(Vec<[u32; 4]>, f64), Error> {
        if let Some(buffer) = &self.jobs {
            buffer.write(0, jobs)?;
        }
        self.dispatch(&Push {
            tile_x: 0,
            tile_y: 0,
            tile_width: 1,
            tile_pixels: 1,
            first_block: 0,
            block_count: jobs.len() as u32,
            block_samples,
            seed: self.seed,
        })
    }
}

#[cfg(test)]
mod tests {
    use crate::film::aov::Aovs;
    use crate::film::source::SampleSource;
    use crate::film::spans::Span;
    use crate::film::{Film, Tile};
    use crate::gpu::renderer::{KernelOptions, Renderer};
    use crate::gpu::{Choice, Device, Options};
    use crate::integrator::Settings;
    use crate::prepare::prepare;
    use crate::reference::{render, replay::Replay, scenes};

    /// Counts that differ from pixel to pixel: 0 to 6.
    fn spans(pixels: u32) -> Vec<Span> {
        let all = (0..pixels).map(|pixel| Span { pixel, first: 0, count: pixel * 7 % 11 % 7 });
        all.filter(|s| s.count > 0).collect()
    }

    /// A film of uneven counts holds in each pixel what one of as many blocks everywhere holds there.
    fn check(by_list: &mut dyn SampleSource, by_tile: &mut dyn SampleSource, what: &str) {
        let window = Tile { x: 1, y: 2, width: 6, height: 5 };
        let spans = spans(30);
        let mut film = Film::over(window, by_list.aovs(), 0);
        // In two calls, the second of which goes on where the first ended.
        let first: Vec<Span> = spans.iter().map(|s| Span { count: s.count.min(2), ..*s }).collect();
        let then: Vec<Span> =
            spans.iter().filter(|s| s.count > 2).map(|s| Span { first: 2, count: s.count - 2, ..*s }).collect();
        for part in [first, then] {
            by_list.render_spans(&part, &mut film, &|| false).unwrap();
        }
        let mut whole = Film::over(window, by_tile.aovs(), 0);
        for count in 1..=6 {
            by_tile.render_blocks(count - 1..count, &mut whole, &|| false).unwrap();
            for s in spans.iter().filter(|s| u64::from(s.count) == count) {
                let pixel = s.pixel as usize;
                assert_eq!(film.block_count(pixel), s.count);
                assert_eq!(film.mean(pixel), whole.mean(pixel), "{what}, pixel {pixel}");
                assert_eq!(film.variance_of_mean(pixel), whole.variance_of_mean(pixel), "{what}, pixel {pixel}");
                for index in 0..crate::film::aov::AOVS.len() {
                    assert_eq!(film.aov_mean(index, pixel), whole.aov_mean(index, pixel), "{what}, AOV {index}");
                    assert!(film.ids(index, pixel).eq(whole.ids(index, pixel)), "{what}, AOV {index}");
                }
            }
        }
        assert_eq!(film.sample_count(), 16 * crate::film::spans::slot_count(&spans) as u64);
    }

    #[test]
    fn a_list_gives_the_bits_of_tiles() {
        let device = Device::open(&Choice::Auto, &Options::default()).unwrap();
        let aovs = Aovs::parse("albedo,normal,depth,direct,object").unwrap();
        for scene in [scenes::cornell(8), scenes::alpha_sheets(8)] {
            let settings = Settings { aovs, ..Settings::default() };
            let prepared = prepare(&scene, &settings).unwrap();
            let open = |by_list: bool| {
                let options = KernelOptions { by_list, ..KernelOptions::default() };
                Renderer::new(&device, &prepared, &settings, &options).unwrap()
            };
            let (mut list, mut tile) = (open(true), open(false));
            check(&mut list, &mut tile, &scene.name);
            // Where the driver cuts loops, samples are taken one by one.
            list.takes_singles = true;
            check(&mut list, &mut tile, &format!("{} by samples", scene.name));
            let whole = Tile { x: 1, y: 1, width: 5, height: 4 };
            list.takes_singles = false;
            assert_eq!(list.render_tile(whole, 1..3).unwrap().0, tile.render_tile(whole, 1..3).unwrap().0);
            let refused = tile.render_spans(&spans(3), &mut Film::new(8, 8, aovs, 0), &|| false).unwrap_err();
            assert!(refused.to_string().contains("tiles"), "{refused}");
        }
    }

    #[test]
    fn the_reference_renders_lists_too() {
        let scene = scenes::cornell(8);
        let settings = Settings { aovs: Aovs::usual(), ..Settings::default() };
        let prepared = std::sync::Arc::new(prepare(&scene, &settings).unwrap());
        let open = || render::Renderer::new(Replay::new(prepared.clone(), &settings), settings);
        check(&mut open(), &mut open(), "cpu");
    }
}
