// glTF 2.0 metallic-roughness surface with ior, transmission, volume boundary; the mix is explained in src/bsdf/gltf.rs.
struct Gltf {
    Spectrum base_color;
    Spectrum multiple_color;
    float metal;   // shares of the three surfaces: m, (1-m)(1-t), (1-m)t
    float opaque;
    float transmitting;
    float ior;
    float f0;
    Ggx ggx;
    vec2 average;  // of the facets' deficit and Schlick albedo
    bool is_thin;
    bool is_matched;
    bool is_khronos;
    bool is_compensated;
};

// What depends on wo alone: o above, the index beyond over the index here, albedo of the facets, probabilities of the cosine lobe
// and of the facets (both as quotients: 1 - p has no digits where p is near 1).
struct GltfOutgoing {
    vec3 o;
    float eta;
    vec2 albedo;
    float p_cosine;
    float p_facet;
};

struct GltfFacet {
    Spectrum reflected;
    Spectrum transmitted;
    float cos_t;
    float p_reflection;
    float p_transmission;
};

float gltf_mean(Spectrum c) {
    return dot(c, Spectrum(1.0 / 3.0));
}

// 1 - E0 and 1 - B at one cosine (bsdf/ggx_albedo.glsl); a mirror has its Fresnel term itself.
vec2 gltf_albedo_at(Gltf b, float mu) {
    return b.ggx.is_smooth ? vec2(0.0, one_minus_pow5(mu)) : ggx_albedo_at(mu, b.ggx.alpha.x);
}

// 1 - E of the opaque dielectric's facets.
float gltf_left(Gltf b, vec2 albedo) {
    return mix(albedo.y, albedo.x, b.f0);
}

Gltf gltf_params(Spectrum base_color, float metallic, float roughness, float ior, float transmission, float thin,
                 float khronos_mix, float compensation) {
    Gltf b;
    b.base_color = clamp(base_color, Spectrum(0.0), Spectrum(1.0));
    b.metal = clamp(metallic, 0.0, 1.0);
#if GLTF_TRANSMISSION
    float t = clamp(transmission, 0.0, 1.0);
#else
    float t = 0.0;
#endif
    b.opaque = (1.0 - b.metal) * (1.0 - t);
    b.transmitting = (1.0 - b.metal) * t;
    b.ior = max(ior, 1e-3);
    b.f0 = sqr((b.ior - 1.0) / (b.ior + 1.0));
    b.ggx = ggx_from_roughness(roughness, -1.0);
    b.average = b.ggx.is_smooth ? vec2(0.0, 1.0 / 21.0) : ggx_albedo_average(b.ggx.alpha.x);
    b.is_thin = thin >= 0.5;
    b.is_matched = !b.is_thin && abs(b.ior - 1.0) < 1e-4;
    b.is_khronos = GLTF_KHRONOS_MIX == 1 && khronos_mix >= 0.5;
    b.is_compensated = GLTF_COMPENSATION == 1 && compensation >= 0.5 && !b.is_khronos;
    Spectrum fresnel_average = b.base_color + (Spectrum(1.0) - b.base_color) * (1.0 / 21.0);
    b.multiple_color = b.is_compensated ? ggx_multiple_scattering_color(fresnel_average, b.average.x) : Spectrum(0.0);
    return b;
}

GltfOutgoing gltf_outgoing(Gltf b, vec3 wo) {
    GltfOutgoing w;
    w.o = vec3(wo.xy, abs(wo.z));
    w.eta = wo.z < 0.0 && !b.is_thin ? 1.0 / b.ior : b.ior;
    w.albedo = gltf_albedo_at(b, w.o.z);
    float base = gltf_mean(b.base_color);
    float facets = b.metal * (1.0 - mix(w.albedo.y, w.albedo.x, base)) + b.opaque * (1.0 - gltf_left(b, w.albedo));
    facets += b.transmitting;
    float cosine = b.metal * w.albedo.x * gltf_mean(b.multiple_color) + b.opaque * base * gltf_left(b, w.albedo);
    w.p_cosine = cosine > 0.0 ? cosine / (cosine + facets) : 0.0;
    w.p_facet = cosine > 0.0 ? facets / (cosine + facets) : 1.0;
    return w;
}

GltfFacet gltf_facet(Gltf b, float cos_h, float eta) {
    Spectrum schlick = fresnel_schlick(cos_h, b.base_color) * b.metal + fresnel_schlick(cos_h, Spectrum(b.f0)) * b.opaque;
#if GLTF_TRANSMISSION
    vec3 f = fresnel_dielectric(cos_h, eta);
    Spectrum transmitted = b.base_color * (f.z * b.transmitting);
    GltfFacet t = GltfFacet(schlick + Spectrum(f.x * b.transmitting), transmitted, f.y, 1.0, 0.0);
    float passing = gltf_mean(t.transmitted);
    float staying = gltf_mean(t.reflected);
    t.p_transmission = passing > 0.0 ? passing / (passing + staying) : 0.0;
    t.p_reflection = passing > 0.0 ? staying / (passing + staying) : 1.0;
    return t;
#else
    return GltfFacet(schlick, Spectrum(0.0), 0.0, 1.0, 0.0);
#endif
}

// Lambertian base and the metal's multiple scattering; cos_i > 0.
Spectrum gltf_cosine_lobe(Gltf b, GltfOutgoing w, float cos_i, float cos_h) {
    vec2 albedo_i = gltf_albedo_at(b, cos_i);
    float average = gltf_left(b, vec2(b.average.x, 1.0 - b.average.y));
    float base = average > 0.0 ? gltf_left(b, w.albedo) * gltf_left(b, albedo_i) / average : 0.0;
#if GLTF_KHRONOS_MIX
    base = b.is_khronos ? (1.0 - b.f0) * one_minus_pow5(cos_h) : base;
#endif
    Spectrum value = b.base_color * (b.opaque * base * INV_PI * cos_i);
#if GLTF_COMPENSATION
    float multiple = ggx_multiple_scattering(w.albedo.x, albedo_i.x, b.average.x, cos_i);
    value += b.multiple_color * (b.metal * multiple);
#endif
    return value;
}

// Separable over height-correlated masking, for khronos_mix: G1(o) G1(i) / G2 = 2 (zo si + zi so) / ((zo + so)(zi + si)).
float gltf_masking(Gltf b, vec3 o, vec3 i) {
#if GLTF_KHRONOS_MIX
    float so = ggx_stretch(b.ggx, o);
    float si = ggx_stretch(b.ggx, i);
    float zi = abs(i.z);
    return b.is_khronos ? 2.0 * (o.z * si + zi * so) / ((o.z + so) * (zi + si)) : 1.0;
#else
    return 1.0;
#endif
}

// Without delta lobes; facet h and cos_h = o.h as sampling or the half vector gave them; i as seen from wo's side; l = |o + eta i|.
BsdfValue gltf_value(Gltf b, GltfOutgoing w, vec3 i, vec3 h, float cos_h, float l) {
    bool is_transmitted = i.z < 0.0;
    GltfFacet facet = gltf_facet(b, cos_h, w.eta);
    float masking = gltf_masking(b, w.o, i);
    vec3 mirrored = vec3(i.xy, abs(i.z));
    vec2 reflection = b.ggx.is_smooth ? vec2(0.0) : ggx_reflection(b.ggx, w.o, mirrored, h);
    Spectrum value = facet.reflected * (reflection.x * masking) + gltf_cosine_lobe(b, w, mirrored.z, cos_h);
    float pdf = w.p_facet * facet.p_reflection * reflection.y + w.p_cosine * INV_PI * mirrored.z;
#if GLTF_TRANSMISSION
    vec2 refraction = vec2(1.0 / (w.eta * w.eta), 1.0) * ggx_refraction(b.ggx, w.o, i, h, w.eta, l);
    vec2 passing = b.is_thin ? reflection : refraction;
    bool is_facing = b.is_thin || dot(i, h) < 0.0;
    passing = is_facing && cos_h > 0.0 && !b.ggx.is_smooth && !b.is_matched ? passing : vec2(0.0);
    value = is_transmitted ? facet.transmitted * (passing.x * masking) : value;
    pdf = is_transmitted ? w.p_facet * facet.p_transmission * passing.y : pdf;
#endif
    bool is_seen = w.o.z > 0.0 && (i.z > 0.0 || (GLTF_TRANSMISSION == 1 && is_transmitted));
    return BsdfValue(is_seen ? value : Spectrum(0.0), is_seen ? pdf : 0.0);
}

BsdfValue gltf_eval_pdf(Gltf b, vec3 wo, vec3 wi) {
    GltfOutgoing w = gltf_outgoing(b, wo);
    vec3 i = vec3(wi.xy, wo.z < 0.0 ? -wi.z : wi.z);
#if GLTF_TRANSMISSION
    bool is_refracted = i.z < 0.0 && !b.is_thin;
    vec3 v = is_refracted ? w.o + w.eta * i : w.o + vec3(i.xy, abs(i.z));
    vec3 h = ggx_half(v);
    h = h.z < 0.0 ? -h : h;
    float cos_h = is_refracted ? dot(w.o, h) : 0.5 * length(v);
#else
    vec3 v = w.o + i;
    vec3 h = ggx_half(v);
    float cos_h = 0.5 * length(v);
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
    bool is_kept = o.z > 0.0 && (is_transmitted ? i.z < 0.0 : i.z > 0.0) && pdf > 0.0;
    s.wi = vec3(i.xy, wo.z < 0.0 ? -i.z : i.z);
    s.weight = is_kept ? value / pdf : Spectrum(0.0);
    s.pdf = is_kept ? pdf : 0.0;
    s.flags = (is_delta ? SAMPLE_DELTA : 0u) | (is_transmitted ? SAMPLE_TRANSMISSION : 0u);
    return s;
}

Spectrum gltf_albedo(Gltf b) {
    return b.base_color;
}

bool gltf_is_delta(Gltf b) {
    return (b.ggx.is_smooth && b.opaque == 0.0) || (b.is_matched && b.transmitting == 1.0);
}
