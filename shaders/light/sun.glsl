// A disc infinitely far away, of the same radiance all over, sampled uniformly in solid angle. See src/light/sun.rs.

// Whether `d` lies in the cone about `axis` (both unit) whose 1 - cos is h: by the chord, which keeps its digits for a small disc.
bool sun_holds(vec3 axis, float h, vec3 d) {
    vec3 chord = d - axis;
    return 0.5 * dot(chord, chord) <= h;
}

vec3 sun_direction(vec3 axis, float h, vec2 u) {
    return to_world(frame_from_normal(axis), uniform_cone(u, h));
}

#if IN_KERNEL
// light.b towards its middle, light.a.x 1 - cos of its half angle, light.c its radiance.
#if HAS_LIGHT_SUN
LightSample sun_light_connect(PathState s, LightRecord light, vec3 p, vec2 u) {
    vec3 wi = sun_direction(light.b, light.a.x, u);
    return LightSample(wi, INFINITY, uniform_cone_pdf(light.a.x), light.c, NONE, NONE, false);
}
#endif

// What all suns send to a path that has left the scene: they are the first rows of `lights`.
void sun_light_arriving(inout PathState s) {
    for (uint row = 0u; row < SUN_COUNT; row++) {
        LightRecord light = LightRecord_load_lights(row);
        float density = 0.0;
#if HAS_LIGHT_SUN
        density = uniform_cone_pdf(light.a.x) * light_pmf(s.from, s.from_normal, row);
#endif
        float weight = emission_weight(s, density);
        Spectrum radiance = sun_holds(light.b, light.a.x, s.ray.d) ? light.c * weight : Spectrum(0.0);
        path_gather(s, s.throughput * radiance, s.edge, LIGHT_GROUP(light.shape));
    }
}
#endif
