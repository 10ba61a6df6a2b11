//! Random numbers of the independent mode: a counter through the finaliser of splitmix64 (Steele, Lea, Flood 2014; constants
//! of Stafford's mix 13), 53 bits a number. Shares nothing with `sampler` but the names of the dimensions.

use crate::reference::path::{Random, RayKind};
use crate::reference::tree::Hit;
use crate::sampler::Purpose;

/// The numbers of one sample of one pixel.
#[derive(Clone, Copy, Debug)]
pub struct Stream {
    key: u64,
}

fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// Steps of the Weyl sequence: 2^64 over the golden ratio.
const STEP: u64 = 0x9e37_79b9_7f4a_7c15;

impl Stream {
    pub fn new(seed: u64, pixel: [u32; 2], sample: u64) -> Self {
        let place = u64::from(pixel[0]) << 32 | u64::from(pixel[1]);
        Self { key: mix(mix(mix(seed.wrapping_add(STEP)) ^ place).wrapping_add(STEP) ^ sample) }
    }

    fn word(&self, vertex: u32, purpose: u64) -> u64 {
        let counter = u64::from(vertex) << 32 | purpose;
        mix(self.key ^ mix(counter.wrapping_mul(STEP).wrapping_add(STEP)))
    }

    fn number(word: u64) -> f64 {
        (word >> 11) as f64 * (-53f64).exp2()
    }
}

impl Random for Stream {
    fn bits(&self, vertex: u32, purpose: Purpose) -> u32 {
        (self.word(vertex, u64::from(4 * purpose.set + purpose.dim)) >> 32) as u32
    }

    fn unit(&self, vertex: u32, purpose: Purpose) -> f64 {
        Self::number(self.word(vertex, u64::from(4 * purpose.set + purpose.dim)))
    }

    fn accepts(&self, vertex: u32, purpose: Purpose, p: f64) -> bool {
        self.unit(vertex, purpose) < p
    }

    fn is_present(&self, vertex: u32, kind: RayKind, hit: &Hit, p: f64) -> bool {
        // Above the 64 dimensions of a vertex, by ray kind; then by primitive. A sphere's two sides differ by t.
        let word = self.word(vertex, 64 + kind as u64);
        Self::number(mix(word ^ mix(u64::from(hit.primitive) ^ hit.t.to_bits().rotate_left(32)))) < p
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler;

    #[test]
    fn moments_and_neighbours_are_those_of_uniform_numbers() {
        let n = 200_000u64;
        let (mut mean, mut square, mut lag) = (0.0, 0.0, 0.0);
        for i in 0..n {
            let s = Stream::new(1, [i as u32 % 97, i as u32 / 97], 3);
            let (u, v) = (s.unit(1, sampler::BSDF_U) - 0.5, s.unit(1, sampler::BSDF_V) - 0.5);
            mean += u / n as f64;
            square += u * u / n as f64;
            lag += u * v / n as f64;
        }
        // Five standard errors: sd(u) = 0.2887, sd(u^2) = 0.0745, sd(uv) = 1/12.
        let bound = 5.0 / (n as f64).sqrt();
        assert!(mean.abs() < 0.2887 * bound, "{mean}");
        assert!((square - 1.0 / 12.0).abs() < 0.0745 * bound, "{square}");
        assert!(lag.abs() < bound / 12.0, "{lag}");
    }
}
