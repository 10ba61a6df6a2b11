//! Random numbers: counter-based, the same integers on every device and in Rust.
//!
//! The stream is a function of (pixel, sample, dimension, seed). One table, `DIMENSIONS`, maps (vertex, purpose) to a
//! dimension, the same in every kernel, plan and in the reference; the assembler writes it into the GLSL.

pub mod hash;
pub mod independent;
pub mod sobol;

use crate::integrator::SamplerKind;

impl SamplerKind {
    pub const ALL: [Self; 2] = [Self::Sobol, Self::Independent];

    /// Sample `sample_index` of pixel `pixel_index` = y * width + x.
    pub fn sample_id(self, pixel_index: u32, sample_index: u32, seed: u32) -> SampleId {
        match self {
            Self::Sobol => sobol::sample_id(pixel_index, sample_index, seed),
            Self::Independent => independent::sample_id(pixel_index, sample_index, seed),
        }
    }

    /// 32 uniform bits for `purpose` at path vertex `vertex`.
    pub fn sample_u32(self, id: SampleId, vertex: u32, purpose: Purpose) -> u32 {
        match self {
            Self::Sobol => sobol::sample_u32(id, vertex, purpose),
            Self::Independent => independent::sample_u32(id, vertex, purpose),
        }
    }
}

/// Which sample of which pixel; GLSL has the same struct (shaders/core/random.glsl).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SampleId {
    /// Hash of pixel and seed; different pixels of one seed never share it (of the first 2^31, where a pixel has two).
    pub pixel_seed: u32,
    /// In the sequence.
    pub index: u32,
}

/// A word to [0,1): 24 bits, so the result is an exact f32 and never 1.
pub fn u01(bits: u32) -> f64 {
    f64::from(bits >> 8) / f64::from(1u32 << 24)
}

/// A choice of probability `p` is taken when `word < threshold`: p >= 1 gives the largest word, NaN and p <= 0 give 0.
pub fn probability_threshold(p: f32) -> u32 {
    // Below 1 the product is exact in f32 and below 2^32; `as` cuts off, as GLSL's uint() does, and sends NaN to 0.
    if p >= 1.0 { u32::MAX } else { (p * 4_294_967_296.0) as u32 }
}

/// `const uvec2 PIXEL_X = uvec2(0u, 0u);` for every purpose, and the stride of vertices.
pub fn glsl_dimensions() -> String {
    let mut text = format!("const uint SETS_PER_VERTEX = {SETS_PER_VERTEX}u;\n");
    for p in DIMENSIONS {
        text += &format!("const uvec2 {} = uvec2({}u, {}u);\n", p.name, p.set, p.dim);
    }
    text
}

/// Four-dimensional sets reserved for a path vertex; unused ones stay reserved.
pub const SETS_PER_VERTEX: u32 = 16;

/// What a random number is for: `set` is one of the vertex's 16 four-dimensional sets, `dim` in 0..4 the place in it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Purpose {
    pub name: &'static str,
    pub set: u32,
    pub dim: u32,
}

macro_rules! dimensions {
    ($($(#[$meta:meta])* $name:ident = ($set:literal, $dim:literal);)*) => {
        $($(#[$meta])* pub const $name: Purpose = Purpose { name: stringify!($name), set: $set, dim: $dim };)*
        /// Every purpose; GLSL gets each as `const uvec2 NAME = uvec2(set, dim)`.
        pub const DIMENSIONS: &[Purpose] = &[$($name),*];
    };
}

dimensions! {
    // Dimensions 0 and 1 of a set cost a handful of instructions, 2 and 3 some two hundred, so pairs get sets of their own.
    /// Film position inside the pixel (vertex 0).
    PIXEL_X = (0, 0);
    PIXEL_Y = (0, 1);
    /// Which light: alias table index word and fraction word.
    LIGHT_INDEX = (1, 0);
    LIGHT_FRACTION = (1, 1);
    /// Where on the light.
    LIGHT_U = (2, 0);
    LIGHT_V = (2, 1);
    BSDF_U = (3, 0);
    BSDF_V = (3, 1);
    BSDF_LOBE = (4, 0);
    ROULETTE = (4, 1);
    /// Which cell of the sky: alias table index word and fraction word.
    SKY_INDEX = (5, 0);
    SKY_FRACTION = (5, 1);
    /// Where on the lens, or on a meter's element (vertex 0).
    LENS_U = (6, 0);
    LENS_V = (6, 1);
    /// Which element of a surface meter: alias table index word and fraction word (vertex 0).
    SENSOR_INDEX = (7, 0);
    SENSOR_FRACTION = (7, 1);
    /// Which surface of a mixture.
    BSDF_MIX = (8, 0);
}

#[cfg(test)]
mod tests {
    use super::*;

    const COUNT: u32 = 1 << 14;

    /// Chi-square of 256 equal cells (255 degrees of freedom): mean 255, sigma 22.6; 6 sigma is 391.
    fn chi2(words: impl Iterator<Item = u32>) -> f64 {
        let mut cells = [0u32; 256];
        words.for_each(|w| cells[(w >> 24) as usize] += 1);
        let expected = f64::from(cells.iter().sum::<u32>()) / 256.0;
        cells.iter().map(|&c| (f64::from(c) - expected).powi(2) / expected).sum()
    }

    fn correlation(a: &[f64], b: &[f64]) -> f64 {
        let n = a.len() as f64;
        let (ma, mb) = (a.iter().sum::<f64>() / n, b.iter().sum::<f64>() / n);
        let cov =
            |x: &[f64], mx: f64, y: &[f64], my: f64| -> f64 { x.iter().zip(y).map(|(p, q)| (p - mx) * (q - my)).sum() };
        cov(a, ma, b, mb) / (cov(a, ma, a, ma) * cov(b, mb, b, mb)).sqrt()
    }

    #[test]
    fn words_are_uniform_over_samples_and_over_pixels() {
        for sampler in SamplerKind::ALL {
            for &p in DIMENSIONS {
                let over_samples = (0..COUNT).map(|i| sampler.sample_u32(sampler.sample_id(5, i, 0), 2, p));
                let over_pixels = (0..COUNT).map(|i| sampler.sample_u32(sampler.sample_id(i, 3, 0), 2, p));
                let over_vertices = (0..COUNT).map(|i| sampler.sample_u32(sampler.sample_id(4, 3, 0), i, p));
                for (what, chi) in
                    [("samples", chi2(over_samples)), ("pixels", chi2(over_pixels)), ("vertices", chi2(over_vertices))]
                {
                    assert!(chi < 391.0, "{sampler:?} {} over {what}: {chi}", p.name);
                }
            }
        }
    }

    /// Sequences of two pixels, vertices, sets, dimensions or seeds do not follow each other: |r| < 6/sqrt(n).
    #[test]
    fn sequences_are_uncorrelated() {
        let p = |set, dim| Purpose { name: "", set, dim };
        for sampler in SamplerKind::ALL {
            let sequence = |pixel, seed, vertex, purpose| -> Vec<f64> {
                (0..COUNT)
                    .map(|i| u01(sampler.sample_u32(sampler.sample_id(pixel, i, seed), vertex, purpose)))
                    .collect()
            };
            let base = sequence(100, 0, 1, p(2, 0));
            let others = [
                ("pixel", sequence(101, 0, 1, p(2, 0))),
                ("seed", sequence(100, 1, 1, p(2, 0))),
                ("vertex", sequence(100, 0, 2, p(2, 0))),
                ("set", sequence(100, 0, 1, p(3, 0))),
                ("dim 1", sequence(100, 0, 1, p(2, 1))),
                ("dim 2", sequence(100, 0, 1, p(2, 2))),
                ("dim 3", sequence(100, 0, 1, p(2, 3))),
            ];
            for (what, other) in others {
                let r = correlation(&base, &other);
                assert!(r.abs() < 6.0 / f64::from(COUNT).sqrt(), "{sampler:?} {what}: r = {r}");
            }
        }
    }

    #[test]
    fn u01_is_below_one_and_thresholds_keep_their_probability() {
        assert!((u01(u32::MAX) as f32) < 1.0);
        assert_eq!(u01(u32::MAX) as f32 as f64, u01(u32::MAX));
        for (p, t) in [(0.0, 0), (-1.0, 0), (f32::NAN, 0), (0.5, 1 << 31), (1.0, u32::MAX), (2.0, u32::MAX)] {
            assert_eq!(probability_threshold(p), t, "{p}");
        }
    }

    #[test]
    fn the_last_indices_work() {
        for sampler in SamplerKind::ALL {
            let last = sampler.sample_u32(sampler.sample_id(u32::MAX, u32::MAX, u32::MAX), u32::MAX, ROULETTE);
            let before = sampler.sample_u32(sampler.sample_id(u32::MAX, u32::MAX - 1, u32::MAX), u32::MAX, ROULETTE);
            assert_ne!(last, before);
        }
    }
}
