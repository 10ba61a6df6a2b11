// Padded, shuffled, Owen-scrambled Sobol words (Burley 2020); sources and tests in src/sampler/sobol.rs, equal bit for bit.
// Words are kept with their digits reversed (first digit in bit 0), as the scramble wants them.

// A hash in which bit k of the result depends on bits 0..=k only: an Owen scramble of the reversed word.
uint laine_karras(uint x, uint seed) {
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16) | 1u;
    x ^= x * 0x05526c56u;
    return x ^ (x * 0x53a22864u);
}

// Dimension 0 is the index itself, dimension 1 Pascal's triangle mod 2: the fifth Kronecker power of (1 1; 0 1), so five
// exchanges instead of 32 columns.
uint sobol_pascal(uint x) {
    x ^= (x >> 1) & 0x55555555u;
    x ^= (x >> 2) & 0x33333333u;
    x ^= (x >> 4) & 0x0f0f0f0fu;
    x ^= (x >> 8) & 0x00ff00ffu;
    x ^= (x >> 16) & 0x0000ffffu;
    return x;
}

// Four columns at once: bit k of the nibble selects column k.
uint sobol_columns(uint nibble, uvec4 columns) {
    uvec4 is_set = uvec4(-ivec4((uvec4(nibble) >> uvec4(0u, 1u, 2u, 3u)) & 1u)) & columns;
    return (is_set.x ^ is_set.y) ^ (is_set.z ^ is_set.w);
}

// Columns of dimension 2, digits reversed: the Rust test compares them with sobol::DIRECTIONS.
uint sobol_dim2(uint i) {
    uint w = 0u;
    w ^= sobol_columns(i >> 0, uvec4(0x00000001u, 0x00000003u, 0x00000006u, 0x00000009u));
    w ^= sobol_columns(i >> 4, uvec4(0x00000017u, 0x0000003au, 0x00000071u, 0x000000a3u));
    w ^= sobol_columns(i >> 8, uvec4(0x00000116u, 0x00000339u, 0x00000677u, 0x000009aau));
    w ^= sobol_columns(i >> 12, uvec4(0x00001601u, 0x00003903u, 0x00007706u, 0x0000aa09u));
    w ^= sobol_columns(i >> 16, uvec4(0x00010117u, 0x0003033au, 0x00060671u, 0x000909a3u));
    w ^= sobol_columns(i >> 20, uvec4(0x00171616u, 0x003a3939u, 0x00717777u, 0x00a3aaaau));
    w ^= sobol_columns(i >> 24, uvec4(0x01170001u, 0x033a0003u, 0x06710006u, 0x09a30009u));
    w ^= sobol_columns(i >> 28, uvec4(0x16160017u, 0x3939003au, 0x77770071u, 0xaaaa00a3u));
    return w;
}

// Columns of dimension 3, digits reversed: the Rust test compares them with sobol::DIRECTIONS.
uint sobol_dim3(uint i) {
    uint w = 0u;
    w ^= sobol_columns(i >> 0, uvec4(0x00000001u, 0x00000003u, 0x00000004u, 0x0000000au));
    w ^= sobol_columns(i >> 4, uvec4(0x0000001fu, 0x0000002eu, 0x00000045u, 0x000000c9u));
    w ^= sobol_columns(i >> 8, uvec4(0x0000011bu, 0x000002a4u, 0x0000079au, 0x00000b67u));
    w ^= sobol_columns(i >> 12, uvec4(0x0000101eu, 0x0000302du, 0x00004041u, 0x0000a0c3u));
    w ^= sobol_columns(i >> 16, uvec4(0x0001f104u, 0x0002e28au, 0x000457dfu, 0x000c9baeu));
    w ^= sobol_columns(i >> 20, uvec4(0x0011a105u, 0x002a7289u, 0x0079e7dbu, 0x00b6dba4u));
    w ^= sobol_columns(i >> 24, uvec4(0x0100011au, 0x030002a7u, 0x0400079eu, 0x0a000b6du));
    w ^= sobol_columns(i >> 28, uvec4(0x1f001001u, 0x2e003003u, 0x45004004u, 0xc900a00au));
    return w;
}

uint sobol_reversed(uint index, uint dim) {
    uint word = index;
    if (dim == 1u) {
        word = sobol_pascal(index);
    }
    if (dim == 2u) {
        word = sobol_dim2(index);
    }
    if (dim == 3u) {
        word = sobol_dim3(index);
    }
    return word;
}

// Even blocks of 16 samples are those of one sequence, odd blocks those of another, which pixel numbers below 2^31 leave room for.
SampleId sample_id(uint pixel_index, uint sample_index, uint seed) {
    uint odd = (sample_index << 27) & 0x80000000u;
    uint index = ((sample_index >> 5) << 4) | (sample_index & 15u);
    return SampleId(hash_combine(pcg(seed), pixel_index ^ odd), index);
}

uint sample_u32(SampleId id, uint vertex, uvec2 purpose) {
    uint dim = purpose.y & 3u;
    uint set_seed = hash_combine(id.pixel_seed, vertex * SETS_PER_VERTEX + purpose.x);
    uint shuffled = bitfieldReverse(laine_karras(bitfieldReverse(id.index), set_seed));
    return bitfieldReverse(laine_karras(sobol_reversed(shuffled, dim), hash_combine(set_seed, dim)));
}
