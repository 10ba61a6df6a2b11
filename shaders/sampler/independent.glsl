// Independent uniform words by a counter hash; see src/sampler/independent.rs, equal bit for bit.
SampleId sample_id(uint pixel_index, uint sample_index, uint seed) {
    return SampleId(hash_combine(pcg(seed), pixel_index), sample_index);
}

uint sample_u32(SampleId id, uint vertex, uvec2 purpose) {
    uvec4 words = pcg4d(uvec4(id.pixel_seed, id.index, vertex * SETS_PER_VERTEX + purpose.x, 0x51ed270bu));
    return words[purpose.y & 3u];
}
