//! Cryptomatte, specification 1.1.0 (Psyop; Friedman and Jones 2015, "Fully automatic ID mattes with support for motion blur and
//! transparency"): for each pixel the ids met by its samples, ranked by coverage, as pairs in RGBA layers, with the names in the header.
//!
//! An id is the 32-bit MurmurHash3 of the name, read as f32 with its exponent kept in 1..=254. Samples that hit nothing have the id 0;
//! their share is ranked like any other, so that all coverages of a pixel sum to 1. Coverage is the share of samples: samples
//! weigh the same, whatever the pixel filter. Things of one name are one.

use super::{Aov, Film, Names};
use crate::film::slot::BLOCK_SAMPLES;
use crate::prepare::records::NONE;

/// Ids kept a pixel: the specification's suggestion, three layers of two.
pub const RANKS: usize = 6;

/// Type name in the file and the names behind the numbers.
pub fn names_of<'a>(aov: &Aov, names: &'a Names) -> (&'static str, &'a [String]) {
    match aov.name {
        "object" => ("CryptoObject", &names.objects),
        _ => ("CryptoMaterial", &names.materials),
    }
}

/// MurmurHash3_x86_32 with seed 0 (Appleby 2011).
pub fn murmur3(bytes: &[u8]) -> u32 {
    let scramble = |k: u32| k.wrapping_mul(0xcc9e_2d51).rotate_left(15).wrapping_mul(0x1b87_3593);
    let blocks = bytes.chunks_exact(4);
    let tail = blocks.remainder().iter().rev().fold(0u32, |k, &b| k << 8 | u32::from(b));
    let mut h = blocks.fold(0u32, |h, b| {
        let k = u32::from_le_bytes([b[0], b[1], b[2], b[3]]);
        (h ^ scramble(k)).rotate_left(13).wrapping_mul(5).wrapping_add(0xe654_6b64)
    });
    h ^= scramble(tail) ^ bytes.len() as u32;
    h = (h ^ (h >> 16)).wrapping_mul(0x85eb_ca6b);
    h = (h ^ (h >> 13)).wrapping_mul(0xc2b2_ae35);
    h ^ (h >> 16)
}

/// The id of a name, as pixels hold it.
pub fn id(name: &str) -> f32 {
    let hash = murmur3(name.as_bytes());
    let exponent = (hash >> 23 & 0xff).clamp(1, 254);
    f32::from_bits(hash & 0x807f_ffff | exponent << 23)
}

/// A pixel's ids and coverages, largest coverage first; equal ones in the order of their ids, so that files repeat.
pub fn ranked(film: &Film, index: usize, pixel: usize, ids: &[f32]) -> Vec<(f32, f32)> {
    let samples = f64::from(film.block_count(pixel) * BLOCK_SAMPLES);
    let mut list: Vec<(f32, u32)> = Vec::new();
    for (number, count) in film.ids(index, pixel) {
        let id = if number == NONE { 0.0 } else { ids.get(number as usize).copied().unwrap_or(0.0) };
        match list.iter_mut().find(|entry| entry.0.to_bits() == id.to_bits()) {
            Some(entry) => entry.1 += count,
            None => list.push((id, count)),
        }
    }
    list.sort_by(|a, b| b.1.cmp(&a.1).then(a.0.to_bits().cmp(&b.0.to_bits())));
    list.into_iter().map(|(id, count)| (id, (f64::from(count) / samples) as f32)).collect()
}

/// `CryptoObject00.r` and so on: rank 0's id, its coverage, rank 1's id, its coverage; three layers.
pub(super) fn channels<'a>(
    film: &'a Film,
    index: usize,
    (typename, names): (&'static str, &'a [String]),
) -> Vec<super::Channel<'a>> {
    let ids: Vec<f32> = names.iter().map(|n| id(n)).collect();
    let ids: std::sync::Arc<[f32]> = ids.into();
    let channel = |k: usize| {
        let ids = ids.clone();
        let value = move |pixel: usize| {
            let list = ranked(film, index, pixel, &ids);
            list.get(k / 2).map_or(0.0, |&(id, coverage)| if k.is_multiple_of(2) { id } else { coverage })
        };
        let name = format!("{typename}{:02}.{}", k / 4, ["r", "g", "b", "a"][k % 4]);
        super::Channel { name, unit: "1", value: Box::new(value) }
    };
    (0..2 * RANKS).map(channel).collect()
}

/// `cryptomatte/KEY/name` and its like; the key is the type name's hash, as the specification suggests.
pub(super) fn attributes(_: &Aov, (typename, names): (&'static str, &[String])) -> Vec<(String, String)> {
    let key = format!("{:08x}", murmur3(typename.as_bytes()));
    let manifest: serde_json::Map<String, serde_json::Value> =
        names.iter().map(|n| (n.clone(), format!("{:08x}", id(n).to_bits()).into())).collect();
    let manifest = serde_json::Value::Object(manifest).to_string();
    let values = [
        ("name", typename.to_owned()),
        ("hash", "MurmurHash3_32".to_owned()),
        ("conversion", "uint32_to_float32".to_owned()),
        ("manifest", manifest),
    ];
    values.into_iter().map(|(what, text)| (format!("cryptomatte/{}/{what}", &key[..7]), text)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Published vectors of MurmurHash3_x86_32, and the specification's examples of ids.
    #[test]
    fn hashes_are_those_of_the_specification() {
        for (text, hash) in [("", 0), ("test", 0xba6b_d213), ("Hello, world!", 0xc036_3e43)] {
            assert_eq!(murmur3(text.as_bytes()), hash, "{text:?}: {:08x}", murmur3(text.as_bytes()));
        }
        for (name, hex) in [("bunny", "13851a76"), ("default", "42c9679f")] {
            assert_eq!(format!("{:08x}", id(name).to_bits()), hex, "{name}");
        }
    }

    #[test]
    fn ids_are_finite_and_no_denormals() {
        for k in 0..200_000 {
            assert!(id(&format!("thing {k}")).is_normal(), "{k}");
        }
    }
}
