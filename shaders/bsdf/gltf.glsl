// glTF 2.0 metallic-roughness surface with ior, transmission, volume boundary; the mix is explained in src/bsdf/gltf.rs,
// its parts are in bsdf/gltf_params.glsl and bsdf/gltf_layers.glsl.

// Without delta lobes; facet h and cos_h = o.h as sampling or the half vector gave them; i as seen from wo's side; l = |o + eta i|.
BsdfValue gltf_value(Gltf b, GltfOutgoing w, vec3 i, vec3 h, float cos_h, float l) {
    bool is_transmitted = i.z < 0.0;
    GltfFacet facet = gltf_facet(b, cos_h, w.eta);
    float masking = gltf_masking(b, w.o, i);
    vec3 mirrored = vec3(i.xy, abs(i.z));
    vec2 reflection = b.ggx.is_smooth ? vec2(0.0) : ggx_reflection(b.ggx, w.o, mirrored, h);
    Spectrum value = facet.reflected * (reflection.x * masking) + gltf_cosine_lobe(b, w, mirrored, cos_h);
    float pdf = w.p_facet * facet.p_reflection * reflection.y + w.p_cosine * INV_PI * mirrored.z;
#if GLTF_TRANSMISSION
    vec2 refraction = vec2(1.0 / (w.eta * w.eta), 1.0) * ggx_refraction(b.ggx, w.o, i, h, w.eta, l);
    vec2 passing = b.is_thin ? reflection : refraction;
    bool is_facing = b.is_thin || dot(i, h) < 0.0;
    passing = is_facing && cos_h > 0.0 && !b.ggx.is_smooth && !b.is_matched ? passing : vec2(0.0);
    value = is_transmitted ? facet.transmitted * (passing.x * masking) : value;
    pdf = is_transmitted ? w.p_facet * facet.p_transmission * passing.y : pdf;
#endif
#if GLTF_CLEARCOAT
    vec2 coat = b.coat.ggx.is_smooth || is_transmitted ? vec2(0.0) : ggx_reflection(b.coat.ggx, w.o, mirrored, h);
    value *= w.through * coat_shares(b.coat, min(mirrored.z, 1.0)).x;
    value += Spectrum(coat_fresnel(b.coat, cos_h) * coat.x);
    pdf += w.p_coat * coat.y;
#endif
    bool is_seen = w.o.z > 0.0 && (i.z > 0.0 || (GLTF_TRANSMISSION == 1 && is_transmitted));
    return BsdfValue(is_seen ? value : Spectrum(0.0), is_seen ? pdf : 0.0);
}

BsdfValue gltf_eval_pdf(Gltf b, vec3 wo, vec3 wi) {
    GltfOutgoing w = gltf_outgoing(b, wo);
    vec3 o = vec3(wo.xy, abs(wo.z));
    vec3 i = vec3(wi.xy, wo.z < 0.0 ? -wi.z : wi.z);
#if GLTF_TRANSMISSION
    bool is_refracted = i.z < 0.0 && !b.is_thin;
    vec3 v = is_refracted ? o + w.eta * i : o + vec3(i.xy, abs(i.z));
    vec3 h = ggx_half(v);
    h = h.z < 0.0 ? -h : h;
    float cos_h = is_refracted ? dot(o, h) : 0.5 * length(v);
#else
    vec3 v = o + i;
    vec3 h = ggx_half(v);
    float cos_h = 0.5 * length(v);
#endif
#if GLTF_ANISOTROPY
    // Turned after the sum: turned directions would cancel in it down to their rounding.
    h = gltf_turned(b, h);
    i = gltf_turned(b, i);
#endif
    return gltf_value(b, w, i, h, clamp(cos_h, 0.0, 1.0), length(v));
}

Spectrum gltf_eval(Gltf b, vec3 wo, vec3 wi) {
    return gltf_eval_pdf(b, wo, wi).value;
}

float gltf_pdf(Gltf b, vec3 wo, vec3 wi) {
    return gltf_eval_pdf(b, wo, wi).pdf;
}

BsdfSample gltf_sample(Gltf b, vec3 wo, uint choice, vec2 u) {
    BsdfSample s = bsdf_sample_none();
    GltfOutgoing w = gltf_outgoing(b, wo);
    vec3 o = w.o;
    vec3 h = b.ggx.is_smooth ? vec3(0.0, 0.0, 1.0) : ggx_sample_visible(b.ggx, o, u);
#if GLTF_CLEARCOAT
    bool is_coat = w.p_coat > 0.0 && !bsdf_is_chosen(choice, w.p_cosine + w.p_facet);
    vec3 h_coat = b.coat.ggx.is_smooth ? vec3(0.0, 0.0, 1.0) : ggx_sample_visible(b.coat.ggx, o, u);
    h = is_coat ? h_coat : h;
#endif
    float cos_h = clamp(dot(o, h), 0.0, 1.0);
    GltfFacet facet = gltf_facet(b, cos_h, w.eta);
    bool is_cosine = bsdf_is_chosen(choice, w.p_cosine);
    vec3 i = ggx_reflect(o, h);
    float p_transmission = w.p_facet * facet.p_transmission;
    float l = 0.0;
    bool is_transmitted = false;
    bool is_refracted = false;
#if GLTF_TRANSMISSION
    is_transmitted = !is_cosine && bsdf_is_chosen(choice, w.p_cosine + p_transmission);
#if GLTF_SPECULAR
    // Without any reflection the threshold is 1 up to rounding.
    is_transmitted = is_transmitted || (!is_cosine && facet.p_reflection == 0.0);
#endif
#if GLTF_CLEARCOAT
    is_transmitted = is_transmitted && !is_coat;
#endif
    is_refracted = is_transmitted && !b.is_thin && !b.is_matched;
    vec3 refracted = (h * cos_h - o) / w.eta - h * facet.cos_t;
    l = abs((w.eta - 1.0) * (w.eta + 1.0)) / (cos_h + w.eta * facet.cos_t);
    vec3 passing = b.is_thin ? vec3(i.xy, -i.z) : (b.is_matched ? -o : refracted);
    i = is_transmitted ? passing : i;
#endif
    i = is_cosine ? cosine_hemisphere(u) : i;
    vec3 v_h = o + i;
    vec3 h_value = is_cosine ? ggx_half(v_h) : h;
    BsdfValue v = gltf_value(b, w, i, h_value, is_cosine ? min(0.5 * length(v_h), 1.0) : cos_h, l);
    s.eta_scale = is_refracted ? 1.0 / (w.eta * w.eta) : 1.0;
    bool is_delta = !is_cosine && (b.ggx.is_smooth || (is_transmitted && b.is_matched));
    Spectrum delta_value = is_transmitted ? facet.transmitted * s.eta_scale : facet.reflected;
    float delta_pdf = is_transmitted ? p_transmission : w.p_facet * facet.p_reflection;
    Spectrum value = is_delta ? delta_value : v.value;
    float pdf = is_delta ? delta_pdf : v.pdf;
#if GLTF_CLEARCOAT
    is_delta = is_coat ? b.coat.ggx.is_smooth : is_delta;
    delta_value *= w.through * coat_shares(b.coat, min(abs(i.z), 1.0)).x;
    delta_value = is_coat ? Spectrum(coat_fresnel(b.coat, cos_h)) : delta_value;
    value = is_delta ? delta_value : v.value;
    pdf = is_delta ? (is_coat ? w.p_coat : delta_pdf) : v.pdf;
#endif
    bool is_kept = o.z > 0.0 && (is_transmitted ? i.z < 0.0 : i.z > 0.0) && pdf > 0.0;
#if GLTF_ANISOTROPY
    vec3 wi = gltf_turned_back(b, i);
#else
    vec3 wi = i;
#endif
    s.wi = vec3(wi.xy, wo.z < 0.0 ? -i.z : i.z);
    s.weight = is_kept ? value / pdf : Spectrum(0.0);
    s.pdf = is_kept ? pdf : 0.0;
    s.flags = (is_delta ? SAMPLE_DELTA : 0u) | (is_transmitted ? SAMPLE_TRANSMISSION : 0u);
    return s;
}

Spectrum gltf_albedo(Gltf b) {
    return b.base_color;
}

bool gltf_is_delta(Gltf b) {
    bool is_delta = (b.ggx.is_smooth && b.opaque == 0.0) || (b.is_matched && b.transmitting == 1.0);
#if GLTF_CLEARCOAT
    is_delta = is_delta && (b.coat.weight == 0.0 || b.coat.ggx.is_smooth);
#endif
    return is_delta;
}
