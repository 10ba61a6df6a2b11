// Choosing a light, or a cell of the sky, from an alias table (Vose 1991) with thresholds over 2^32; see src/light/alias.rs.
// Reads tables lights, light_alias (and sky_alias where SKY_IMAGE), and the constant LIGHT_COUNT (> 0).

// Entry of a table of `count`: the product's high word, so every word is used and no entry is favoured by more than 2^-32.
uint alias_entry(uint index_word, uint count) {
    uint high;
    uint low;
    umulExtended(index_word, count, high, low);
    return high;
}

// `row` holds entries 2k and 2k + 1 as (threshold, alias) pairs. A full entry is its own alias.
uint alias_pick(uvec4 row, uint entry, uint fraction_word) {
    uvec2 pair = (entry & 1u) == 0u ? row.xy : row.zw;
    return fraction_word < pair.x ? entry : pair.y;
}

uint alias_choose_light(uint index_word, uint fraction_word) {
    uint entry = alias_entry(index_word, LIGHT_COUNT);
    return alias_pick(light_alias_row(entry >> 1), entry, fraction_word);
}

#if SKY_IMAGE
uint alias_choose_sky(uint index_word, uint fraction_word, uint cell_count) {
    uint entry = alias_entry(index_word, cell_count);
    return alias_pick(sky_alias_row(entry >> 1), entry, fraction_word);
}
#endif

// Which light to sample from `p` with normal `n`: a row of `lights`. By power alone today; a light tree would look at p and n.
uint light_choose(vec3 p, vec3 n, uint index_word, uint fraction_word) {
    return alias_choose_light(index_word, fraction_word);
}

// Probability that `light_choose` gives `light`.
float light_pmf(vec3 p, vec3 n, uint light) {
    return LightRecord_load_lights(light).pmf;
}
