// Parts of glTF's surface: layers, facets, base; bsdf/gltf.glsl puts them together. See src/bsdf/gltf.rs.
// What depends on wo alone: o above, the index beyond over the index here, albedo of the facets, probabilities of the cosine lobe
// and of the facets (both as quotients: 1 - p has no digits where p is near 1).
struct GltfOutgoing {
    vec3 o;
    float eta;
    vec3 albedo;
    float p_cosine;
    float p_facet;
#if GLTF_CLEARCOAT
    float p_coat;
    float through;  // of the light towards wo that left the base
#endif
};

struct GltfFacet {
    Spectrum reflected;
    Spectrum transmitted;
    float cos_t;
    float p_reflection;
    float p_transmission;
};

// 1 - E0, B and 1 - B towards w, w.z > 0 (bsdf/ggx_albedo.glsl); a mirror has its Fresnel term itself. Of a surface with two
// widths they are those of the isotropic one that is as wide along w.
vec3 gltf_albedo_at(Gltf b, vec3 w) {
    float mu = w.z;
#if GLTF_ANISOTROPY
    vec2 xy = b.ggx.alpha * w.xy;
    float alpha = sqrt(dot(xy, xy) + b.ggx.alpha.x * b.ggx.alpha.y * mu * mu);
#else
    float alpha = b.ggx.alpha.x;
#endif
    return b.ggx.is_smooth ? vec3(0.0, pow5(1.0 - mu), one_minus_pow5(mu)) : ggx_albedo_at(mu, alpha);
}

// 1 - E of the opaque dielectric's facets, of the channel that reflects most.
float gltf_left(Gltf b, vec3 albedo) {
#if GLTF_SPECULAR
    return 1.0 - b.specular + b.specular * mix(albedo.z, albedo.x, b.f0);
#else
    return mix(albedo.z, albedo.x, b.f0);
#endif
}

GltfOutgoing gltf_outgoing(Gltf b, vec3 wo) {
    GltfOutgoing w;
    w.o = vec3(wo.xy, abs(wo.z));
#if GLTF_ANISOTROPY
    w.o = gltf_turned(b, w.o);
#endif
    w.eta = wo.z < 0.0 && !b.is_thin ? 1.0 / b.ior : b.ior;
    w.albedo = gltf_albedo_at(b, w.o);
    float base = gltf_mean(b.base_color);
#if GLTF_SPECULAR
    float dielectric = b.specular * mix(w.albedo.y, 1.0 - w.albedo.x, gltf_mean(b.tinted_f0));
#else
    float dielectric = mix(w.albedo.y, 1.0 - w.albedo.x, b.f0);
#endif
    float facets = b.metal * mix(w.albedo.y, 1.0 - w.albedo.x, base) + b.opaque * dielectric;
    facets += b.transmitting;
    float cosine = b.metal * w.albedo.x * gltf_mean(b.multiple_color) + b.opaque * base * gltf_left(b, w.albedo);
    w.p_cosine = cosine > 0.0 ? cosine / (cosine + facets) : 0.0;
    w.p_facet = cosine > 0.0 ? facets / (cosine + facets) : 1.0;
#if GLTF_CLEARCOAT
    vec2 coat = coat_shares(b.coat, min(w.o.z, 1.0));
    w.through = coat.x;
    float below = coat.x * (cosine + facets);
    w.p_coat = below > 0.0 ? coat.y / (coat.y + below) : 0.0;
    float p_below = below > 0.0 ? below / (coat.y + below) : 1.0;
    w.p_cosine *= p_below;
    w.p_facet *= p_below;
#endif
    return w;
}

GltfFacet gltf_facet(Gltf b, float cos_h, float eta) {
#if GLTF_SPECULAR
    Spectrum dielectric = fresnel_schlick(cos_h, b.tinted_f0) * b.specular;
#else
    Spectrum dielectric = fresnel_schlick(cos_h, Spectrum(b.f0));
#endif
    Spectrum schlick = fresnel_schlick(cos_h, b.base_color) * b.metal + dielectric * b.opaque;
#if GLTF_TRANSMISSION
    vec3 f = fresnel_dielectric(cos_h, eta);
#if GLTF_SPECULAR
    // A dimmed reflection leaves more to pass, but nothing passes under total reflection.
    f.z += f.z > 0.0 ? (1.0 - max_component(b.tint)) * f.x : 0.0;
    Spectrum exact = b.tint * f.x;
#else
    Spectrum exact = Spectrum(f.x);
#endif
    Spectrum transmitted = b.base_color * (f.z * b.transmitting);
    GltfFacet t = GltfFacet(schlick + exact * b.transmitting, transmitted, f.y, 1.0, 0.0);
    float passing = gltf_mean(t.transmitted);
    float staying = gltf_mean(t.reflected);
    t.p_transmission = passing > 0.0 ? passing / (passing + staying) : 0.0;
    t.p_reflection = passing > 0.0 ? staying / (passing + staying) : 1.0;
    return t;
#else
    return GltfFacet(schlick, Spectrum(0.0), 0.0, 1.0, 0.0);
#endif
}

// Lambertian base and the metal's multiple scattering; i.z > 0.
Spectrum gltf_cosine_lobe(Gltf b, GltfOutgoing w, vec3 i, float cos_h) {
    float cos_i = i.z;
    vec3 albedo_i = gltf_albedo_at(b, i);
    float average = gltf_left(b, vec3(b.average, 1.0 - b.average.y));
    float base = average > 0.0 ? gltf_left(b, w.albedo) * gltf_left(b, albedo_i) / average : 0.0;
#if GLTF_KHRONOS_MIX
    float khronos = (1.0 - b.f0) * one_minus_pow5(cos_h);
#if GLTF_SPECULAR
    khronos = 1.0 - b.specular + b.specular * khronos;
#endif
    base = b.is_khronos ? khronos : base;
#endif
    Spectrum value = b.base_color * (b.opaque * base * INV_PI * cos_i);
#if GLTF_COMPENSATION
    float multiple = ggx_multiple_scattering(w.albedo.x, albedo_i.x, b.average.x, cos_i);
    value += b.multiple_color * (b.metal * multiple);
#endif
#if GLTF_CLEARCOAT
    // The coat sends some of it back: the average of all passages is what one of them gets.
    value /= b.coat_average;
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
