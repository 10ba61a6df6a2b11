// What a slot learns from its paths: ledger counts and, what AOVs were asked for (src/film/aov).

Tally tally_new() {
    Tally t;
    t.rays = 0u;
    t.nan = 0u;
    t.infinite = 0u;
    t.negative = 0u;
    t.disagree = 0u;
    t.depth = 0u;
    t.cut = 0u;
#if HAS_ALPHA || MEDIA_STACK
    t.alpha_overflow = 0u;
#endif
#if MEDIA_STACK
    t.media_overflow = 0u;
#endif
    t.lost_energy = 0.0;
    t.first_bad = NONE;
#if AOVS
    t.aovs = aov_new();
#endif
    return t;
}

// A path cut at the depth limit while its surface would still scatter.
void tally_depth(inout Tally t, PathState s, Shading shading) {
    bool scatters = max_component(bsdf_albedo(shading.lobes)) > 0.0;
    t.depth += scatters ? 1u : 0u;
    t.lost_energy += scatters ? luminance(s.throughput) : 0.0;
}

// The sample as it enters the sum: NaN and infinity are counted and enter as 0, negatives are counted and kept.
Spectrum tally_sample(inout Tally t, PathState s, uint slot, uint sample_index) {
    Spectrum radiance = s.radiance;
    bool has_nan = is_nan_bits(radiance.x) || is_nan_bits(radiance.y) || is_nan_bits(radiance.z);
    bool has_inf = is_inf_bits(radiance.x) || is_inf_bits(radiance.y) || is_inf_bits(radiance.z);
    bool is_negative = !(has_nan || has_inf) && (radiance.x < 0.0 || radiance.y < 0.0 || radiance.z < 0.0);
    t.nan += has_nan ? 1u : 0u;
    t.infinite += has_inf && !has_nan ? 1u : 0u;
    t.negative += is_negative ? 1u : 0u;
    bool is_bad = has_nan || has_inf;
    t.first_bad = (is_bad || is_negative) && t.first_bad == NONE ? sample_index : t.first_bad;
#if AOVS
    aov_path(t.aovs, s, is_bad, slot * (SLOT_ROWS + AOV_ROWS) + SLOT_ROWS, sample_index % BLOCK_SAMPLES);
#endif
    return is_bad ? Spectrum(0.0) : radiance;
}
