// Lookup of the table "ggx_albedo": see src/bsdf/ggx_albedo.rs for what it holds and why in these coordinates.
// Rows [j * 48 + i], j < 39: (A, q) at node i of alpha row j, and of row j + 1. Then 80 rows: averages over octaves of alpha.
const uint GGX_ALBEDO_X = 48u;
const uint GGX_ALBEDO_ALPHA = 40u;
const uint GGX_ALBEDO_OCTAVES = 10u;
const float GGX_ALBEDO_MIN_ROOT = 0.03162277660168379;

// x: deficit A = 1 - E0 of single scattering with F = 1; y: albedo B with F = (1 - cos)^5; z: 1 - B. B vanishes towards the
// pole, 1 - B towards grazing, and each is a factor of something: so each is kept with its own digits.
vec3 ggx_albedo_at(float mu, float alpha) {
    float a = clamp(alpha, GGX_ALBEDO_MIN_ROOT * GGX_ALBEDO_MIN_ROOT, 1.0);
    const float cells = float(GGX_ALBEDO_X - 1u);
    // From either end: x near 0, 1 - x = a (1 - mu) / (mu + a) near 1, where A is a millionth of its neighbour.
    float x = min(mu * (1.0 + a) / (mu + a), 1.0) * (cells * cells);
    float beyond = clamp(a * (1.0 - mu) / (mu + a), 0.0, 1.0) * (cells * cells);
    float y = max((sqrt(a) - GGX_ALBEDO_MIN_ROOT) * (float(GGX_ALBEDO_ALPHA - 1u) / (1.0 - GGX_ALBEDO_MIN_ROOT)), 0.0);
    uint i = min(uint(sqrt(x)), GGX_ALBEDO_X - 2u);
    uint j = min(uint(y), GGX_ALBEDO_ALPHA - 2u);
    vec4 left = uintBitsToFloat(ggx_albedo_row(j * GGX_ALBEDO_X + i));
    vec4 right = uintBitsToFloat(ggx_albedo_row(j * GGX_ALBEDO_X + i + 1u));
    float width = float(2u * i + 1u);
    // Rounding may put the place a few eps outside its cell, and the deficit below 0: then a density would turn negative.
    float fx = clamp((x - float(i * i)) / width, 0.0, 1.0);
    float gx = clamp((beyond - (cells * cells - float((i + 1u) * (i + 1u)))) / width, 0.0, 1.0);
    bool is_far = x > beyond;
    vec4 v = left * (is_far ? gx : 1.0 - fx) + right * (is_far ? 1.0 - gx : fx);
    vec2 at = mix(v.xy, v.zw, y - float(j));
    float c = clamp(at.y * (mu + a), 0.0, 1.0);
    float e0 = 1.0 - at.x;
    return vec3(at.x, e0 * pow5(1.0 - c), min(at.x + e0 * one_minus_pow5(c), 1.0));
}

// Hemispherical averages of A and B (not 1 - B). The exponent of alpha is the octave and its mantissa the place there: no logarithm.
vec2 ggx_albedo_average(float alpha) {
    float a = clamp(alpha, GGX_ALBEDO_MIN_ROOT * GGX_ALBEDO_MIN_ROOT, ONE_MINUS_EPS);
    uint bits = floatBitsToUint(a);
    uint n = (bits >> 20) - ((127u - GGX_ALBEDO_OCTAVES) << 3);
    float f = float(bits & 0xfffffu) * 9.5367431640625e-07;
    vec4 row = uintBitsToFloat(ggx_albedo_row((GGX_ALBEDO_ALPHA - 1u) * GGX_ALBEDO_X + n));
    return mix(row.xy, row.zw, f) * vec2(a * a, 1.0);
}

// Kulla and Conty 2017, f |cos wi| for F = 1, from the deficits at o and i and their average.
float ggx_multiple_scattering(float deficit_o, float deficit_i, float average, float cos_i) {
    return average > 0.0 ? deficit_o * deficit_i * cos_i * INV_PI / average : 0.0;
}

// Its colour: orders >= 2 of the facets' average reflectance (Hill 2018).
Spectrum ggx_multiple_scattering_color(Spectrum fresnel_average, float average) {
    return fresnel_average * fresnel_average * (1.0 - average) / (Spectrum(1.0) - fresnel_average * average);
}
