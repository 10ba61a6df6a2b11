//! Gate 2: the sampler's words, bit for bit.

use super::inputs::Inputs;
use super::probe::Probe;
use crate::integrator::SamplerKind;
use crate::sampler::{self, Purpose, hash};

fn numbers(r: &mut Inputs) -> [u32; 6] {
    [
        r.word_or_edge(),
        r.word_or_edge(),
        r.word_or_edge(),
        if r.once_in(8) { r.word_or_edge() } else { r.below(4096) },
        r.below(16),
        r.below(4),
    ]
}

fn sample(kind: SamplerKind, n: [u32; 6]) -> u32 {
    kind.sample_u32(kind.sample_id(n[0], n[1], n[2]), n[3], Purpose { name: "", set: n[4], dim: n[5] })
}

pub fn probes() -> Vec<Probe> {
    let snippet = "m0 = sample_u32(sample_id(n0, n1, n2), n3, uvec2(n4, n5));";
    let dimensions = sampler::glsl_dimensions();
    vec![
        Probe::bits("pcg", "m0 = pcg(n0);", |r| [r.word_or_edge()], |[n]| [hash::pcg(n)]),
        Probe::bits("mix32", "m0 = mix32(n0);", |r| [r.word_or_edge()], |[n]| [hash::mix32(n)]),
        Probe::bits(
            "hash_combine",
            "m0 = hash_combine(n0, n1);",
            |r| [r.word_or_edge(), r.word_or_edge()],
            |[h, v]| [hash::hash_combine(h, v)],
        ),
        Probe::bits(
            "pcg4d",
            "uvec4 h = pcg4d(uvec4(n0, n1, n2, n3)); m0 = h.x; m1 = h.y; m2 = h.z; m3 = h.w;",
            |r| [(); 4].map(|_| r.word_or_edge()),
            hash::pcg4d,
        ),
        Probe::bits("sample_u32 sobol", snippet, numbers, |n| [sample(SamplerKind::Sobol, n)])
            .prelude(&dimensions)
            .files(&["sampler/sobol.glsl"])
            .covers(&["laine_karras", "sobol_pascal", "sobol_columns", "sobol_dim2", "sobol_dim3", "sobol_reversed"]),
        Probe::bits("sample_u32 independent", snippet, numbers, |n| [sample(SamplerKind::Independent, n)])
            .prelude(&dimensions)
            .files(&["sampler/independent.glsl"]),
    ]
}
