// A smooth pane without thickness, R = 2F/(1+F), the rest straight on; see src/bsdf/thin_dielectric.rs.
struct ThinDielectric {
    float eta;
    Spectrum tint;
};

ThinDielectric thin_dielectric_params(float eta, Spectrum tint) {
    return ThinDielectric(eta, tint);
}

Spectrum thin_dielectric_eval(ThinDielectric b, vec3 wo, vec3 wi) {
    return Spectrum(0.0);
}

float thin_dielectric_pdf(ThinDielectric b, vec3 wo, vec3 wi) {
    return 0.0;
}

BsdfSample thin_dielectric_sample(ThinDielectric b, vec3 wo, uint choice, vec2 u) {
    BsdfSample s = bsdf_sample_none();
    vec3 f = fresnel_dielectric(min(abs(wo.z), 1.0), b.eta);
    float r = 2.0 * f.x / (1.0 + f.x);
    bool is_reflected = bsdf_is_chosen(choice, r);
    s.wi = is_reflected ? vec3(-wo.xy, wo.z) : -wo;
    s.pdf = is_reflected ? r : f.z / (1.0 + f.x);
    s.pdf = wo.z != 0.0 ? s.pdf : 0.0;
    s.weight = s.pdf > 0.0 ? (is_reflected ? Spectrum(1.0) : b.tint) : Spectrum(0.0);
    s.flags = SAMPLE_DELTA | (is_reflected ? 0u : SAMPLE_TRANSMISSION);
    return s;
}

Spectrum thin_dielectric_albedo(ThinDielectric b) {
    return b.tint;
}

bool thin_dielectric_is_delta(ThinDielectric b) {
    return true;
}
