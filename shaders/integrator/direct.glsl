// The lecture's reflection equation: emission seen directly plus one bounce, without roulette. See src/integrator/direct.rs.
// MAX_DEPTH is 2 at most, so that it returns true after the first edge only.
bool integrator_step(inout PathState s, inout Tally tally) {
    Hit hit = trace_edge(s, tally);
    tally.rays += 1u;
    s.edge += 1u;
    bool is_hit = hit.kind != NO_HIT;
    bool goes_on = false;
    if (is_hit) {
        Surface surface = surface_load(hit, s.ray);
#if MEDIA_STACK
        surface.error += vec3(s.touching);
#endif
#if TEXTURE_HAS_MIPS
        cone_travel(s, hit.t);
        surface.point.areas = footprint_areas(s, hit, surface);
#endif
        MaterialRecord material = MaterialRecord_load_materials(surface.material);
#if HAS_EMISSION
        add_emission(s, surface, material, hit.t);
#endif
        Shading shading = shading_load(s, surface, material, tally);
#if AOVS
        aov_surface(tally.aovs, s, surface, shading, hit);
#endif
        if (s.edge < MAX_DEPTH) {
#if NEXT_EVENT
            tally.rays += add_next_event(s, surface, material, shading, tally);
#endif
            goes_on = scatter(s, surface, material, shading, tally);
        } else {
            tally_depth(tally, s, shading);
        }
    }
#if HAS_BACKGROUND
    if (!is_hit) {
        add_background(s);
    }
#endif
    return goes_on;
}
