//! The loop and the error estimate on a source whose mean and variance are known.

use std::cell::Cell;
use std::ops::Range;
use std::rc::Rc;
use std::time::{Duration, Instant};

use super::*;
use crate::film::slot::SlotRecord;
use crate::film::source::{DeviceInfo, PassStats};
use crate::film::spans::Span;
use crate::metric::error::compare_values as compare;
use crate::prepare::records::NONE;

/// Time that passes only where a test says so.
struct Clock {
    start: Instant,
    elapsed: Cell<Duration>,
}

impl Default for Clock {
    fn default() -> Self {
        Self { start: Instant::now(), elapsed: Cell::default() }
    }
}

impl Clock {
    fn advance(&self, seconds: f64) {
        self.elapsed.set(self.elapsed.get() + Duration::from_secs_f64(seconds));
    }

    fn now(&self) -> Instant {
        self.start + self.elapsed.get()
    }
}

/// Every pixel has its own mean; samples are exponential (standard deviation = mean), summed in f64, stored as f32.
/// The channels move together, as they do in a path tracer.
struct Exponential {
    size: (u32, u32),
    seed: u64,
    /// What each block takes, on this clock.
    block_s: f64,
    clock: Rc<Clock>,
    /// Rare bright samples: one in 500 is 200 times as bright, on top of a tenth of the mean.
    has_spikes: bool,
    calls: Vec<Range<u64>>,
}

impl Exponential {
    fn new(size: (u32, u32), seed: u64) -> Self {
        Self { size, seed, block_s: 0.0, clock: Rc::default(), has_spikes: false, calls: Vec::new() }
    }
    fn mean(pixel: usize) -> [f64; 3] {
        [0.2 + (pixel % 7) as f64 * 0.3, 1.0, 0.05 * (1 + pixel % 3) as f64]
    }
    fn uniform(&self, pixel: usize, sample: u64) -> f64 {
        let mut h = self.seed ^ (pixel as u64).wrapping_mul(0x9e3779b97f4a7c15);
        for key in [sample, 77] {
            h = (h ^ key.wrapping_add(0x632be59bd9b4e019)).wrapping_mul(0xbf58476d1ce4e5b9);
            h = (h ^ (h >> 31)).wrapping_mul(0x94d049bb133111eb);
            h ^= h >> 29;
        }
        ((h >> 11) as f64 + 0.5) / (1u64 << 53) as f64
    }
}

impl Exponential {
    /// Its rays.
    fn add_block(&self, film: &mut Film, pixel: usize, block: u64) -> u64 {
        let mut sum = [0.0; 3];
        // Of the image, of which the film may be a band.
        let (window, at) = (film.window(), pixel as u32);
        let of_image = (window.y + at / window.width) * self.size.0 + window.x + at % window.width;
        for sample in block * 16..block * 16 + 16 {
            let u = self.uniform(of_image as usize, sample);
            let x = if self.has_spikes { 0.6 + 200.0 * f64::from(u < 0.002) } else { -u.ln() };
            (0..3).for_each(|c| sum[c] += Self::mean(of_image as usize)[c] * x);
        }
        let slot = SlotRecord { sum: sum.map(|v| v as f32), rays: 16, first_bad: NONE, ..Default::default() };
        film.add_block(pixel, block, &slot);
        16
    }
}

impl SampleSource for Exponential {
    fn resolution(&self) -> (u32, u32) {
        self.size
    }
    fn render_blocks(
        &mut self,
        blocks: Range<u64>,
        film: &mut Film,
        stop: &dyn Fn() -> bool,
    ) -> Result<PassStats, Error> {
        self.calls.push(blocks.clone());
        let mut rays = 0;
        for block in blocks {
            if stop() {
                break;
            }
            self.clock.advance(self.block_s);
            for pixel in 0..film.pixel_count() {
                rays += self.add_block(film, pixel, block);
            }
        }
        Ok(PassStats { rays, device_time_s: 0.0 })
    }
    fn render_spans(&mut self, spans: &[Span], film: &mut Film, stop: &dyn Fn() -> bool) -> Result<PassStats, Error> {
        let mut rays = 0;
        for span in spans {
            if stop() {
                break;
            }
            for block in span.first..span.first + u64::from(span.count) {
                self.clock.advance(self.block_s / film.pixel_count() as f64);
                rays += self.add_block(film, span.pixel as usize, block);
            }
        }
        Ok(PassStats { rays, device_time_s: 0.0 })
    }
    fn describe(&self) -> DeviceInfo {
        DeviceInfo { kind: "cpu".into(), name: "exponential".into(), ..Default::default() }
    }
}

fn stops(spp: Option<u64>, time_s: Option<f64>) -> Stops {
    Stops { blocks: spp.map(blocks_for), time_s, error: None, started: Instant::now() }
}

fn never() -> bool {
    false
}

#[test]
fn spp_is_exact_in_blocks_and_passes_follow_each_other() {
    let mut source = Exponential::new((3, 2), 1);
    let outcome = render(&mut source, &stops(Some(1000), None), &never, &mut |_| {}).unwrap();
    assert_eq!(outcome.stopped_by, StoppedBy::Spp);
    assert_eq!(outcome.film.sample_count(), 6 * 1008, "1000 rounds up to 63 blocks");
    assert_eq!(outcome.rays, outcome.film.ray_count());
    assert!(source.calls.windows(2).all(|w| w[0].end == w[1].start) && source.calls[0] == (0..1));
    assert_eq!(blocks_for(0), 1);
}

#[test]
fn time_is_kept_without_overrun() {
    for (block_s, time_s) in [(0.02, 0.5), (0.02, 30.0), (1.0, 30.0), (7.0, 30.0), (8.0, 30.0)] {
        let clock = Rc::new(Clock::default());
        let mut source = Exponential { block_s, clock: clock.clone(), ..Exponential::new((2, 2), 1) };
        let stops = Stops { started: clock.start, ..stops(None, Some(time_s)) };
        let film = Film::new(2, 2, source.aovs(), 0);
        let outcome = render_by(&|| clock.now(), &mut source, film, &stops, &never, &mut |_, _| Ok(())).unwrap();
        assert_eq!(outcome.stopped_by, StoppedBy::Time);
        let blocks = outcome.film.min_block_count() as f64;
        assert!((outcome.trace_s - blocks * block_s).abs() < 1e-6, "{} s for {blocks} blocks", outcome.trace_s);
        // Every block takes the same, so that the end is as near as whole blocks allow.
        let left_s = time_s - outcome.trace_s;
        assert!(left_s.abs() <= 0.5 * block_s + 1e-6, "{block_s} s a block: {left_s} of {time_s} s are left");
    }
}

/// Even where no time is left: a render without a sample is none.
#[test]
fn one_block_at_least_is_rendered_in_time() {
    let late = Stops { time_s: Some(0.0), ..stops(None, None) };
    let outcome = render(&mut Exponential::new((2, 2), 1), &late, &never, &mut |_| {}).unwrap();
    assert_eq!((outcome.stopped_by, outcome.film.min_block_count()), (StoppedBy::Time, 1));
}

#[test]
fn interrupt_keeps_what_is_there() {
    let mut source = Exponential::new((2, 1), 1);
    let polls = Cell::new(0);
    let interrupted = || {
        polls.set(polls.get() + 1);
        polls.get() > 20
    };
    let outcome = render(&mut source, &stops(Some(1 << 20), None), &interrupted, &mut |_| {}).unwrap();
    assert_eq!(outcome.stopped_by, StoppedBy::Interrupt);
    let kept = outcome.film.min_block_count();
    assert!((5..=20).contains(&kept), "{kept} blocks");
    let mut again = Exponential::new((2, 1), 1);
    let whole = render(&mut again, &stops(Some(kept as u64 * 16), None), &never, &mut |_| {}).unwrap();
    assert_eq!(whole.film.mean_f32(), outcome.film.mean_f32(), "the blocks kept are those of a shorter render");
}

#[test]
fn progress_moves_towards_the_nearest_stop() {
    let mut fractions = Vec::new();
    let mut source = Exponential::new((2, 1), 1);
    render(&mut source, &stops(Some(4096), Some(1e6)), &never, &mut |p| fractions.push(p.fraction())).unwrap();
    assert!(fractions.windows(2).all(|w| w[0] <= w[1]) && *fractions.last().unwrap() == 1.0, "{fractions:?}");
}

/// 95 % intervals on 200 seeds: how often the true relMSE of the image lies inside. Binomial(200, 0.95) is below 180 with
/// probability 0.002; an interval a little too wide is not a fault.
#[test]
fn the_interval_covers_the_true_error() {
    let size = (16, 12);
    let reference: Vec<[f32; 3]> =
        (0..size.0 * size.1).map(|i| Exponential::mean(i as usize).map(|v| v as f32)).collect();
    for spp in [64, 256] {
        let (mut covered, mut ratio) = (0, 0.0);
        for seed in 0..200 {
            let mut source = Exponential::new(size, seed * 7919 + 13);
            let outcome = render(&mut source, &stops(Some(spp), None), &never, &mut |_| {}).unwrap();
            let truth = compare(&outcome.film.mean_f32(), &reference).relmse;
            let estimate = outcome.error.unwrap();
            covered += (estimate.relmse.low <= truth && truth <= estimate.relmse.high) as i32;
            ratio += estimate.relmse.value / truth / 200.0;
            assert!(!estimate.is_heavy_tailed);
        }
        assert!(covered >= 180, "{spp} spp: {covered} of 200 covered, mean ratio {ratio:.3}");
        assert!((ratio - 1.0).abs() < 0.1, "{spp} spp: estimate over truth {ratio:.3}");
        println!("{spp} spp: {covered} of 200 intervals hold the true relMSE; estimate over truth {ratio:.3}");
    }
}

/// Rare bright samples: most pixels have met none, some one. The estimate must not take a lucky pixel's mean for the truth.
#[test]
fn spikes_do_not_hide_their_own_error() {
    let size = (64, 64);
    let reference: Vec<[f32; 3]> =
        (0..size.0 * size.1).map(|i| Exponential::mean(i as usize).map(|v| v as f32)).collect();
    for seed in 0..5 {
        let mut source = Exponential { has_spikes: true, ..Exponential::new(size, seed * 31 + 5) };
        let outcome = render(&mut source, &stops(Some(64), None), &never, &mut |_| {}).unwrap();
        let truth = compare(&outcome.film.mean_f32(), &reference).relmse;
        let estimate = outcome.error.unwrap().relmse.value;
        let ratio = estimate / truth;
        println!("estimate over truth {ratio:.3}");
        assert!((0.5..2.0).contains(&ratio), "seed {seed}: estimate {estimate:.3e}, truth {truth:.3e}");
    }
}

#[test]
fn an_error_stop_ends_where_the_estimate_says_and_the_truth_agrees() {
    for wanted in [5e-3, 1e-3] {
        let mut source = Exponential::new((24, 16), 5);
        let ask = Stops { error: Some(wanted), ..stops(Some(1 << 20), None) };
        let outcome = render(&mut source, &ask, &|| false, &mut |_| {}).unwrap();
        assert_eq!(outcome.stopped_by, StoppedBy::Error);
        let e = outcome.error.unwrap().relmse_exposure;
        assert!(
            e.high <= wanted && e.value > 0.5 * wanted,
            "{wanted}: {e:?} at {} blocks",
            outcome.film.min_block_count()
        );
        let image = outcome.film.mean_f32();
        let truth: Vec<[f32; 3]> = (0..image.len()).map(|i| Exponential::mean(i).map(|v| v as f32)).collect();
        let error = compare(&image, &truth).relmse_exposure;
        assert!(error <= 1.1 * wanted, "{wanted}: the true error is {error}");
    }
}

/// 64 pixels of which some few have met a spike after 4 blocks.
fn spiky() -> Exponential {
    Exponential { has_spikes: true, ..Exponential::new((8, 8), 36) }
}

#[test]
fn an_error_stop_waits_for_tails_that_can_be_trusted() {
    let early = render(&mut spiky(), &stops(Some(64), None), &never, &mut |_| {}).unwrap().error.unwrap();
    let wanted = 10.0 * early.relmse_exposure.high;
    assert!(early.is_heavy_tailed);
    let mut source = spiky();
    let ask = Stops { error: Some(wanted), ..stops(Some(1 << 14), None) };
    let mut waited = 0;
    let outcome = render(&mut source, &ask, &never, &mut |p| waited += u32::from(p.waits_for_tails())).unwrap();
    let blocks = outcome.film.min_block_count();
    assert_eq!(outcome.stopped_by, StoppedBy::Error, "{blocks} blocks");
    let error = outcome.error.unwrap();
    assert!(
        !error.is_heavy_tailed && error.relmse_exposure.high <= wanted && blocks > 4 && waited > 0,
        "{blocks}: {error:?}"
    );
    // Not block by block.
    let passes = source.calls.len();
    println!("{blocks} blocks in {passes} passes");
    assert!(passes <= 30, "{passes} passes for {blocks} blocks");
}

/// Bands of one film have its interval, but for the neighbours that their edges cut off, however many they are.
#[test]
fn bands_have_the_interval_and_the_tails_of_the_whole() {
    let banded = |source: &mut Exponential, rows: u32, spp: u64| {
        let (width, height) = source.size;
        let window = Tile::image(width, height);
        let stops = stops(Some(spp), None);
        bands::render_bands(source, window, rows, &stops, &never, &mut |_| {}, &mut |_| Ok(())).unwrap()
    };
    let width = |e: estimate::Estimate| (e.high / e.value).ln();
    let mut source = Exponential::new((48, 32), 5);
    let whole = render(&mut source, &stops(Some(128), None), &never, &mut |_| {}).unwrap().error.unwrap();
    for rows in [32, 8, 2, 1] {
        let totals = banded(&mut source, rows, 128);
        let joined = totals.error.unwrap();
        assert!(rows < 32 || joined == whole.relmse, "{joined:?}, whole {:?}", whole.relmse);
        let ratio = width(joined) / width(whole.relmse);
        assert!((ratio - 1.0).abs() < 0.1, "bands of {rows} rows: {joined:?}, whole {:?}", whole.relmse);
        assert!(!totals.is_heavy_tailed);
    }
    for rows in [8, 1] {
        let is_heavy = banded(&mut spiky(), rows, 64).is_heavy_tailed;
        assert!(is_heavy, "bands of {rows} rows");
    }
    assert!(!banded(&mut spiky(), 1, 1 << 14).is_heavy_tailed);
}
