// A clear coat of isotropic GGX facets, present by `weight`, and what it leaves to the surface below; see src/bsdf/coat.rs.
struct Coat {
    Ggx ggx;
    float f0;
    float weight;
};

Coat coat_new(float roughness, float f0, float weight) {
    return Coat(ggx_from_roughness(roughness, -1.0), f0, weight);
}

// Reflectance of a facet, presence included.
float coat_fresnel(Coat c, float cos_h) {
    return c.weight * (c.f0 + (1.0 - c.f0) * pow5(1.0 - cos_h));
}

// x: share of the light from this cosine that goes through, y: that is reflected. Each with its own digits.
vec2 coat_shares(Coat c, float mu) {
    vec3 a = c.ggx.is_smooth ? vec3(0.0, pow5(1.0 - mu), one_minus_pow5(mu)) : ggx_albedo_at(mu, c.ggx.alpha.x);
    return vec2(1.0 - c.weight + c.weight * mix(a.z, a.x, c.f0), c.weight * mix(a.y, 1.0 - a.x, c.f0));
}

// Cosine-weighted average of what goes through.
float coat_through_average(Coat c) {
    vec2 a = c.ggx.is_smooth ? vec2(0.0, 1.0 / 21.0) : ggx_albedo_average(c.ggx.alpha.x);
    return 1.0 - c.weight + c.weight * mix(1.0 - a.y, a.x, c.f0);
}
