// Smooth or rough boundary that reflects and refracts, radiance mode; see src/bsdf/dielectric.rs.
struct Dielectric {
    float eta;
    Ggx ggx;
    bool is_absent;  // index matched: light passes straight on
};

Dielectric dielectric_params(float eta, float roughness, float roughness_y) {
    return Dielectric(eta, ggx_from_roughness(roughness, roughness_y), abs(eta - 1.0) < 1e-4);
}

bool dielectric_is_delta(Dielectric b) {
    return b.is_absent || b.ggx.is_smooth;
}

BsdfValue dielectric_eval_pdf(Dielectric b, vec3 wo, vec3 wi) {
    // Seen from wo's side: o above, eta the index beyond over the index here.
    float side = wo.z < 0.0 ? -1.0 : 1.0;
    float eta = wo.z < 0.0 ? 1.0 / b.eta : b.eta;
    vec3 o = vec3(wo.xy, abs(wo.z));
    vec3 i = vec3(wi.xy, wi.z * side);
    bool is_reflected = i.z > 0.0;
    vec3 v = is_reflected ? o + i : o + eta * i;
    vec3 h = ggx_half(v);
    h = h.z < 0.0 ? -h : h;
    float l = length(v);
    float cos_o = is_reflected ? 0.5 * l : dot(o, h);
    vec3 f = fresnel_dielectric(clamp(cos_o, 0.0, 1.0), eta);
    vec2 reflection = f.x * ggx_reflection(b.ggx, o, i, h);
    vec2 refraction = f.z * vec2(1.0 / (eta * eta), 1.0) * ggx_refraction(b.ggx, o, i, h, eta, l);
    bool is_facing = is_reflected || (cos_o > 0.0 && dot(i, h) < 0.0);
    bool is_seen = o.z > 0.0 && i.z != 0.0 && is_facing && !dielectric_is_delta(b);
    vec2 value = is_reflected ? reflection : refraction;
    return BsdfValue(Spectrum(is_seen ? value.x : 0.0), is_seen ? value.y : 0.0);
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
    bool is_reflected = bsdf_is_chosen(choice, f.x);
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
    bool is_kept = o.z > 0.0 && (is_reflected ? i.z > 0.0 : i.z < 0.0) && pdf > 0.0;
    s.eta_scale = is_reflected || b.is_absent ? 1.0 : 1.0 / (eta * eta);
    float weight = s.eta_scale * (is_delta ? 1.0 : ggx_g2_over_g1(b.ggx, o, i));
    s.wi = vec3(i.xy, i.z * side);
    s.weight = Spectrum(is_kept ? weight : 0.0);
    s.pdf = is_kept ? pdf : 0.0;
    s.flags = (is_delta ? SAMPLE_DELTA : 0u) | (is_reflected ? 0u : SAMPLE_TRANSMISSION);
    return s;
}

Spectrum dielectric_albedo(Dielectric b) {
    return Spectrum(1.0);
}
