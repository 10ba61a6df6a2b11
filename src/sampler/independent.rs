//! Independent uniform words: a counter hash of (pixel, sample, vertex, set), four words a set.
//! Jarzynski and Olano 2020, pcg4d. GLSL: shaders/sampler/independent.glsl, equal bit for bit.

use super::{Purpose, SETS_PER_VERTEX, SampleId, hash::pcg4d};

/// All 32 bits are usable.
pub fn sample_u32(id: SampleId, vertex: u32, purpose: Purpose) -> u32 {
    let set = vertex.wrapping_mul(SETS_PER_VERTEX).wrapping_add(purpose.set);
    pcg4d([id.pixel_seed, id.index, set, 0x51ed_270b])[purpose.dim as usize & 3]
}
