// Which sample of which pixel, and what a random number is for; src/sampler/mod.rs has the same and the dimension table.
struct SampleId {
    uint pixel_seed;
    uint index;
};

SampleId sample_id(uint pixel_index, uint sample_index, uint seed) {
    return SampleId(hash_combine(pcg(seed), pixel_index), sample_index);
}
