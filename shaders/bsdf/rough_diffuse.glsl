// EON rough diffuse reflection; the paper is named in src/bsdf/rough_diffuse.rs. What the single lobe loses, 1 - E, is
// A sigma (c - G/pi) with c = 1/2 - 2/(3 pi): no difference from 1 is left, and sigma cancels against its own average.
const float EON_GRAZING = 0.28779340921080814;  // 1/2 - 2/(3 pi)
const float EON_AVERAGE = 0.0724882124567562;  // 2/3 - 28/(15 pi)

struct RoughDiffuse {
    Spectrum color;
    Spectrum multiple;  // the whole factor of (c - G(o)/pi) (c - G(i)/pi) cos
    float a;
    float sigma;
};

RoughDiffuse rough_diffuse_params(Spectrum color, float roughness) {
    RoughDiffuse b;
    b.color = clamp(color, Spectrum(0.0), Spectrum(1.0));
    b.sigma = clamp(roughness, 0.0, 1.0);
    b.a = 1.0 / (1.0 + EON_GRAZING * b.sigma);
    float lost = b.a * b.sigma * (EON_GRAZING - EON_AVERAGE);
    Spectrum color2 = b.color * b.color * (1.0 - lost);
    float scale = INV_PI * b.a * b.sigma / (EON_GRAZING - EON_AVERAGE);
    b.multiple = color2 * scale / (Spectrum(1.0) - b.color * lost);
    return b;
}

// (1 - E) / (A sigma); tan (1 - sin^3) as cos (1 + sin + sin^2) / (1 + sin).
float rough_diffuse_lost(float mu) {
    float s2 = (1.0 - mu) * (1.0 + mu);
    float s = safe_sqrt(s2);
    float g = s * ((m_acos(mu) - s * mu) + (2.0 / 3.0) * (mu * (1.0 + s + s2) / (1.0 + s) - 1.0));
    return max(EON_GRAZING - INV_PI * g, 0.0);
}

Spectrum rough_diffuse_eval(RoughDiffuse b, vec3 wo, vec3 wi) {
    float s = dot(wo.xy, wi.xy);
    // |cos wi| / t comes first: at most 1 where light comes from wo's side.
    float side = b.sigma * s * (s > 0.0 ? wi.z / max(wo.z, wi.z) : wi.z);
    Spectrum value = b.color * (INV_PI * b.a * max(wi.z + side, 0.0));
    value += b.multiple * (rough_diffuse_lost(min(wo.z, 1.0)) * rough_diffuse_lost(min(wi.z, 1.0)) * wi.z);
    bool is_reflection = wo.z > 0.0 && wi.z > 0.0;
    return is_reflection ? value : Spectrum(0.0);
}

float rough_diffuse_uniform(RoughDiffuse b, vec3 wo) {
    return 0.5 * b.sigma * min(length(wo.xy), 1.0);
}

float rough_diffuse_pdf(RoughDiffuse b, vec3 wo, vec3 wi) {
    bool is_reflection = wo.z > 0.0 && wi.z > 0.0;
    float p = rough_diffuse_uniform(b, wo);
    return is_reflection ? INV_PI * ((1.0 - p) * wi.z + 0.5 * p) : 0.0;
}

BsdfSample rough_diffuse_sample(RoughDiffuse b, vec3 wo, uint choice, vec2 u) {
    BsdfSample s = bsdf_sample_none();
    bool is_uniform = bsdf_is_chosen(choice, rough_diffuse_uniform(b, wo));
    s.wi = is_uniform ? uniform_hemisphere(u) : cosine_hemisphere(u);
    s.pdf = rough_diffuse_pdf(b, wo, s.wi);
    s.weight = s.pdf > 0.0 ? rough_diffuse_eval(b, wo, s.wi) / s.pdf : Spectrum(0.0);
    return s;
}

Spectrum rough_diffuse_albedo(RoughDiffuse b) {
    return b.color;
}

bool rough_diffuse_is_delta(RoughDiffuse b) {
    return false;
}
