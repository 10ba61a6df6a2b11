//! Grouping does not matter; mean, variance, AOVs and ledger of known blocks.

use super::aov::AOVS;
use super::slot::{LEDGER_DISAGREE, LEDGER_NAN};
use super::*;
use crate::prepare::records::NONE;

fn slot(value: f32) -> SlotRecord {
    SlotRecord { sum: [value, value * 0.5, 1e-3 * value], rays: 40, first_bad: NONE, ..Default::default() }
}

/// A number in [0, 32) that looks random.
fn noise(pixel: usize, block: u64) -> f32 {
    let mut h = (pixel as u64).wrapping_mul(0x9e3779b97f4a7c15) ^ (block + 1).wrapping_mul(0xd1b54a32d192ed03);
    h = (h ^ (h >> 29)).wrapping_mul(0xbf58476d1ce4e5b9);
    (h >> 40) as f32 * (32.0 / (1u64 << 24) as f32)
}

/// Rows of `tile` as a device would deliver them.
fn rows(film_width: u32, tile: Tile, blocks: Range<u64>, aovs: Aovs) -> Vec<[u32; 4]> {
    let mut rows = Vec::new();
    for block in blocks {
        for y in 0..tile.height {
            for x in 0..tile.width {
                let pixel = ((tile.y + y) * film_width + tile.x + x) as usize;
                rows.extend_from_slice(bytemuck::cast_ref::<_, [[u32; 4]; 2]>(&slot(noise(pixel, block))));
                for e in Layout::of(aovs).entries {
                    // Of 16 samples 8 hit: albedo 0.25 over all, depth 3 over the hits, object 3 twice and 5 six times.
                    let row = match AOVS[e.index].name {
                        "albedo" => [[4.0f32, 4.0, 4.0, 8.0].map(f32::to_bits)].to_vec(),
                        "normal" => [[0.0f32, 16.0, 0.0, 8.0].map(f32::to_bits)].to_vec(),
                        "depth" => [[24.0f32, 0.0, 0.0, 8.0].map(f32::to_bits)].to_vec(),
                        "object" => {
                            vec![[5, NONE, NONE, 5], [3, NONE, 5, NONE], [NONE, 5, NONE, 3], [5, NONE, NONE, 5]]
                        }
                        _ => vec![[0; 4]],
                    };
                    rows.extend(row);
                }
            }
        }
    }
    rows
}

#[test]
fn result_does_not_depend_on_tiles_or_passes() {
    let (width, height) = (7, 5);
    let mut one = Film::new(width, height, Aovs::NONE, 0);
    for pixel in 0..35 {
        (0..24).for_each(|block| one.add_block(pixel, block, &slot(noise(pixel, block))));
    }
    let whole = std::iter::once(0..24).collect::<Vec<_>>();
    for passes in [whole, vec![0..1, 1..2, 2..24], vec![0..11, 11..24]] {
        for aovs in [Aovs::NONE, Aovs::usual(), Aovs::usual().with("object")] {
            let mut film = Film::new(width, height, aovs, 0);
            for blocks in passes.clone() {
                for tile in [
                    Tile { x: 0, y: 0, width: 7, height: 2 },
                    Tile { x: 0, y: 2, width: 3, height: 3 },
                    Tile { x: 3, y: 2, width: 4, height: 3 },
                ] {
                    film.add_tile(tile, blocks.clone(), &rows(width, tile, blocks.clone(), aovs));
                }
            }
            assert_eq!(film.mean_f32(), one.mean_f32());
            assert_eq!(film.ray_count(), one.ray_count());
            assert_eq!(film.sample_count(), 35 * 24 * 16);
            for pixel in 0..35 {
                assert_eq!(film.variance_of_mean(pixel), one.variance_of_mean(pixel));
            }
        }
    }
}

/// A film over a part of the image holds what the whole one holds there, and knows where its pixels are.
#[test]
fn a_window_is_a_part_of_the_image() {
    let (width, whole_tile) = (7, Tile::image(7, 5));
    let mut whole = Film::new(7, 5, Aovs::usual(), 0);
    whole.add_tile(whole_tile, 0..3, &rows(width, whole_tile, 0..3, Aovs::usual()));
    let window = Tile { x: 2, y: 1, width: 4, height: 3 };
    let mut part = Film::over(window, Aovs::usual(), 0);
    for tile in [Tile { height: 1, ..window }, Tile { y: 2, height: 2, ..window }] {
        part.add_tile(tile, 0..3, &rows(width, tile, 0..3, Aovs::usual()));
    }
    for pixel in 0..window.pixel_count() {
        let in_whole = (pixel / 4 + 1) * 7 + pixel % 4 + 2;
        assert_eq!(part.mean(pixel), whole.mean(in_whole));
        assert_eq!(part.variance_of_mean(pixel), whole.variance_of_mean(in_whole));
    }
    let mut bad = slot(1.0);
    LEDGER_NAN.add(&mut bad, 1);
    bad.first_bad = 48;
    part.add_block(5, 3, &bad);
    assert_eq!(part.ledger().bad_samples, [BadSample { x: 3, y: 2, sample: 48 }]);
    assert!(window.is_inside(7, 5) && !window.is_inside(5, 5) && !Tile::default().is_inside(7, 5));
    assert!(!Tile { x: u32::MAX, width: 2, ..window }.is_inside(7, 5));
}

/// N17: a constant pixel of 0.1 over a million samples; f32 sums of blocks, double-double on the host. What is left is the rounding
/// of a block's sum on the device, 2^-24 at most.
#[test]
fn a_million_samples_of_a_constant_do_not_drift() {
    let mut film = Film::new(1, 1, Aovs::NONE, 0);
    let block: f32 = (0..BLOCK_SAMPLES).fold(0.0, |sum, _| sum + 0.1f32);
    for k in 0..62_500 {
        film.add_block(0, k, &SlotRecord { sum: [block; 3], first_bad: NONE, ..Default::default() });
    }
    assert_eq!(film.mean(0)[0], f64::from(block) / 16.0, "the host adds exactly");
    assert!((film.mean(0)[0] / f64::from(0.1f32) - 1.0).abs() < 1e-6, "{}", film.mean(0)[0]);
    assert_eq!(film.variance_of_mean(0), [0.0; 3]);
}

/// N18: a bright pixel, 1e4 +- 1e-2 a sample. E[x^2] - E[x]^2 loses all digits of such a variance in f32, and most in f64.
#[test]
fn the_variance_of_a_bright_constant_is_right() {
    let mut film = Film::new(1, 1, Aovs::NONE, 0);
    // A block's sum of 1.6e5 has a spacing of 1/64 in f32; sums of +-0.16 about it are +-10 steps.
    let step = 10.0 / 64.0;
    let blocks = 4096u64;
    for k in 0..blocks {
        let sum = 1.6e5 + if noise(0, k) < 16.0 { -step } else { step };
        film.add_block(0, k, &SlotRecord { sum: [sum; 3], first_bad: NONE, ..Default::default() });
    }
    let values = (0..blocks).map(|k| if noise(0, k) < 16.0 { -f64::from(step) } else { f64::from(step) } / 16.0);
    let wanted = crate::metric::stats::Moments::of(values).variance_of_mean();
    let variance = film.variance_of_mean(0)[0];
    assert!(variance > 0.0 && (variance / wanted - 1.0).abs() < 1e-10, "{variance:e} {wanted:e}");
}

#[test]
fn variance_is_that_of_block_means() {
    let mut film = Film::new(1, 1, Aovs::NONE, 3);
    let means: Vec<f64> = (3..12).map(|block| noise(0, block) as f64 / 16.0).collect();
    (3..12).for_each(|block| film.add_block(0, block, &slot(noise(0, block))));
    let moments = crate::metric::stats::Moments::of(means.iter().copied());
    assert!((film.mean(0)[0] - moments.mean).abs() < 1e-12);
    assert!((film.variance_of_mean(0)[0] / moments.variance_of_mean() - 1.0).abs() < 1e-10);
}

/// From an even and from an odd first block, with as many of both kinds and with one more of one.
#[test]
fn variance_by_halves_is_that_of_two_sequences() {
    for (first, count) in [(0, 8), (0, 9), (3, 8), (3, 9), (3, 2)] {
        let mut film = Film::new(1, 1, Aovs::NONE, first);
        let mut halves = [(0.0, 0.0); 2];
        for block in first..first + count {
            assert_eq!(film.variance_by_halves(0).map(f64::is_finite), [block > first + 1; 3]);
            film.add_block(0, block, &slot(noise(0, block)));
            let (sum, n) = &mut halves[(block % 2) as usize];
            (*sum, *n) = (*sum + f64::from(noise(0, block)) / 16.0, *n + 1.0);
        }
        let [even, odd] = halves.map(|(sum, n)| sum / n);
        // s^2 of a block, were there but these two means: var(even) + var(odd) = s^2 (1/n + 1/m), and the mean's is s^2 / (n + m).
        let of_block = (even - odd).powi(2) / (1.0 / halves[0].1 + 1.0 / halves[1].1);
        let expected = of_block / count as f64;
        assert!((film.variance_by_halves(0)[0] / expected - 1.0).abs() < 1e-9, "{first}, {count}");
    }
}

#[test]
fn a_tiny_variance_on_a_large_mean_survives() {
    let mut film = Film::new(1, 1, Aovs::NONE, 0);
    for block in 0..100u64 {
        let value = if block % 2 == 0 { 1e6 } else { 1e6 + 0.0625 };
        film.add_block(0, block, &SlotRecord { sum: [value; 3], first_bad: NONE, ..Default::default() });
    }
    let expected = (0.0625f64 / 2.0 / 16.0).powi(2) / 99.0;
    assert!((film.variance_of_mean(0)[0] / expected - 1.0).abs() < 1e-9);
    assert_eq!(Film::new(1, 1, Aovs::NONE, 0).variance_of_mean(0), [f64::INFINITY; 3]);
}

#[test]
fn aovs_are_means_and_depth_is_over_hits() {
    let tile = Tile { x: 0, y: 0, width: 2, height: 1 };
    let aovs = Aovs::usual().with("object");
    let mut film = Film::new(2, 1, aovs, 0);
    film.add_tile(tile, 0..4, &rows(2, tile, 0..4, aovs));
    let index = aov::index_of;
    for (name, mean) in [("albedo", [0.25; 3]), ("normal", [0.0, 1.0, 0.0]), ("depth", [3.0, 0.0, 0.0])] {
        assert_eq!(film.aov_mean(index(name), 1), Some(mean), "{name}");
    }
    assert_eq!((film.hit_share(1), film.aov_mean(index("uv"), 1)), (0.5, None));
    let ids = ["zero", "one", "two", "three", "four", "five"].map(aov::cryptomatte::id);
    let ranked = aov::cryptomatte::ranked(&film, index("object"), 1, &ids);
    assert_eq!(ranked, [(0.0, 0.5), (ids[5], 0.375), (ids[3], 0.125)]);
}

#[test]
fn a_wrong_aov_names_the_nearest() {
    let error = Aovs::parse("albdo").unwrap_err();
    assert!(error.contains("\"albdo\"") && error.contains("did you mean albedo?"), "{error}");
    assert_eq!(Aovs::parse("none"), Ok(Aovs::NONE));
    assert!(Aovs::parse("uv, direct").unwrap().has("direct") && !Aovs::parse("uv").unwrap().has("direct"));
}

#[test]
fn ledger_counts_and_keeps_keys() {
    let mut film = Film::new(2, 1, Aovs::NONE, 0);
    let mut bad = slot(1.0);
    LEDGER_NAN.add(&mut bad, 2);
    LEDGER_DISAGREE.add(&mut bad, 255);
    bad.first_bad = 5;
    bad.lost_energy = 0.5;
    film.add_block(1, 0, &bad);
    film.add_block(1, 1, &SlotRecord { sum: [f32::INFINITY, 1.0, 1.0], first_bad: NONE, ..Default::default() });
    let ledger = film.ledger();
    assert_eq!((ledger.nan, ledger.inf, ledger.disagree, ledger.lost_energy), (2, 1, 255, 0.5));
    assert!(ledger.is_saturated);
    assert_eq!(ledger.bad_samples, [BadSample { x: 1, y: 0, sample: 5 }, BadSample { x: 1, y: 0, sample: 16 }]);
    assert!(film.mean(1)[0].is_finite());
    assert_eq!(ledger.summary(), "NaN 2, infinite 1, sides disagree 255");
}

#[test]
fn stated_bytes_a_pixel() {
    assert_eq!((Film::BYTES_A_PIXEL, Film::bytes_a_pixel(Aovs::usual())), (124, 188));
}

#[test]
fn a_film_larger_than_memory_is_refused_with_numbers() {
    assert!(Film::check_memory(64, 64, Aovs::ALL).is_ok());
    let error = Film::check_memory(1 << 20, 1 << 20, Aovs::NONE).unwrap_err().to_string();
    assert!(error.contains("1048576x1048576") && error.contains("--size"), "{error}");
}
