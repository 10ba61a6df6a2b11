//! Independent uniform words: a counter hash of (pixel, sample, vertex, set), four words a set.
//! Jarzynski and Olano 2020, pcg4d. GLSL: shaders/sampler/independent.glsl, equal bit for bit.

use super::{Purpose, SETS_PER_VERTEX, SampleId, hash};

pub fn sample_id(pixel_index: u32, sample_index: u32, seed: u32) -> SampleId {
    SampleId { pixel_seed: hash::hash_combine(hash::pcg(seed), pixel_index), index: sample_index }
}

/// All 32 bits are usable.
pub fn sample_u32(id: SampleId, vertex: u32, purpose: Purpose) -> u32 {
    let set = vertex.wrapping_mul(SETS_PER_VERTEX).wrapping_add(purpose.set);
    hash::pcg4d([id.pixel_seed, id.index, set, 0x51ed_270b])[purpose.dim as usize & 3]
}
