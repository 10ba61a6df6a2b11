// Choosing a light from the alias table; see src/light/alias.rs. Reads tables lights, light_alias, and the constant LIGHT_COUNT (> 0).

uint alias_choose_light(uint index_word, uint fraction_word) {
    uint entry = alias_entry(index_word, LIGHT_COUNT);
    return alias_pick(light_alias_row(entry >> 1), entry, fraction_word);
}

// Which light to sample from `p` with normal `n`: a row of `lights`. By power alone today; a light tree would look at p and n.
uint light_choose(vec3 p, vec3 n, uint index_word, uint fraction_word) {
    return alias_choose_light(index_word, fraction_word);
}

// Probability that `light_choose` gives `light`.
float light_pmf(vec3 p, vec3 n, uint light) {
    return LightRecord_load_lights(light).pmf;
}
