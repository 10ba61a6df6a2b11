// GGX metal with exact Fresnel reflectance; see src/bsdf/conductor.rs.
struct Conductor {
    Spectrum eta;
    Spectrum k;
    Ggx ggx;
#if CONDUCTOR_COMPENSATION
    bool is_compensated;
    float average;
    Spectrum multiple_color;
#endif
};

Conductor conductor_params(Spectrum eta, Spectrum k, float roughness, float roughness_y, float compensation) {
    Conductor b;
    b.eta = max(eta, Spectrum(0.0));
    b.k = max(k, Spectrum(0.0));
    b.ggx = ggx_from_roughness(roughness, roughness_y);
#if CONDUCTOR_COMPENSATION
    b.is_compensated = compensation >= 0.5 && !b.ggx.is_smooth;
    vec2 alpha = b.ggx.alpha;
    b.average = ggx_albedo_average(0.5 * (sqrt(0.5 * dot(alpha, alpha)) + max(alpha.x, alpha.y))).x;
    b.multiple_color = ggx_multiple_scattering_color(fresnel_conductor_average(b.eta, b.k), b.average);
#endif
    return b;
}

#if CONDUCTOR_COMPENSATION
// What single scattering loses towards w: the deficit of the isotropic surface as wide along w.
float conductor_deficit(Conductor b, vec3 w) {
    vec2 xy = b.ggx.alpha * w.xy;
    return ggx_albedo_at(w.z, sqrt(dot(xy, xy) + b.ggx.alpha.x * b.ggx.alpha.y * w.z * w.z)).x;
}
#endif

// With the facet given, since sampling knows it better than wo + wi tell; cos_h = wo.h. wo.z, wi.z > 0.
BsdfValue conductor_value(Conductor b, vec3 wo, vec3 wi, vec3 h, float cos_h) {
    vec2 facet = ggx_reflection(b.ggx, wo, wi, h);
    BsdfValue v = BsdfValue(fresnel_conductor(cos_h, b.eta, b.k) * facet.x, facet.y);
#if CONDUCTOR_COMPENSATION
    float lost_o = b.is_compensated ? conductor_deficit(b, wo) : 0.0;
    float lost_i = conductor_deficit(b, wi);
    v.value += b.multiple_color * ggx_multiple_scattering(lost_o, lost_i, b.average, wi.z);
    v.pdf = v.pdf * (1.0 - lost_o) + lost_o * (INV_PI * wi.z);
#endif
    return v;
}

BsdfValue conductor_eval_pdf(Conductor b, vec3 wo, vec3 wi) {
    bool is_seen = wo.z > 0.0 && wi.z > 0.0 && !b.ggx.is_smooth;
    vec3 h = wo + wi;
    BsdfValue v = conductor_value(b, wo, wi, ggx_half(h), min(0.5 * length(h), 1.0));
    v.value = is_seen ? v.value : Spectrum(0.0);
    v.pdf = is_seen ? v.pdf : 0.0;
    return v;
}

Spectrum conductor_eval(Conductor b, vec3 wo, vec3 wi) {
    return conductor_eval_pdf(b, wo, wi).value;
}

float conductor_pdf(Conductor b, vec3 wo, vec3 wi) {
    return conductor_eval_pdf(b, wo, wi).pdf;
}

BsdfSample conductor_sample(Conductor b, vec3 wo, uint choice, vec2 u) {
    BsdfSample s = bsdf_sample_none();
    vec3 h = b.ggx.is_smooth ? vec3(0.0, 0.0, 1.0) : ggx_sample_visible(b.ggx, wo, u);
    float cos_h = clamp(dot(wo, h), 0.0, 1.0);
    s.wi = ggx_reflect(wo, h);
#if CONDUCTOR_COMPENSATION
    bool is_multiple = b.is_compensated && bsdf_is_chosen(choice, conductor_deficit(b, wo));
    s.wi = is_multiple ? cosine_hemisphere(u) : s.wi;
    vec3 v_h = wo + s.wi;
    h = is_multiple ? ggx_half(v_h) : h;
    cos_h = is_multiple ? min(0.5 * length(v_h), 1.0) : cos_h;
#endif
    BsdfValue v = conductor_value(b, wo, s.wi, h, cos_h);
    bool is_seen = wo.z > 0.0 && s.wi.z > 0.0 && v.pdf > 0.0;
#if CONDUCTOR_COMPENSATION
    Spectrum weight = v.value / v.pdf;
#else
    Spectrum weight = fresnel_conductor(cos_h, b.eta, b.k) * ggx_g2_over_g1(b.ggx, wo, s.wi);
#endif
    weight = b.ggx.is_smooth ? fresnel_conductor(cos_h, b.eta, b.k) : weight;
    s.weight = is_seen ? weight : Spectrum(0.0);
    s.pdf = is_seen ? (b.ggx.is_smooth ? 1.0 : v.pdf) : 0.0;
    s.flags = b.ggx.is_smooth ? SAMPLE_DELTA : 0u;
    return s;
}

Spectrum conductor_albedo(Conductor b) {
    return fresnel_conductor(1.0, b.eta, b.k);
}

bool conductor_is_delta(Conductor b) {
    return b.ggx.is_smooth;
}
