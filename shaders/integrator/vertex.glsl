// One edge of a path and the vertex at its end, which every integrator has: emission, light sampling, scattering.
// Returns true while the path goes on, which the integrator's own file has the last word on.
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
            goes_on = integrator_goes_on(s, goes_on);
        } else {
            tally_depth(tally, s, shading);
        }
    }
#if HAS_BACKGROUND
    if (!is_hit) {
        light_background(s);
    }
#endif
    return goes_on;
}
