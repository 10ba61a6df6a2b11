// Shading frame, next-event estimation and the next direction at a surface. Rules of the frame and of disagreeing normals:
// src/integrator/path.rs.

struct Shading {
    Frame frame;   // n = shading normal
    vec3 ng;       // on the viewer's side for surfaces that do not transmit
    vec3 wo;       // local
    Lobes lobes;
};

Shading shading_load(PathState s, Surface surface, MaterialRecord material, inout Tally tally) {
    Shading r;
    vec3 wo = -s.ray.d;
    vec3 ng = surface.ng;
    vec3 ns = surface.ns;
    vec4 tangent = surface.tangent;
#if HAS_NORMAL_MAPS
    Frame base = frame_from_tangent(ns, tangent.xyz);
    vec3 m = material_normal(material, surface.point);
    vec3 mapped = base.t * (m.x * material.normal_scale) + base.b * (m.y * material.normal_scale * tangent.w) + base.n * m.z;
    float length2 = dot(mapped, mapped);
    bool is_mapped = (material.flags & MATERIAL_NORMAL_MAP) != 0u && tangent.w != 0.0 && length2 > 1e-12;
    ns = is_mapped ? mapped * inversesqrt(max(length2, 1e-30)) : ns;
#endif
    bool is_back = dot(wo, ng) < 0.0;
#if HAS_TRANSMISSION
    is_back = is_back && (material.flags & MATERIAL_TRANSMITS) == 0u;
#endif
    ng = is_back ? -ng : ng;
    ns = is_back ? -ns : ns;
    bool disagrees = (dot(wo, ns) > 0.0) != (dot(wo, ng) > 0.0);
    ns = disagrees ? ng : ns;
    tally.disagree += disagrees ? 1u : 0u;
    r.ng = ng;
#if HAS_TANGENTS
    bool follows_tangent = (material.flags & MATERIAL_TANGENT) != 0u;
    r.frame = frame_from_tangent(ns, follows_tangent ? tangent.xyz : vec3(0.0));
#else
    r.frame = frame_from_normal(ns);
#endif
    r.wo = to_local(r.frame, wo);
#if MEDIA_STACK
    r.lobes = material_lobes(material, surface.point, s.outside);
#else
    r.lobes = material_lobes(material, surface.point);
#endif
#if GLTF_ANISOTROPY
    // Directions of anisotropy turn towards the bitangent of the front, which the frame's y may oppose.
    lobes_mirror(r.lobes, (tangent.w < 0.0) != is_back);
#endif
    return r;
}

// Shading and geometric normal put `wi` on the same side.
bool sides_agree(Shading shading, vec3 wi_local, vec3 wi) {
    return (wi_local.z > 0.0) == (dot(wi, shading.ng) > 0.0);
}

#if NEXT_EVENT
// Adds the light of one sampled emitter; returns the rays traced.
uint add_next_event(inout PathState s, Surface surface, MaterialRecord material, Shading shading, inout Tally tally) {
    // Beside the surface, on the viewer's side: a sphere that lights itself is then seen from inside or outside, not as rounding has it.
    s.from = spawn_origin(surface.p, surface.error, shading.ng, -s.ray.d);
    s.from_normal = shading.frame.n;
    LightSample light = light_sample(s, surface.p);
    vec3 wi = to_local(shading.frame, light.wi);
    Spectrum f = bsdf_eval(shading.lobes, shading.wo, wi);
    // A NaN counts as light, here and in `scatter`: the sample is then counted as bad, and does not just lose a part.
    bool is_lit = max_component(f * light.radiance) > 0.0 || is_nan_bits(dot(f, light.radiance));
    bool is_candidate = light.pdf > 0.0 && is_lit && sides_agree(shading, wi, light.wi) && !bsdf_is_delta(shading.lobes);
    float weight = 1.0 / light.pdf;
#if ESTIMATOR_MIS && HAS_SIZED_LIGHTS
    float share = mis_weight(light.pdf, bsdf_pdf(shading.lobes, shading.wo, wi));
#if HAS_DELTA_LIGHTS
    // No path runs into a light without size: its sample is all of its light.
    share = light.is_delta ? 1.0 : share;
#endif
    weight *= share;
#endif
    // A surface does not light itself through itself.
    bool is_own = light.light == surface.light && (dot(light.wi, shading.ng) > 0.0) == (dot(s.ray.d, shading.ng) > 0.0);
    is_candidate = is_candidate && !is_own;
    Spectrum arriving = light.radiance;
    vec3 origin = spawn_origin(surface.p, surface.error, shading.ng, light.wi);
    // A ray of length 0 reaches nothing: lanes without a candidate leave the traversal at once.
    Ray shadow = Ray(origin, light.wi, is_candidate ? light.distance : 0.0);
#if HAS_MEDIA
    // Through the medium on wi's side: that of the path when wi leaves on wo's side.
    bool stays = (dot(light.wi, shading.ng) > 0.0) == (dot(s.ray.d, shading.ng) < 0.0);
    Inside inside = stays ? s.medium : medium_beyond(s, surface, material, light.wi);
    bool arrives = light_arrives(s, shadow, light.primitive, inside, arriving, tally) && is_candidate;
#else
    bool arrives = is_candidate && is_visible(shadow, light.primitive, s.hash, s.edge, tally);
#endif
    path_gather(s, arrives ? s.throughput * f * arriving * weight : Spectrum(0.0), s.edge + 1u, LIGHT_GROUP(light_group(light.light)));
    return is_candidate ? 1u : 0u;
}
#endif

// Chooses the next direction; returns false when the path is absorbed.
bool scatter(inout PathState s, Surface surface, MaterialRecord material, Shading shading, inout Tally tally) {
    vec2 u = vec2(u01(path_word(s, BSDF_U)), u01(path_word(s, BSDF_V)));
#if HAS_MIXTURES
    shading.lobes.pick = path_word(s, BSDF_MIX);
#endif
    BsdfSample b = bsdf_sample(shading.lobes, shading.wo, path_word(s, BSDF_LOBE), u);
    vec3 wi = to_world(shading.frame, b.wi);
    bool is_sampled = (b.pdf > 0.0 && max_component(b.weight) > 0.0) || is_nan_bits(b.pdf + dot(b.weight, vec3(1.0)));
    bool agrees = sides_agree(shading, b.wi, wi);
    tally.disagree += is_sampled && !agrees ? 1u : 0u;
    s.throughput *= b.weight;
    s.eta_scale *= b.eta_scale;
    s.pdf = (b.flags & SAMPLE_DELTA) != 0u ? 0.0 : b.pdf;
    s.ray = Ray(spawn_origin(surface.p, surface.error, shading.ng, wi), wi, INFINITY);
#if TEXTURE_HAS_MIPS
    cone_scatter(s, s.pdf == 0.0, b.pdf);
#endif
#if HAS_MEDIA
    bool crosses = (b.flags & SAMPLE_TRANSMISSION) != 0u;
    s.medium = crosses ? medium_beyond(s, surface, material, wi) : s.medium;
#endif
    return is_sampled && agrees;
}

// Roulette on throughput without refraction's factor; unbiased. 0.05 bounds the weight of a survivor to 20 times.
bool roulette_survives(inout PathState s) {
    float q = clamp(max_component(s.throughput) / s.eta_scale, 0.05, 1.0);
    bool plays = s.edge >= ROULETTE_EDGE;
    bool survives = !plays || q >= 1.0 || path_word(s, ROULETTE) < probability_threshold(q);
    s.throughput *= plays ? 1.0 / q : 1.0;
    return survives;
}
