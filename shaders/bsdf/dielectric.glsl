// Smooth or rough boundary that reflects and refracts, radiance mode; see src/bsdf/dielectric.rs.
struct Dielectric {
    float eta;
    Ggx ggx;
    bool is_absent;  // index matched: light passes straight on
#if DIELECTRIC_COMPENSATION
    // Multiple scattering; pairs are of the side of the lower index, and of the higher.
    bool is_compensated;
    float index;      // place in the table
    vec2 average;     // of the deficits
    vec2 transmitted; // share that leaves on the other side
#endif
};

Dielectric dielectric_params(float eta, float roughness, float roughness_y, float compensation) {
    Dielectric b;
    b.eta = eta;
    b.ggx = ggx_from_roughness(roughness, roughness_y);
    b.is_absent = abs(eta - 1.0) < 1e-4;
#if DIELECTRIC_COMPENSATION
    float n = max(eta, 1.0 / eta);
    b.is_compensated = compensation >= 0.5 && b.ggx.alpha.x == b.ggx.alpha.y && !b.ggx.is_smooth && !b.is_absent;
    b.index = dielectric_albedo_index(n);
    b.average = dielectric_albedo_average(b.ggx.alpha.x, b.index);
    float t = 1.0 - fresnel_dielectric_average(n);
    float ratio = b.average.y / b.average.x;
    b.transmitted = vec2(t * min(ratio, 1.0), t / (n * n) * min(1.0 / ratio, 1.0));
#endif
    return b;
}

bool dielectric_is_delta(Dielectric b) {
    return b.is_absent || b.ggx.is_smooth;
}

#if DIELECTRIC_COMPENSATION
// Deficits at a direction, here and on the other side, seen from where the index beyond over that here is eta.
vec2 dielectric_deficits(Dielectric b, vec3 w, float eta) {
    float mu = min(abs(w.z), 1.0);
    vec2 d = dielectric_albedo_at(mu, dot(w.xy, w.xy) / (1.0 + mu), b.ggx.alpha.x, b.index);
    return eta > 1.0 ? d : d.yx;
}

// Probability of multiple scattering: what is lost towards o.
float dielectric_lost(Dielectric b, vec3 o, float eta) {
    return b.is_compensated ? dielectric_deficits(b, o, eta).x : 0.0;
}

// (f |cos wi|, pdf given that the lobe is chosen) of multiple scattering, o above.
vec2 dielectric_multiple(Dielectric b, float lost_o, vec3 i, float eta) {
    vec2 average = eta > 1.0 ? b.average : b.average.yx;
    float t = eta > 1.0 ? b.transmitted.x : b.transmitted.y;
    float cos_i = abs(i.z);
    vec2 lost_i = dielectric_deficits(b, i, eta);
    float to_here = (1.0 - t) * lost_i.x / average.x;
    float to_there = t * lost_i.y / (average.y * eta * eta);
    return INV_PI * cos_i * (i.z > 0.0 ? vec2(lost_o * to_here, 1.0 - t) : vec2(lost_o * to_there, t));
}
#endif

// With the facet given, since sampling knows it better than the directions tell: cos_o = o.h, l = |o + eta i|. o above.
BsdfValue dielectric_value(Dielectric b, vec3 o, vec3 i, vec3 h, float cos_o, float l, float eta) {
    bool is_reflected = i.z > 0.0;
    vec3 f = fresnel_dielectric(clamp(cos_o, 0.0, 1.0), eta);
    vec2 reflection = f.x * ggx_reflection(b.ggx, o, i, h);
    vec2 refraction = f.z * vec2(1.0 / (eta * eta), 1.0) * ggx_refraction(b.ggx, o, i, h, eta, l);
    bool is_facing = is_reflected || (cos_o > 0.0 && dot(i, h) < 0.0);
    vec2 value = is_reflected ? reflection : refraction;
    value = is_facing ? value : vec2(0.0);
#if DIELECTRIC_COMPENSATION
    float lost = dielectric_lost(b, o, eta);
    vec2 multiple = dielectric_multiple(b, lost, i, eta);
    value = b.is_compensated ? vec2(value.x + multiple.x, mix(value.y, multiple.y, lost)) : value;
#endif
    bool is_seen = o.z > 0.0 && i.z != 0.0 && !dielectric_is_delta(b);
    return BsdfValue(Spectrum(is_seen ? value.x : 0.0), is_seen ? value.y : 0.0);
}

// The same without the facet.
BsdfValue dielectric_value_between(Dielectric b, vec3 o, vec3 i, float eta) {
    bool is_reflected = i.z > 0.0;
    vec3 v = is_reflected ? o + i : o + eta * i;
    vec3 h = ggx_half(v);
    h = h.z < 0.0 ? -h : h;
    float l = length(v);
    return dielectric_value(b, o, i, h, is_reflected ? 0.5 * l : dot(o, h), l, eta);
}

BsdfValue dielectric_eval_pdf(Dielectric b, vec3 wo, vec3 wi) {
    // Seen from wo's side: o above, eta the index beyond over the index here.
    float side = wo.z < 0.0 ? -1.0 : 1.0;
    float eta = wo.z < 0.0 ? 1.0 / b.eta : b.eta;
    return dielectric_value_between(b, vec3(wo.xy, abs(wo.z)), vec3(wi.xy, wi.z * side), eta);
}

Spectrum dielectric_eval(Dielectric b, vec3 wo, vec3 wi) {
    return dielectric_eval_pdf(b, wo, wi).value;
}

float dielectric_pdf(Dielectric b, vec3 wo, vec3 wi) {
    return dielectric_eval_pdf(b, wo, wi).pdf;
}

BsdfSample dielectric_sample(Dielectric b, vec3 wo, uint choice, vec2 u) {
    BsdfSample s = bsdf_sample_none();
    float side = wo.z < 0.0 ? -1.0 : 1.0;
    float eta = wo.z < 0.0 ? 1.0 / b.eta : b.eta;
    vec3 o = vec3(wo.xy, abs(wo.z));
    vec3 h = b.ggx.is_smooth ? vec3(0.0, 0.0, 1.0) : ggx_sample_visible(b.ggx, o, u);
    float cos_o = clamp(dot(o, h), 0.0, 1.0);
    vec3 f = fresnel_dielectric(cos_o, eta);
#if DIELECTRIC_COMPENSATION
    float lost = dielectric_lost(b, o, eta);
    bool is_reflected = bsdf_is_chosen(choice, lost + (1.0 - lost) * f.x);
#else
    bool is_reflected = bsdf_is_chosen(choice, f.x);
#endif
    vec3 refracted = (h * cos_o - o) / eta - h * f.y;
    vec3 i = is_reflected ? ggx_reflect(o, h) : refracted;
    i = b.is_absent ? -o : i;
    is_reflected = is_reflected && !b.is_absent;
    // |o + eta i| = |cos_o - eta cos_t| = |eta^2 - 1| / (cos_o + eta cos_t), without the difference.
    float l = abs((eta - 1.0) * (eta + 1.0)) / (cos_o + eta * f.y);
    float pdf = is_reflected ? f.x * ggx_reflection(b.ggx, o, i, h).y
                             : f.z * ggx_refraction(b.ggx, o, i, h, eta, l).y;
    bool is_delta = dielectric_is_delta(b);
    float probability = b.is_absent ? 1.0 : (is_reflected ? f.x : f.z);
    pdf = is_delta ? probability : pdf;
#if DIELECTRIC_COMPENSATION
    bool is_multiple = b.is_compensated && bsdf_is_chosen(choice, lost);
    float t = eta > 1.0 ? b.transmitted.x : b.transmitted.y;
    vec3 cosine = cosine_hemisphere(u);
    bool stays = bsdf_is_chosen(choice, lost * (1.0 - t));
    vec3 scattered = stays ? cosine : -cosine;
    BsdfValue v = dielectric_value(b, o, i, h, cos_o, l, eta);
    BsdfValue v_multiple = dielectric_value_between(b, o, scattered, eta);
    v.pdf = is_multiple ? v_multiple.pdf : v.pdf;
    v.value = is_multiple ? v_multiple.value : v.value;
    i = is_multiple ? scattered : i;
    is_reflected = is_multiple ? stays : is_reflected;
    pdf = b.is_compensated ? v.pdf : pdf;
#endif
    bool is_kept = o.z > 0.0 && (is_reflected ? i.z > 0.0 : i.z < 0.0) && pdf > 0.0;
    s.eta_scale = is_reflected || b.is_absent ? 1.0 : 1.0 / (eta * eta);
    float weight = s.eta_scale * (is_delta ? 1.0 : ggx_g2_over_g1(b.ggx, o, i));
#if DIELECTRIC_COMPENSATION
    weight = b.is_compensated ? v.value.x / v.pdf : weight;
#endif
    s.wi = vec3(i.xy, i.z * side);
    s.weight = Spectrum(is_kept ? weight : 0.0);
    s.pdf = is_kept ? pdf : 0.0;
    s.flags = (is_delta ? SAMPLE_DELTA : 0u) | (is_reflected ? 0u : SAMPLE_TRANSMISSION);
    return s;
}

Spectrum dielectric_albedo(Dielectric b) {
    return Spectrum(1.0);
}
