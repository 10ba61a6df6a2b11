// Light sampling at a meter that collects from a hemisphere: its first vertex is treated as a surface's is, with f cos = cos/pi and the
// start's weight as throughput. See src/camera/mod.rs; the f64 twin is src/reference/receiver.rs.

#if HAS_RECEIVER
// Adds the light of one sampled emitter; returns the rays traced.
uint receive(inout PathState s, vec3 normal, inout Tally tally) {
    LightSample light = light_sample(s, s.ray.o);
    float density = dot(light.wi, normal) * INV_PI;
    bool is_lit = max_component(light.radiance) > 0.0 || is_nan_bits(dot(light.radiance, vec3(1.0)));
    bool is_candidate = light.pdf > 0.0 && density > 0.0 && is_lit;
    float weight = density / light.pdf;
#if ESTIMATOR_MIS && HAS_SIZED_LIGHTS
    float share = mis_weight(light.pdf, density);
#if HAS_DELTA_LIGHTS
    share = light.is_delta ? 1.0 : share;
#endif
    weight *= share;
#endif
    Spectrum arriving = light.radiance;
    Ray shadow = Ray(s.ray.o, light.wi, is_candidate ? light.distance : 0.0);
#if HAS_MEDIA
    bool arrives = light_arrives(s, shadow, light.primitive, s.medium, arriving, tally) && is_candidate;
#else
    bool arrives = is_candidate && is_visible(shadow, light.primitive, s.hash, s.edge, tally);
#endif
    path_gather(s, arrives ? s.throughput * arriving * weight : Spectrum(0.0), 1u, LIGHT_GROUP(light_group(light.light)));
    return is_candidate ? 1u : 0u;
}
#endif
