// Light arriving at a path vertex: sampled emitters (next-event estimation) and emitters that the path ran into, each with the weight
// of multiple importance sampling. The algorithm is stated in src/integrator/path.rs. Which kinds of lights there are is generated:
// light_connect, light_density and light_background choose among them (src/light/mod.rs).

#if NEXT_EVENT
// From the surface point p; what can also be run into is seen from s.from beside it, so that both densities are for one point.
LightSample light_sample(PathState s, vec3 p) {
    uint index = light_choose(s.from, s.from_normal, path_word(s, LIGHT_INDEX), path_word(s, LIGHT_FRACTION));
    vec2 u = vec2(u01(path_word(s, LIGHT_U)), u01(path_word(s, LIGHT_V)));
    LightSample r = light_connect(s, LightRecord_load_lights(index), p, u);
    r.light = index;
    r.pdf *= light_pmf(s.from, s.from_normal, index);
    return r;
}
#endif

#if HAS_EMISSION
void add_emission(inout PathState s, Surface surface, MaterialRecord material, float distance) {
    bool is_front = dot(surface.ng, s.ray.d) < 0.0;
    bool shines = (material.flags & MATERIAL_EMITS) != 0u
        && (is_front || (material.flags & MATERIAL_EMITS_TWO_SIDED) != 0u);
    float density = 0.0;
#if HAS_SURFACE_LIGHTS
    if (surface.light != NONE) {
        // Solid-angle density with which `light_sample` would have found this emitter's front or back, choice included.
        density = light_density(LightRecord_load_lights(surface.light), s.from, s.ray.d, distance, is_front)
            * light_pmf(s.from, s.from_normal, surface.light);
    }
#endif
    Spectrum emitted = shines ? material_emission(material, surface.point) : Spectrum(0.0);
    path_gather(s, s.throughput * emitted * emission_weight(s, density), s.edge, LIGHT_GROUP(material.group));
}
#endif
