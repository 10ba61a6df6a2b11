//! Padded, shuffled, Owen-scrambled Sobol words: Burley 2020, "Practical Hash-based Owen Scrambling", JCGT 9(4).
//!
//! Every set of four dimensions is the first four Sobol dimensions, its order of samples shuffled and its digits scrambled by
//! seeds of (pixel, vertex, set); samples first..first+2^m at a multiple of 2^m remain a net in each set. The scramble is the
//! Laine-Karras hash with the constants of Vegdahl 2021 ("Building a Better LK Hash"). Direction numbers are generated from
//! the primitive polynomials and initial numbers of Joe and Kuo 2008 (new-joe-kuo-6, dimensions 1 to 4).
//!
//! A pixel has two sequences with scrambles of their own. Blocks of 16 samples belong to one and the other by turns, so that the
//! difference of two means that share nothing tells the error of both (Owen 1997: replicates), at whatever rate they converge. The price is
//! that two halves of N samples meet in place of one net: `bench --filter exponents` has it.
//!
//! GLSL: shaders/sampler/sobol.glsl, equal bit for bit.

use super::hash::{hash_combine, pcg};
use super::{Purpose, SETS_PER_VERTEX, SampleId};
use crate::film::slot::BLOCK_SAMPLES;

/// Degree, inner coefficients and initial odd numbers m of dimensions 2 to 4 (Joe and Kuo 2008).
const POLYNOMIALS: [(usize, u32, [u32; 3]); 3] = [(1, 0, [1, 0, 0]), (2, 1, [1, 3, 0]), (3, 1, [1, 3, 1])];

/// `DIRECTIONS[d][k]`: what bit k (from the least) of the index flips in dimension d; bit 31 is the first digit.
pub const DIRECTIONS: [[u32; 32]; 4] = directions();

const fn directions() -> [[u32; 32]; 4] {
    let mut table = [[0; 32]; 4];
    let mut k = 0;
    while k < 32 {
        table[0][k] = 1 << (31 - k);
        k += 1;
    }
    let mut d = 1;
    while d < 4 {
        let (degree, inner, first) = POLYNOMIALS[d - 1];
        let mut k = 0;
        while k < 32 {
            table[d][k] = if k < degree {
                first[k] << (31 - k)
            } else {
                // Joe and Kuo 2008, eq. 2: v_k = c_1 v_(k-1) + ... + v_(k-s) + v_(k-s) / 2^s, sums without carry.
                let mut v = table[d][k - degree] ^ (table[d][k - degree] >> degree);
                let mut j = 1;
                while j < degree {
                    v ^= ((inner >> (degree - 1 - j)) & 1) * table[d][k - j];
                    j += 1;
                }
                v
            };
            k += 1;
        }
        d += 1;
    }
    table
}

/// A hash in which bit k of the result depends on bits 0..=k only: an Owen scramble of the reversed word.
pub fn laine_karras(x: u32, seed: u32) -> u32 {
    let mut x = x;
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul((seed >> 16) | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^ x.wrapping_mul(0x53a2_2864)
}

/// Sobol word with its digits reversed (first digit in bit 0), ready for `laine_karras`.
fn sobol_reversed(index: u32, dim: u32) -> u32 {
    let word = (0..32).filter(|k| (index >> k) & 1 == 1).fold(0, |w, k| w ^ DIRECTIONS[dim as usize][k]);
    word.reverse_bits()
}

/// Sample of the pixel's even blocks or odd blocks. Pixels below 2^31 share no seed.
pub fn sample_id(pixel_index: u32, sample_index: u32, seed: u32) -> SampleId {
    let (block, in_block) = (sample_index / BLOCK_SAMPLES, sample_index % BLOCK_SAMPLES);
    let sequence = pixel_index ^ (block % 2) << 31;
    SampleId { pixel_seed: hash_combine(pcg(seed), sequence), index: block / 2 * BLOCK_SAMPLES + in_block }
}

/// All 32 bits are usable.
pub fn sample_u32(id: SampleId, vertex: u32, purpose: Purpose) -> u32 {
    let set_seed = hash_combine(id.pixel_seed, vertex.wrapping_mul(SETS_PER_VERTEX).wrapping_add(purpose.set));
    let shuffled = laine_karras(id.index.reverse_bits(), set_seed).reverse_bits();
    laine_karras(sobol_reversed(shuffled, purpose.dim & 3), hash_combine(set_seed, purpose.dim & 3)).reverse_bits()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of the sequence that the pixel's even blocks belong to.
    fn points(pixel: u32, first: u32, count: u32, dims: [u32; 2]) -> Vec<[u32; 2]> {
        let pixel_seed = sample_id(pixel, 0, 1).pixel_seed;
        let word = |index: u32, dim| sample_u32(SampleId { pixel_seed, index }, 3, Purpose { name: "", set: 2, dim });
        (first..first + count).map(|i| dims.map(|d| word(i, d))).collect()
    }

    /// Every elementary interval of area 2^-m holds exactly one of 2^m aligned samples: t = 0.
    #[test]
    fn dims_0_and_1_are_a_net_after_scrambling() {
        for pixel in 0..8 {
            for (m, first) in [(4, 0), (4, 48), (8, 256 * 5), (10, 0)] {
                for a in 0..=m {
                    let mut seen = vec![false; 1 << m];
                    for p in points(pixel, first, 1 << m, [0, 1]) {
                        // checked_shr: a shift by 32 is 0 bits.
                        let x = p[0].checked_shr(32 - a).unwrap_or(0);
                        let y = p[1].checked_shr(32 - (m - a)).unwrap_or(0);
                        let cell = ((x << (m - a)) | y) as usize;
                        assert!(!std::mem::replace(&mut seen[cell], true), "pixel {pixel} m {m} a {a}");
                    }
                }
            }
        }
    }

    #[test]
    fn blocks_take_turns_between_two_sequences() {
        let id = |pixel, sample| sample_id(pixel, sample, 7);
        let [even, odd] = [0, 16].map(|sample| id(5, sample).pixel_seed);
        assert_ne!(even, odd);
        let blocks: Vec<SampleId> = (0..96).map(|sample| id(5, sample)).collect();
        for (sequence, seed) in [even, odd].into_iter().enumerate() {
            let indices: Vec<u32> = blocks.iter().filter(|id| id.pixel_seed == seed).map(|id| id.index).collect();
            assert_eq!(indices, (0..48).collect::<Vec<_>>(), "sequence {sequence}");
            assert_eq!(blocks[32 * sequence..][..16].iter().map(|id| id.index).min(), Some(16 * sequence as u32));
        }
        // No two pixels share one.
        let mut seeds: Vec<u32> = (0..1 << 12).flat_map(|pixel| [0, 16].map(|s| id(pixel, s).pixel_seed)).collect();
        seeds.sort_unstable();
        seeds.dedup();
        assert_eq!(seeds.len(), 2 << 12);
    }

    /// Each dimension alone is stratified: 2^m aligned samples fall in 2^m different intervals.
    #[test]
    fn every_dimension_is_stratified() {
        for dim in 0..4 {
            let mut cells: Vec<u32> = points(9, 4096, 1024, [dim, dim]).iter().map(|p| p[0] >> 22).collect();
            cells.sort_unstable();
            cells.dedup();
            assert_eq!(cells.len(), 1024, "dim {dim}");
        }
    }

    #[test]
    fn directions_are_triangular_with_unit_diagonal() {
        for (d, row) in DIRECTIONS.iter().enumerate() {
            for (k, v) in row.iter().enumerate() {
                assert_eq!(v.trailing_zeros() as usize, 31 - k, "dim {d} bit {k}");
            }
        }
        // Joe and Kuo 2008: dimension 2 starts 1/2, 3/4, 5/8, 15/16; dimension 3 starts 1/2, 3/4, 3/8.
        assert_eq!(DIRECTIONS[1][..4], [1 << 31, 3 << 30, 5 << 29, 15 << 28]);
        assert_eq!(DIRECTIONS[2][..3], [1 << 31, 3 << 30, 3 << 29]);
    }

    /// The GLSL file holds the columns of dimensions 2 and 3 as figures, in this order.
    #[test]
    fn the_shader_holds_these_directions() {
        let text = include_str!("../../shaders/sampler/sobol.glsl");
        let mut figures = text
            .lines()
            .filter(|l| l.contains("sobol_columns(i >>"))
            .flat_map(|l| l.split("0x").skip(1).map(|h| u32::from_str_radix(&h[..8], 16).unwrap()));
        for d in 2..4 {
            for (k, v) in DIRECTIONS[d].iter().enumerate() {
                assert_eq!(figures.next(), Some(v.reverse_bits()), "dimension {d}, bit {k}");
            }
        }
    }
}
