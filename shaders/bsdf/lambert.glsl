// Lambertian reflection, f = rho/pi; see src/bsdf/lambert.rs.
struct Lambert {
    Spectrum albedo;
};

Lambert lambert_params(Spectrum albedo) {
    return Lambert(albedo);
}

Spectrum lambert_eval(Lambert b, vec3 wo, vec3 wi) {
    bool is_reflection = wo.z > 0.0 && wi.z > 0.0;
    return is_reflection ? b.albedo * (INV_PI * wi.z) : Spectrum(0.0);
}

float lambert_pdf(Lambert b, vec3 wo, vec3 wi) {
    bool is_reflection = wo.z > 0.0 && wi.z > 0.0;
    return is_reflection ? INV_PI * wi.z : 0.0;
}

BsdfSample lambert_sample(Lambert b, vec3 wo, uint choice, vec2 u) {
    BsdfSample s = bsdf_sample_none();
    s.wi = cosine_hemisphere(u);
    s.pdf = lambert_pdf(b, wo, s.wi);
    s.weight = s.pdf > 0.0 ? b.albedo : Spectrum(0.0);
    return s;
}

Spectrum lambert_albedo(Lambert b) {
    return b.albedo;
}

bool lambert_is_delta(Lambert b) {
    return false;
}
