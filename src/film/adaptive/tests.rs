//! What adaptive sampling promises, on a source whose means are known: no bias, no pixel starved, the sum asked for, the same film
//! however it is cut into passes.

use std::cell::Cell;
use std::ops::Range;

use super::*;
use crate::film::aov::Aovs;
use crate::film::slot::{BLOCK_SAMPLES, SlotRecord};
use crate::film::source::DeviceInfo;
use crate::film::store::ReadError;
use crate::metric::stats::{Moments, normal_quantile, sidak};
use crate::prepare::records::NONE;

/// Blocks of a Pareto distribution (exponent 2.5: a variance, and no third moment) on the left, nearly constant ones on the right. The top half
/// is dark.
struct Tails {
    size: (u32, u32),
    /// By colour of the pixel.
    seeds: [u64; 2],
    /// Columns on the left that are hard.
    hard: u32,
}

impl Tails {
    fn new(size: (u32, u32), seed: u64) -> Self {
        Self { size, seeds: [seed; 2], hard: size.0 / 2 }
    }

    fn scale(&self, pixel: usize) -> f64 {
        let is_dark = (pixel as u32 / self.size.0) < self.size.1 / 2;
        if is_dark { 0.01 } else { 1.0 }
    }

    fn truth(&self, pixel: usize) -> f64 {
        let is_hard = pixel as u32 % self.size.0 < self.hard;
        self.scale(pixel) * if is_hard { 2.5 / 1.5 } else { 1.0 }
    }

    fn block(&self, pixel: usize, block: u64) -> f64 {
        let seed = self.seeds[colour_of(pixel, self.size.0 as usize)];
        let mut h = seed.wrapping_mul(0xd1b5_4a32_d192_ed03) ^ (pixel as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        for key in [block, 77] {
            h = (h ^ key.wrapping_add(0x632b_e59b_d9b4_e019)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            h = (h ^ (h >> 31)).wrapping_mul(0x94d0_49bb_1331_11eb);
            h ^= h >> 29;
        }
        let u = ((h >> 11) as f64 + 0.5) / (1u64 << 53) as f64;
        let is_hard = pixel as u32 % self.size.0 < self.hard;
        self.scale(pixel) * if is_hard { u.powf(-1.0 / 2.5) } else { 0.95 + 0.1 * u }
    }
}

impl SampleSource for Tails {
    fn resolution(&self) -> (u32, u32) {
        self.size
    }
    fn render_blocks(
        &mut self,
        blocks: Range<u64>,
        film: &mut Film,
        stop: &dyn Fn() -> bool,
    ) -> Result<PassStats, Error> {
        let count = (blocks.end - blocks.start) as u32;
        let all = (0..film.pixel_count() as u32).map(|pixel| Span { pixel, first: blocks.start, count });
        self.render_spans(&all.collect::<Vec<_>>(), film, stop)
    }
    fn render_spans(&mut self, spans: &[Span], film: &mut Film, stop: &dyn Fn() -> bool) -> Result<PassStats, Error> {
        for s in spans {
            for block in s.first..s.first + u64::from(s.count) {
                let sum = (f64::from(BLOCK_SAMPLES) * self.block(s.pixel as usize, block)) as f32;
                let slot = SlotRecord { sum: [sum; 3], rays: 16, first_bad: NONE, ..Default::default() };
                film.add_block(s.pixel as usize, block, &slot);
            }
            if stop() {
                break;
            }
        }
        Ok(PassStats { rays: 0, device_time_s: 0.0 })
    }
    fn describe(&self) -> DeviceInfo {
        DeviceInfo::default()
    }
}

fn never() -> bool {
    false
}

/// A film after passes that end at these means.
fn film(source: &mut Tails, weigh: fn(usize, &[Noted]) -> Vec<f32>, passes: &[u64]) -> Film {
    let mut film = Film::new(source.size.0, source.size.1, Aovs::NONE, 0);
    let mut adaptive = Adaptive { weigh, ..Adaptive::new(film.window()) };
    for &mean in passes {
        adaptive.advance(source, &mut film, mean, &never).unwrap();
        assert_eq!(adaptive.mean(), mean);
    }
    film
}

fn counts(film: &Film) -> Vec<u32> {
    (0..film.pixel_count()).map(|p| film.block_count(p)).collect()
}

/// The same for all: uniform sampling.
fn even(_: usize, noted: &[Noted]) -> Vec<f32> {
    vec![1.0; noted.len()]
}

/// A pixel's own variance decides over its count, as it must not.
fn naive(_: usize, noted: &[Noted]) -> Vec<f32> {
    noted.iter().map(|n| 1e-3 + n.deviation / n.mean).collect()
}

/// Over 4000 renders: how many standard errors the image's mean is off, and the worst pixel's.
fn off(weigh: fn(usize, &[Noted]) -> Vec<f32>) -> (f64, f64) {
    const RENDERS: u64 = 4000;
    let size = (8, 6);
    // Relative errors by pixel.
    let renders: Vec<Vec<f64>> = (0..RENDERS)
        .into_par_iter()
        .map(|seed| {
            let mut source = Tails::new(size, seed + 1);
            let film = film(&mut source, weigh, &[40]);
            (0..film.pixel_count()).map(|p| film.mean(p)[0] / source.truth(p) - 1.0).collect()
        })
        .collect();
    let z = |m: Moments| m.mean / m.variance_of_mean().sqrt();
    let pixels = (size.0 * size.1) as usize;
    let image = z(Moments::of(renders.iter().map(|r| r.iter().sum::<f64>() / pixels as f64)));
    let worst = (0..pixels).map(|p| z(Moments::of(renders.iter().map(|r| r[p]))).abs()).fold(0.0, f64::max);
    (image, worst)
}

/// The means of pixels with heavy tails are right, where a pixel's own variance in place of its neighbours' would fail the same test
/// by far.
#[test]
fn no_mean_is_biased() {
    // One in ten thousand for the image and for the worst of 48 pixels.
    let image_bound = normal_quantile(1.0 - 0.5e-4);
    let pixel_bound = normal_quantile(1.0 - 0.5 * sidak(1e-4, 48));
    for (name, weigh) in [("uniform", even as fn(usize, &[Noted]) -> Vec<f32>), ("adaptive", weigh)] {
        let (image, worst) = off(weigh);
        println!("{name}: the image {image:+.2} standard errors off, the worst pixel {worst:.2}");
        assert!(image.abs() < image_bound && worst < pixel_bound, "{name}: {image} {worst}");
    }
    let (image, worst) = off(naive);
    println!("by its own variance: {image:+.2} and {worst:.2}");
    assert!(image < -4.0 * image_bound && worst > 2.0 * pixel_bound, "the test has no power: {image} {worst}");
}

/// The counts of a colour are the same whatever its own samples are.
#[test]
fn a_colour_decides_over_the_other_only() {
    let counts_of = |seeds: [u64; 2]| counts(&film(&mut Tails { seeds, ..Tails::new((24, 16), 0) }, weigh, &[100]));
    let (first, second) = (counts_of([1, 2]), counts_of([3, 2]));
    let differ =
        |colour: usize| (0..first.len()).filter(|&p| colour_of(p, 24) == colour && first[p] != second[p]).count();
    assert_eq!(differ(0), 0, "white pixels of other samples, and the same black ones");
    assert!(differ(1) > 50, "{} of 192 black pixels follow the white ones", differ(1));
}

#[test]
fn the_sum_is_that_asked_for_and_nothing_is_starved() {
    let mut source = Tails::new((64, 48), 3);
    let pixels = 64 * 48;
    for mean in [1, 3, 4, 5, 6, 7, 15, 16, 17, 100, 128, 250] {
        let film = film(&mut source, weigh, &[mean]);
        let counts = counts(&film);
        let missing = (mean * pixels).wrapping_sub(film.sample_count() / u64::from(BLOCK_SAMPLES));
        assert!(missing <= 4, "{missing} blocks of {} are missing at {mean}", mean * pixels);
        let (least, most) = (*counts.iter().min().unwrap(), *counts.iter().max().unwrap());
        assert!(u64::from(least) >= mean / 2 && u64::from(most) <= 8 * mean, "{least} to {most} at {mean}");
    }
    // Dark or bright, where the error is there are the samples; what lies dark among easy pixels keeps half of the mean.
    let film = film(&mut source, weigh, &[128]);
    let mean_count = |columns: Range<usize>, rows: Range<usize>| {
        let (count, size) = (columns.len() * rows.len(), 64);
        let pixels = rows.flat_map(|y| columns.clone().map(move |x| y * size + x));
        pixels.map(|p| f64::from(film.block_count(p))).sum::<f64>() / count as f64
    };
    let (hard, easy, dark) = (mean_count(4..28, 28..48), mean_count(36..64, 28..48), mean_count(36..64, 0..20));
    assert!(hard > 2.0 * easy && dark >= 64.0, "hard {hard}, easy {easy}, dark {dark}");
}

#[test]
fn passes_make_no_difference() {
    let whole = film(&mut Tails::new((20, 15), 9), weigh, &[70]);
    for passes in [vec![1, 2, 5, 6, 16, 33, 50, 70], (1..=70).collect()] {
        let film = film(&mut Tails::new((20, 15), 9), weigh, &passes);
        assert_eq!(counts(&film), counts(&whole), "{passes:?}");
        assert_eq!(film.mean_f32(), whole.mean_f32());
    }
}

/// 3 % of the pixels want more than the most, 14 % more than the mean, and the others less than the least.
fn few_want_all(_: usize, noted: &[Noted]) -> Vec<f32> {
    let weight = |pixel: usize| match pixel * 37 % 100 {
        0..3 => 100.0,
        3..17 => 4.0,
        _ => 0.1,
    };
    (0..noted.len()).map(weight).collect()
}

/// As the mean grows no count falls, nor leaves half to eight times the mean, and wherever a render is cut it ends at the same counts:
/// also where most and least together would ask for more than a step of the mean pays.
#[test]
fn counts_never_fall() {
    const END: u64 = 80;
    let pixels = 32 * 24;
    let source = || Tails { hard: 1, ..Tails::new((32, 24), 6) };
    for (weigh, is_harsh) in [(few_want_all as fn(usize, &[Noted]) -> Vec<f32>, true), (weigh, false)] {
        let mut film = Film::new(32, 24, Aovs::NONE, 0);
        let mut adaptive = Adaptive { weigh, ..Adaptive::new(film.window()) };
        let mut last = vec![0; pixels];
        for mean in 1..=END {
            let next = adaptive.counts(mean);
            assert!(next.iter().zip(&last).all(|(next, last)| next >= last), "counts fall at {mean}");
            let sum: u64 = next.iter().map(|&n| u64::from(n)).sum();
            let wanted = mean * pixels as u64;
            assert!(sum <= wanted && sum + 4 >= wanted, "{sum} for {wanted} at {mean}");
            let is_within = |&n: &u32| u64::from(n) >= mean / 2 && u64::from(n) <= 8 * mean;
            assert!(next.iter().all(is_within), "{:?} at {mean}", next.iter().max());
            adaptive.advance(&mut source(), &mut film, mean, &never).unwrap();
            assert_eq!(counts(&film), next, "{mean}");
            last = next;
        }
        if is_harsh {
            let of = |is: &dyn Fn(f32) -> bool| adaptive.shares.iter().filter(|&&s| is(s)).count() as f64 / 768.0;
            let (most, least) = (of(&|s| s == 8.0), of(&|s| s < 0.5));
            assert!(16.0 * most + least > 1.0, "nothing is asked of it: {most} and {least}");
        }
        for cut in 1..END {
            assert_eq!(counts(&self::film(&mut source(), weigh, &[cut, END])), last, "cut at {cut}");
        }
    }
}

/// A small region with nearly all of the error: the same samples make a smaller one.
#[test]
fn a_small_hard_region_gains() {
    let error = |weigh| {
        let runs = (0..20).into_par_iter().map(|seed| {
            let mut source = Tails { hard: 4, ..Tails::new((64, 40), seed + 100) };
            let film = film(&mut source, weigh, &[64]);
            // The bright half: the dark one is below the measure's epsilon.
            (20 * 64..film.pixel_count()).map(|p| (film.mean(p)[0] / source.truth(p) - 1.0).powi(2)).sum::<f64>()
        });
        runs.sum::<f64>()
    };
    let gain = error(even) / error(weigh);
    println!("relMSE smaller by {gain:.2}");
    assert!(gain > 3.0, "{gain}");
}

#[test]
fn an_interrupt_keeps_whole_blocks_and_images_of_any_size_work() {
    let mut source = Tails::new((9, 7), 5);
    let mut film = Film::new(9, 7, Aovs::NONE, 0);
    let polls = Cell::new(0);
    let interrupted = || {
        polls.set(polls.get() + 1);
        polls.get() > 400
    };
    Adaptive::new(film.window()).advance(&mut source, &mut film, 1000, &interrupted).unwrap();
    let total = film.sample_count() / u64::from(BLOCK_SAMPLES);
    assert!(total > 63 * 4 && total < 63 * 100, "{total} blocks");
    for size in [(1, 1), (1, 5), (2, 1), (3, 2)] {
        let film = self::film(&mut Tails::new(size, 1), weigh, &[40]);
        let pixels = u64::from(size.0 * size.1);
        assert!(film.sample_count() / 16 + 2 >= 40 * pixels, "{size:?}: {:?}", counts(&film));
    }
}

/// Black images and values at the ends of what floats hold ask for nothing in particular.
#[test]
fn weights_are_finite() {
    let noted = |mean: f32, deviation: f32| vec![Noted { mean, deviation }; 12];
    for noted in [noted(0.0, 0.0), noted(1e30, 1e30), noted(f32::INFINITY, f32::INFINITY), noted(1e-30, 1e-30)] {
        let weights = weigh(4, &noted);
        assert!(weights.iter().all(|w| w.is_finite() && *w > 0.0), "{weights:?}");
    }
}

/// Stopped after any span, stored and read again, over and over: the film that goes on is that of one run.
#[test]
fn a_stored_render_goes_on_to_the_bits_of_one_run() {
    let one = film(&mut Tails::new((12, 8), 4), weigh, &[90]);
    for every in [1, 7, 60, 500] {
        let mut source = Tails::new((12, 8), 4);
        let mut film = Film::new(12, 8, Aovs::NONE, 0);
        film.begin_adaptive();
        let mut stopped = 0;
        while film.adaptive.as_ref().unwrap().mean() < 90 {
            let polls = Cell::new(0);
            let interrupted = || {
                polls.set(polls.get() + 1);
                polls.get() > every
            };
            advance(&mut source, &mut film, 90, &interrupted).unwrap();
            film = stored(&film).unwrap();
            stopped += 1;
        }
        assert!(stopped > 1, "{every}");
        assert_eq!((counts(&film), film.mean_f32()), (counts(&one), one.mean_f32()), "stopped every {every} spans");
        assert_eq!(film.spp(), one.sample_count() / 96);
    }
}

/// A film through its bytes.
fn stored(film: &Film) -> Result<Film, ReadError> {
    let mut bytes = Vec::new();
    film.store(&mut bytes).unwrap();
    restored(film, &bytes)
}

fn restored(film: &Film, bytes: &[u8]) -> Result<Film, ReadError> {
    Film::restore(film.window(), Aovs::NONE, (0, true), &mut &bytes[..], bytes.len() as u64)
}

/// Bytes of the state that cannot be are refused; any that can give a film that goes on.
#[test]
fn a_state_is_not_taken_on_trust() {
    let mut source = Tails::new((6, 5), 8);
    let mut film = Film::new(6, 5, Aovs::NONE, 0);
    film.begin_adaptive();
    advance(&mut source, &mut film, 40, &never).unwrap();
    let mut bytes = Vec::new();
    film.store(&mut bytes).unwrap();
    let state = Film::stored_bytes(film.window(), Aovs::NONE) as usize;
    let refused = |bytes: &[u8]| match restored(&film, bytes) {
        Err(ReadError::Content(what)) => assert!(what.contains("adaptive"), "{what}"),
        other => panic!("{:?}", other.map(|film| film.spp())),
    };
    refused(&bytes[..state]);
    refused(&bytes[..bytes.len() - 8]);
    // Mean, floor, what is noted: too large, no power of two, not what the counts say.
    for (at, value) in [(0, u64::MAX), (8, 0), (8, 3), (8, 64), (8, 1 << 40), (16, 0), (16, u64::MAX), (16, 8)] {
        let mut bytes = bytes.clone();
        bytes[state + at..state + at + 8].copy_from_slice(&value.to_le_bytes());
        refused(&bytes);
    }
    for at in (state + 24..bytes.len()).step_by(3) {
        let mut bytes = bytes.clone();
        bytes[at] ^= 0xff;
        if let Ok(mut film) = restored(&film, &bytes) {
            advance(&mut source, &mut film, 70, &never).unwrap();
        }
    }
}
