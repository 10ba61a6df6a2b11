// Alias tables (Vose 1991) with thresholds over 2^32; see src/light/alias.rs.

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
