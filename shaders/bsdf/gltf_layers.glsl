// Parts of glTF's surface: parameters, layers, facets, base; bsdf/gltf.glsl puts them together. See src/bsdf/gltf.rs.
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
    vec3 albedo;
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

// 1 - E0, B and 1 - B at one cosine (bsdf/ggx_albedo.glsl); a mirror has its Fresnel term itself.
vec3 gltf_albedo_at(Gltf b, float mu) {
    return b.ggx.is_smooth ? vec3(0.0, pow5(1.0 - mu), one_minus_pow5(mu)) : ggx_albedo_at(mu, b.ggx.alpha.x);
}

// 1 - E of the opaque dielectric's facets.
float gltf_left(Gltf b, vec3 albedo) {
    return mix(albedo.z, albedo.x, b.f0);
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
    float facets = b.metal * mix(w.albedo.y, 1.0 - w.albedo.x, base) + b.opaque * mix(w.albedo.y, 1.0 - w.albedo.x, b.f0);
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
    vec3 albedo_i = gltf_albedo_at(b, cos_i);
    float average = gltf_left(b, vec3(b.average, 1.0 - b.average.y));
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
