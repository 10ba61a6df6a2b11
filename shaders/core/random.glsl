// Integer hashes on 32-bit words; Rust twins src/sampler/{hash,mod}.rs, equal bit for bit (gate 2).

// PCG output function RXS-M-XS over one LCG step (O'Neill 2014; as a hash: Jarzynski and Olano 2020, "pcg"). A bijection.
uint pcg(uint v) {
    uint state = v * 747796405u + 2891336453u;
    uint word = ((state >> ((state >> 28) + 4u)) ^ state) * 277803737u;
    return (word >> 22) ^ word;
}

// Two rounds of multiply and shift, a bijection without bit bias (form and constants: Wellons' hash-prospector, "lowbias32").
uint mix32(uint v) {
    v = (v ^ (v >> 16)) * 0x21f0aaadu;
    v = (v ^ (v >> 15)) * 0xd35a2d97u;
    return v ^ (v >> 15);
}

// Four words to four (Jarzynski and Olano 2020, listing "pcg4d").
uvec4 pcg4d(uvec4 v) {
    v = v * 1664525u + 1013904223u;
    v.x += v.y * v.w;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v.w += v.y * v.z;
    v ^= v >> 16;
    v.x += v.y * v.w;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v.w += v.y * v.z;
    return v;
}

// Adds a word to a hash; order matters. For a fixed h a bijection of v, and the other way round.
uint hash_combine(uint h, uint v) {
    // The outer round is mix32: two rounds of pcg flip bit 10 in 41 % of cases only.
    return mix32(h ^ pcg(v + 0x9e3779b9u));
}

// Which sample of which pixel; each sampler makes its own with `sample_id`.
struct SampleId {
    uint pixel_seed;  // different pixels of one seed never share it
    uint index;       // in the sequence
};
