// A clear coat over a Lambertian base with all orders of reflection between them; see src/bsdf/plastic.rs.
struct Plastic {
    Spectrum color;
    Spectrum base;    // pi f of the base without the two passages of the coat
    float base_mean;  // its mean over the channels times what the coat lets through on average
    Coat coat;
};

Plastic plastic_params(Spectrum color, float roughness, float eta) {
    Plastic b;
    float n = max(eta, 1.0);
    b.color = clamp(color, Spectrum(0.0), Spectrum(1.0));
    b.coat = coat_new(roughness, sqr((n - 1.0) / (n + 1.0)), 1.0);
    float through = coat_through_average(b.coat);
    // eta^2 - rho (eta^2 - through), as a sum of what is not negative.
    b.base = b.color / (n * n * (Spectrum(1.0) - b.color) + b.color * through);
    b.base_mean = dot(b.base, Spectrum(1.0 / 3.0)) * through;
    return b;
}

// Probabilities of the cosine lobe and of the coat, and what the coat lets through.
vec3 plastic_shares(Plastic b, vec3 wo) {
    vec2 share = coat_shares(b.coat, clamp(wo.z, 0.0, 1.0));
    float cosine = share.x * b.base_mean;
    float sum = cosine + share.y;
    return cosine > 0.0 ? vec3(cosine / sum, share.y / sum, share.x) : vec3(0.0, 1.0, share.x);
}

BsdfValue plastic_value(Plastic b, vec3 shares, vec3 wo, vec3 wi, vec3 h, float cos_h) {
    vec2 facet = b.coat.ggx.is_smooth ? vec2(0.0) : ggx_reflection(b.coat.ggx, wo, wi, h);
    float through = shares.z * coat_shares(b.coat, clamp(wi.z, 0.0, 1.0)).x;
    Spectrum value = b.base * (through * INV_PI * wi.z) + Spectrum(coat_fresnel(b.coat, cos_h) * facet.x);
    return BsdfValue(value, shares.x * INV_PI * wi.z + shares.y * facet.y);
}

BsdfValue plastic_eval_pdf(Plastic b, vec3 wo, vec3 wi) {
    bool is_seen = wo.z > 0.0 && wi.z > 0.0;
    vec3 h = wo + wi;
    BsdfValue v = plastic_value(b, plastic_shares(b, wo), wo, wi, ggx_half(h), min(0.5 * length(h), 1.0));
    return BsdfValue(is_seen ? v.value : Spectrum(0.0), is_seen ? v.pdf : 0.0);
}

Spectrum plastic_eval(Plastic b, vec3 wo, vec3 wi) {
    return plastic_eval_pdf(b, wo, wi).value;
}

float plastic_pdf(Plastic b, vec3 wo, vec3 wi) {
    return plastic_eval_pdf(b, wo, wi).pdf;
}

BsdfSample plastic_sample(Plastic b, vec3 wo, uint choice, vec2 u) {
    BsdfSample s = bsdf_sample_none();
    vec3 shares = plastic_shares(b, wo);
    bool is_cosine = bsdf_is_chosen(choice, shares.x);
    vec3 h = b.coat.ggx.is_smooth ? vec3(0.0, 0.0, 1.0) : ggx_sample_visible(b.coat.ggx, wo, u);
    float cos_h = clamp(dot(wo, h), 0.0, 1.0);
    s.wi = is_cosine ? cosine_hemisphere(u) : ggx_reflect(wo, h);
    vec3 v_h = wo + s.wi;
    h = is_cosine ? ggx_half(v_h) : h;
    cos_h = is_cosine ? min(0.5 * length(v_h), 1.0) : cos_h;
    BsdfValue v = plastic_value(b, shares, wo, s.wi, h, cos_h);
    bool is_delta = !is_cosine && b.coat.ggx.is_smooth;
    Spectrum value = is_delta ? Spectrum(coat_fresnel(b.coat, cos_h)) : v.value;
    float pdf = is_delta ? shares.y : v.pdf;
    bool is_kept = wo.z > 0.0 && s.wi.z > 0.0 && pdf > 0.0;
    s.weight = is_kept ? value / pdf : Spectrum(0.0);
    s.pdf = is_kept ? pdf : 0.0;
    s.flags = is_delta ? SAMPLE_DELTA : 0u;
    return s;
}

Spectrum plastic_albedo(Plastic b) {
    return b.color;
}

bool plastic_is_delta(Plastic b) {
    return b.coat.ggx.is_smooth && max_component(b.color) == 0.0;
}
