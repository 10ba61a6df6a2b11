//! Films joined, stored and read back are those of one run.

use super::aov::{AOVS, Aovs};
use super::noise::{bits, film};
use super::store::ReadError;
use super::*;

const WINDOW: Tile = Tile { x: 2, y: 1, width: 7, height: 5 };

fn all() -> Aovs {
    Aovs::parse("all").unwrap()
}

/// Everything that a picture, its estimate and its record take from a film.
fn picture(film: &Film) -> Vec<u64> {
    let mut words = Vec::new();
    for pixel in 0..film.pixel_count() {
        words.extend(film.mean(pixel).map(f64::to_bits));
        words.extend(film.variance_of_mean(pixel).map(f64::to_bits));
        // Sums of odd blocks are f64.
        words.extend(film.variance_by_halves(pixel).map(|v| u64::from((v as f32).to_bits())));
        words.push(u64::from(film.block_count(pixel)));
        for index in 0..AOVS.len() {
            words.extend(film.aov_mean(index, pixel).unwrap_or_default().map(f64::to_bits));
            let mut ids: Vec<_> = film.ids(index, pixel).collect();
            ids.sort();
            words.extend(ids.iter().map(|(id, count)| u64::from(*id) << 32 | u64::from(*count)));
        }
    }
    words.extend([film.ray_count(), film.ledger().nan]);
    words
}

#[test]
fn ranges_added_are_one_run() {
    let one = film(WINDOW, all(), 0..40);
    for cuts in [vec![0, 17, 40], vec![0, 1, 2, 39, 40], vec![0, 8, 16, 24, 32, 40]] {
        let mut whole = film(WINDOW, all(), cuts[0]..cuts[1]);
        for cut in cuts[1..].windows(2) {
            whole.add_film(&film(WINDOW, all(), cut[0]..cut[1]));
        }
        assert_eq!(picture(&whole), picture(&one), "{cuts:?}");
    }
    // As a tree.
    let part = |a, b| film(WINDOW, all(), a..b);
    let (mut left, mut right) = (part(0, 9), part(20, 31));
    left.add_film(&part(9, 20));
    right.add_film(&part(31, 40));
    left.add_film(&right);
    assert_eq!(picture(&left), picture(&one));
}

#[test]
fn a_film_of_one_block_adds_the_bits_of_the_block() {
    let mut film_of_11 = film(WINDOW, all(), 0..10);
    film_of_11.add_film(&film(WINDOW, all(), 10..11));
    assert_eq!(bits(&film_of_11), bits(&film(WINDOW, all(), 0..11)));
}

#[test]
fn the_lowest_pixels_are_covered_once_and_no_others() {
    for seed in 0..200u64 {
        let mut film = Film::over(WINDOW, Aovs::NONE, 0);
        for (pixel, count) in film.block_count.iter_mut().enumerate() {
            // Some thick, some thin patterns.
            let key = if seed % 2 == 0 { pixel as u64 } else { pixel as u64 / 4 };
            *count = 3 + u32::from(super::noise::hash([seed, key, 0]) % 4 < seed % 4);
        }
        let mut covered = vec![0; film.pixel_count()];
        for tile in film.lowest() {
            for at in 0..tile.pixel_count() as u32 {
                let (x, y) = (tile.x - WINDOW.x + at % tile.width, tile.y - WINDOW.y + at / tile.width);
                covered[(y * WINDOW.width + x) as usize] += 1;
            }
        }
        let least = film.min_block_count();
        for (pixel, times) in covered.iter().enumerate() {
            assert_eq!(*times, i32::from(film.block_count[pixel] == least), "seed {seed}, pixel {pixel}");
        }
    }
    assert_eq!(film(WINDOW, Aovs::NONE, 0..1).lowest(), [WINDOW], "one tile where all are equal");
}

#[test]
fn a_stored_film_comes_back_and_goes_on() {
    for aovs in [Aovs::NONE, Aovs::usual(), all()] {
        let whole = film(WINDOW, aovs, 3..9);
        let bytes = bits(&whole);
        let mut back = Film::restore(WINDOW, aovs, (3, false), &mut &bytes[..], bytes.len() as u64).unwrap();
        back.set_totals(whole.ray_count(), whole.ledger().clone());
        assert_eq!((bits(&back), picture(&back)), (bytes, picture(&whole)));
    }
}

/// Wrong sizes, counts and numbers are refused before they are used.
#[test]
fn a_film_that_cannot_be_is_refused() {
    let aovs = Aovs::NONE.with("object");
    let bytes = bits(&film(WINDOW, aovs, 0..2));
    let refused = |bytes: &[u8], window: Tile, first: u64| match Film::restore(
        window,
        aovs,
        (first, false),
        &mut &bytes[..],
        bytes.len() as u64,
    ) {
        Err(ReadError::Content(what)) => what,
        other => panic!("{:?}", other.map(|_| ())),
    };
    let larger = Tile { width: 60_000, height: 60_000, ..WINDOW };
    assert!(refused(&bytes, larger, 0).contains("more than its bytes"));
    assert!(refused(&bytes, WINDOW, store::MAX_BLOCKS - 1).contains("beyond 2^32"));
    let changed = |at: usize, with: &[u8]| {
        let mut bytes = bytes.clone();
        bytes[at..at + with.len()].copy_from_slice(with);
        bytes
    };
    let pixels = WINDOW.pixel_count();
    assert!(refused(&changed(0, &u32::MAX.to_le_bytes()), WINDOW, 0).contains("beyond 2^32"));
    assert!(refused(&changed(pixels * 4 + 8, &f64::NAN.to_le_bytes()), WINDOW, 0).contains("not finite"));
    let lengths = pixels * Film::BYTES_A_PIXEL;
    assert!(refused(&changed(lengths, &u32::MAX.to_le_bytes()), WINDOW, 0).contains("not as long"));
    assert!(refused(&changed(bytes.len() - 4, &9999u32.to_le_bytes()), WINDOW, 0).contains("one for each sample"));
    assert!(refused(&bytes[..bytes.len() - 8], WINDOW, 0).contains("not as long"));
}
