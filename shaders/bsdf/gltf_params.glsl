// Parameters of glTF's surface; see src/bsdf/gltf.rs. A part that no material of the scene has is not in the text.

// Clearcoat: index 1.5; and by how much the mean of two passages exceeds the product of their means at most, 1/66 - 1/441.
const float GLTF_COAT_F0 = 0.04;
const float GLTF_COAT_COVARIANCE = 0.0128839414553;

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
#if GLTF_SPECULAR
    float specular;          // f90
    Spectrum tinted_f0;      // over f90; f0 is its largest channel
    Spectrum tint;           // factor on the exact reflectance
#endif
#if GLTF_ANISOTROPY
    vec2 along;              // direction of the wider alpha in the local frame
#endif
#if GLTF_CLEARCOAT
    Coat coat;
    float coat_average;
#endif
};

float gltf_mean(Spectrum c) {
    return dot(c, Spectrum(1.0 / 3.0));
}

#if GLTF_ANISOTROPY
// Unit direction of the wider alpha: r, g of the texture turned by the angle; x where the texture has none.
vec2 gltf_direction(vec2 texel, float angle_rad) {
    vec2 d = 2.0 * texel - 1.0;
    float l = length(d);
    d = l > 1e-3 ? d / l : vec2(1.0, 0.0);
    float s;
    float c;
    m_sincos(angle_rad, s, c);
    return vec2(c * d.x - s * d.y, s * d.x + c * d.y);
}

// Into the frame whose x is the wider alpha, and back.
vec3 gltf_turned(Gltf b, vec3 w) {
    return vec3(b.along.x * w.x + b.along.y * w.y, b.along.x * w.y - b.along.y * w.x, w.z);
}

vec3 gltf_turned_back(Gltf b, vec3 w) {
    return vec3(b.along.x * w.x - b.along.y * w.y, b.along.x * w.y + b.along.y * w.x, w.z);
}
#endif

Gltf gltf_params(Spectrum base_color, float metallic, float roughness, float ior, float transmission, float thin,
                 float khronos_mix, float compensation, float specular, Spectrum specular_color, float anisotropy,
                 float anisotropy_rotation, Spectrum anisotropy_direction, float clearcoat, float clearcoat_roughness) {
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
#if GLTF_SPECULAR
    b.specular = clamp(specular, 0.0, 1.0);
    b.tinted_f0 = min(max(specular_color, Spectrum(0.0)) * b.f0, Spectrum(1.0));
    b.tint = clamp(specular_color, Spectrum(0.0), Spectrum(1.0)) * b.specular;
    b.f0 = max_component(b.tinted_f0);
#endif
    b.ggx = ggx_from_roughness(roughness, -1.0);
#if GLTF_ANISOTROPY
    vec2 alpha = b.ggx.alpha;
    alpha.x += (1.0 - alpha.x) * sqr(clamp(anisotropy * anisotropy_direction.z, 0.0, 1.0));
    b.ggx = Ggx(alpha, alpha.x < GGX_SMOOTH_ALPHA);
    b.along = gltf_direction(anisotropy_direction.xy, anisotropy_rotation);
    b.average = ggx_albedo_average(0.5 * (sqrt(0.5 * dot(alpha, alpha)) + alpha.x));
    b.average = b.ggx.is_smooth ? vec2(0.0, 1.0 / 21.0) : b.average;
#else
    b.average = b.ggx.is_smooth ? vec2(0.0, 1.0 / 21.0) : ggx_albedo_average(b.ggx.alpha.x);
#endif
#if GLTF_CLEARCOAT
    b.coat = coat_new(clearcoat_roughness, GLTF_COAT_F0, clamp(clearcoat, 0.0, 1.0));
    b.coat_average = coat_through_average(b.coat) + b.coat.weight * (GLTF_COAT_COVARIANCE * 1.05);
#endif
    b.is_thin = thin >= 0.5;
    b.is_matched = !b.is_thin && abs(b.ior - 1.0) < 1e-4;
    b.is_khronos = GLTF_KHRONOS_MIX == 1 && khronos_mix >= 0.5;
    b.is_compensated = GLTF_COMPENSATION == 1 && compensation >= 0.5 && !b.is_khronos;
    Spectrum fresnel_average = b.base_color + (Spectrum(1.0) - b.base_color) * (1.0 / 21.0);
    b.multiple_color = b.is_compensated ? ggx_multiple_scattering_color(fresnel_average, b.average.x) : Spectrum(0.0);
    return b;
}
