//! The device's integer stream as the loop's source of numbers: same words, same 24-bit numbers, same 32-bit thresholds.

use crate::integrator::SamplerKind;
use crate::reference::path::{Random, RayKind};
use crate::reference::tree::Hit;
use crate::sampler::{self, Purpose, SampleId, hash::hash_combine};

/// The words of one sample of one pixel.
#[derive(Clone, Copy, Debug)]
pub struct Stream {
    sampler: SamplerKind,
    id: SampleId,
    /// For randomness at a hit.
    path_hash: u32,
}

impl Stream {
    pub fn new(sampler: SamplerKind, seed: u32, pixel_index: u32, sample: u32) -> Self {
        let path_hash = hash_combine(hash_combine(seed, pixel_index), sample);
        Self { sampler, id: sampler.sample_id(pixel_index, sample, seed), path_hash }
    }
}

/// The choice is taken when the word is below; p >= 1 always is, by the callers.
fn is_below(word: u32, p: f64) -> bool {
    p >= 1.0 || word < sampler::probability_threshold(p as f32)
}

impl Random for Stream {
    fn bits(&self, vertex: u32, purpose: Purpose) -> u32 {
        self.sampler.sample_u32(self.id, vertex, purpose)
    }

    fn unit(&self, vertex: u32, purpose: Purpose) -> f64 {
        sampler::u01(self.bits(vertex, purpose))
    }

    fn accepts(&self, vertex: u32, purpose: Purpose, p: f64) -> bool {
        is_below(self.bits(vertex, purpose), p)
    }

    fn is_present(&self, vertex: u32, kind: RayKind, hit: &Hit, p: f64) -> bool {
        let hit = hit.primitive ^ (u32::from(hit.is_far) << 31);
        is_below(hash_combine(hash_combine(self.path_hash, 2 * vertex + kind as u32), hit), p)
    }
}
