// Lookup of the table "dielectric_deficit": see src/bsdf/dielectric_albedo.rs for what it holds and why in these coordinates.
// Rows [(e * 15 + j) * 24 + i]: the deficits on the side of the lower and of the higher index at alpha row j, then at j + 1.
// After them [e * 80 + n]: averages over alpha^2 at the two ends of interval n.
const uint DIELECTRIC_ALBEDO_INDICES = 17u;
const uint DIELECTRIC_ALBEDO_ALPHA = 16u;
const uint DIELECTRIC_ALBEDO_X = 24u;
const uint DIELECTRIC_ALBEDO_OCTAVES = 10u;
const uint DIELECTRIC_ALBEDO_STEPS = 80u;
const float DIELECTRIC_ALBEDO_INDEX_STEP = 0.05590169943749474;  // sqrt(1/5) / 8
const float DIELECTRIC_ALBEDO_MIN_ROOT = 0.03162277660168379;

// Place of an index n >= 1 among the nodes.
float dielectric_albedo_index(float n) {
    return min(sqrt((n - 1.0) / (n + 1.0)) / DIELECTRIC_ALBEDO_INDEX_STEP, float(DIELECTRIC_ALBEDO_INDICES - 1u));
}

// Deficits at one cosine, on the side of the lower index and of the higher. `rest`: 1 - mu, which a direction's x and y know better.
vec2 dielectric_albedo_at(float mu, float rest, float alpha, float index) {
    float a = clamp(alpha, DIELECTRIC_ALBEDO_MIN_ROOT * DIELECTRIC_ALBEDO_MIN_ROOT, 1.0);
    const float cells = float(DIELECTRIC_ALBEDO_X - 1u);
    // From either end, as in bsdf/ggx_albedo.glsl: near x = 1 the deficit is a millionth of its neighbour.
    float x = min(mu * (1.0 + a) / (mu + a), 1.0) * (cells * cells);
    float beyond = clamp(a * rest / (mu + a), 0.0, 1.0) * (cells * cells);
    float y = max((sqrt(a) - DIELECTRIC_ALBEDO_MIN_ROOT)
        * (float(DIELECTRIC_ALBEDO_ALPHA - 1u) / (1.0 - DIELECTRIC_ALBEDO_MIN_ROOT)), 0.0);
    uint i = min(uint(sqrt(x)), DIELECTRIC_ALBEDO_X - 2u);
    uint j = min(uint(y), DIELECTRIC_ALBEDO_ALPHA - 2u);
    uint e = min(uint(index), DIELECTRIC_ALBEDO_INDICES - 2u);
    float width = float(2u * i + 1u);
    float fx = clamp((x - float(i * i)) / width, 0.0, 1.0);
    float gx = clamp((beyond - (cells * cells - float((i + 1u) * (i + 1u)))) / width, 0.0, 1.0);
    bool is_far = x > beyond;
    vec2 along_x = vec2(is_far ? gx : 1.0 - fx, is_far ? 1.0 - gx : fx);
    uint row = (e * (DIELECTRIC_ALBEDO_ALPHA - 1u) + j) * DIELECTRIC_ALBEDO_X + i;
    const uint next = (DIELECTRIC_ALBEDO_ALPHA - 1u) * DIELECTRIC_ALBEDO_X;
    vec4 low = uintBitsToFloat(dielectric_deficit_row(row)) * along_x.x
        + uintBitsToFloat(dielectric_deficit_row(row + 1u)) * along_x.y;
    vec4 high = uintBitsToFloat(dielectric_deficit_row(row + next)) * along_x.x
        + uintBitsToFloat(dielectric_deficit_row(row + next + 1u)) * along_x.y;
    vec4 v = mix(low, high, clamp(index - float(e), 0.0, 1.0));
    return mix(v.xy, v.zw, clamp(y - float(j), 0.0, 1.0));
}

// Their hemispherical averages. The exponent of alpha is the octave and its mantissa the place there: no logarithm.
vec2 dielectric_albedo_average(float alpha, float index) {
    float a = clamp(alpha, DIELECTRIC_ALBEDO_MIN_ROOT * DIELECTRIC_ALBEDO_MIN_ROOT, ONE_MINUS_EPS);
    uint bits = floatBitsToUint(a);
    uint n = (bits >> 20) - ((127u - DIELECTRIC_ALBEDO_OCTAVES) << 3);
    float f = float(bits & 0xfffffu) * 9.5367431640625e-07;
    uint e = min(uint(index), DIELECTRIC_ALBEDO_INDICES - 2u);
    const uint first = DIELECTRIC_ALBEDO_INDICES * (DIELECTRIC_ALBEDO_ALPHA - 1u) * DIELECTRIC_ALBEDO_X;
    uint row = first + e * DIELECTRIC_ALBEDO_STEPS + n;
    vec4 v = mix(uintBitsToFloat(dielectric_deficit_row(row)),
                 uintBitsToFloat(dielectric_deficit_row(row + DIELECTRIC_ALBEDO_STEPS)), clamp(index - float(e), 0.0, 1.0));
    return mix(v.xy, v.zw, f) * (a * a);
}
