// What every light answers; the list of kinds and the functions each supplies are in src/light/mod.rs. After integrator/state.
//   x_light_connect   a direction from p (or s.from beside it) towards the light                     every kind that is sampled
//   x_light_density   the density of that, for emission that a path ran into    kinds whose surface can be hit
//   x_light_arriving  adds emission along a ray that has left the scene, weighed     kinds infinitely far away

// Power heuristic with beta = 2 in a form that cannot overflow; `own` > 0. Veach 1997, eq. 9.13.
float mis_weight(float own, float other) {
    float r = other / own;
    return 1.0 / (1.0 + r * r);
}

// Weight of emission that the path ran into by itself; `light_density` is 0 where light sampling cannot find it.
float emission_weight(PathState s, float light_density) {
    float weight = 1.0;
    bool counts_whole = s.pdf == 0.0 || light_density == 0.0;
#if ESTIMATOR_MIS
    weight = counts_whole ? 1.0 : mis_weight(s.pdf, light_density);
#elif ESTIMATOR_LIGHT
    weight = counts_whole ? 1.0 : 0.0;
#endif
    return weight;
}

#if NEXT_EVENT
struct LightSample {
    vec3 wi;
    float distance;     // INFINITY for what is infinitely far away
    float pdf;          // 1/sr; 0 means no sample
    Spectrum radiance;  // W/(m2 sr)
    uint primitive;     // the light's own, which its shadow ray ignores, or NONE
    uint light;         // row of `lights`
    bool is_delta;      // no size: pdf is 1, radiance the irradiance perpendicular to wi in W/m2, and the weight 1
};

LightSample light_sample_none() {
    return LightSample(vec3(0.0, 0.0, 1.0), 0.0, 0.0, Spectrum(0.0), NONE, NONE, false);
}

#if LIGHT_GROUPS
// The light group of a row of `lights`: its material's, or its own where no surface carries it.
uint light_group(uint row) {
    LightRecord light = LightRecord_load_lights(row);
    bool has_surface = light.material != NONE;
    uint of_material = MaterialRecord_load_materials(has_surface ? light.material : 0u).group;
    return has_surface ? of_material : light.shape;
}
#endif
#endif
