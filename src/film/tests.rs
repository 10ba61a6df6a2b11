//! Grouping does not matter; mean, variance, AOVs and ledger of known blocks.

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
fn rows(film_width: u32, tile: Tile, blocks: Range<u64>, has_aov: bool) -> Vec<[u32; 4]> {
    let mut rows = Vec::new();
    for block in blocks {
        for y in 0..tile.height {
            for x in 0..tile.width {
                let pixel = ((tile.y + y) * film_width + tile.x + x) as usize;
                rows.extend_from_slice(bytemuck::cast_ref::<_, [[u32; 4]; 2]>(&slot(noise(pixel, block))));
                if has_aov {
                    let aov =
                        AovSlotRecord { albedo: [16.0 * 0.25; 3], depth: 8.0 * 3.0, normal: [0.0, 16.0, 0.0], hits: 8 };
                    rows.extend_from_slice(bytemuck::cast_ref::<_, [[u32; 4]; 2]>(&aov));
                }
            }
        }
    }
    rows
}

#[test]
fn result_does_not_depend_on_tiles_or_passes() {
    let (width, height) = (7, 5);
    let mut one = Film::new(width, height, false, 0);
    for pixel in 0..35 {
        (0..24).for_each(|block| one.add_block(pixel, block, &slot(noise(pixel, block))));
    }
    let whole = std::iter::once(0..24).collect::<Vec<_>>();
    for passes in [whole, vec![0..1, 1..2, 2..24], vec![0..11, 11..24]] {
        for has_aov in [false, true] {
            let mut film = Film::new(width, height, has_aov, 0);
            for blocks in passes.clone() {
                for tile in [
                    Tile { x: 0, y: 0, width: 7, height: 2 },
                    Tile { x: 0, y: 2, width: 3, height: 3 },
                    Tile { x: 3, y: 2, width: 4, height: 3 },
                ] {
                    film.add_tile(tile, blocks.clone(), &rows(width, tile, blocks.clone(), has_aov));
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

#[test]
fn variance_is_that_of_block_means() {
    let mut film = Film::new(1, 1, false, 3);
    let means: Vec<f64> = (3..12).map(|block| noise(0, block) as f64 / 16.0).collect();
    (3..12).for_each(|block| film.add_block(0, block, &slot(noise(0, block))));
    let moments = crate::metric::stats::Moments::of(means.iter().copied());
    assert!((film.mean(0)[0] - moments.mean).abs() < 1e-12);
    assert!((film.variance_of_mean(0)[0] / moments.variance_of_mean() - 1.0).abs() < 1e-10);
}

#[test]
fn a_tiny_variance_on_a_large_mean_survives() {
    let mut film = Film::new(1, 1, false, 0);
    for block in 0..100u64 {
        let value = if block % 2 == 0 { 1e6 } else { 1e6 + 0.0625 };
        film.add_block(0, block, &SlotRecord { sum: [value; 3], first_bad: NONE, ..Default::default() });
    }
    let expected = (0.0625f64 / 2.0 / 16.0).powi(2) / 99.0;
    assert!((film.variance_of_mean(0)[0] / expected - 1.0).abs() < 1e-9);
    assert_eq!(Film::new(1, 1, false, 0).variance_of_mean(0), [f64::INFINITY; 3]);
}

#[test]
fn aovs_are_means_and_depth_is_over_hits() {
    let tile = Tile { x: 0, y: 0, width: 2, height: 1 };
    let mut film = Film::new(2, 1, true, 0);
    film.add_tile(tile, 0..4, &rows(2, tile, 0..4, true));
    let means = film.aov_mean(1).unwrap();
    assert_eq!((means.albedo, means.depth, means.normal, means.coverage), ([0.25; 3], 3.0, [0.0, 1.0, 0.0], 0.5));
}

#[test]
fn ledger_counts_and_keeps_keys() {
    let mut film = Film::new(2, 1, false, 0);
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
    assert_eq!((Film::BYTES_A_PIXEL, Film::AOV_BYTES_A_PIXEL), (100, 64));
}

#[test]
fn a_film_larger_than_memory_is_refused_with_numbers() {
    assert!(Film::check_memory(64, 64, true).is_ok());
    let error = Film::check_memory(1 << 20, 1 << 20, false).unwrap_err().to_string();
    assert!(error.contains("1048576x1048576") && error.contains("--size"), "{error}");
}
