// What a slot learns from its paths: ledger counts and, when asked, albedo, normal and distance of the first surface.

Tally tally_new() {
    Tally t;
    t.rays = 0u;
    t.nan = 0u;
    t.infinite = 0u;
    t.negative = 0u;
    t.disagree = 0u;
    t.depth = 0u;
#if HAS_ALPHA
    t.alpha_overflow = 0u;
#endif
    t.lost_energy = 0.0;
    t.first_bad = NONE;
#if AOVS
    t.albedo = Spectrum(0.0);
    t.normal = vec3(0.0);
    t.distance = 0.0;
    t.hits = 0.0;
#endif
    return t;
}

#if AOVS
void tally_surface(inout Tally t, PathState s, Surface surface, Shading shading, float distance) {
    bool is_first = s.edge == 1u;
    t.albedo += is_first ? bsdf_albedo(shading.lobes) : Spectrum(0.0);
    t.normal += is_first ? shading.frame.n : vec3(0.0);
    t.distance += is_first ? distance : 0.0;
    t.hits += is_first ? 1.0 : 0.0;
}
#endif

// A path cut at the depth limit while its surface would still scatter.
void tally_depth(inout Tally t, PathState s, Shading shading) {
    bool scatters = max_component(bsdf_albedo(shading.lobes)) > 0.0;
    t.depth += scatters ? 1u : 0u;
    t.lost_energy += scatters ? luminance(s.throughput) : 0.0;
}

// The sample as it enters the sum: NaN and infinity are counted and enter as 0, negatives are counted and kept.
Spectrum tally_sample(inout Tally t, Spectrum radiance, uint sample_index) {
    bool has_nan = is_nan_bits(radiance.x) || is_nan_bits(radiance.y) || is_nan_bits(radiance.z);
    bool has_inf = is_inf_bits(radiance.x) || is_inf_bits(radiance.y) || is_inf_bits(radiance.z);
    bool is_negative = !(has_nan || has_inf) && (radiance.x < 0.0 || radiance.y < 0.0 || radiance.z < 0.0);
    t.nan += has_nan ? 1u : 0u;
    t.infinite += has_inf && !has_nan ? 1u : 0u;
    t.negative += is_negative ? 1u : 0u;
    bool is_bad = has_nan || has_inf;
    t.first_bad = (is_bad || is_negative) && t.first_bad == NONE ? sample_index : t.first_bad;
    return is_bad ? Spectrum(0.0) : radiance;
}
