// Light from infinitely far away: a lat-long image (SKY_IMAGE 1) or the same radiance everywhere (0). Maths in src/light/sky.rs.
// Reads tables sky (one SkyRecord), and with an image sky_texels and sky_alias. After core/ and light/alias.glsl.
struct SkySample {
    vec3 wi;
    Spectrum radiance;
    float pdf;  // 1/sr; 0 means no sample
};

#if SKY_IMAGE
// The sky is turned by +angle about y, rotation = (cos, sin); this goes from the world to the image's frame.
vec3 sky_from_world(SkyRecord sky, vec3 d) {
    vec2 r = sky.rotation;
    return vec3(r.x * d.x - r.y * d.z, d.y, r.x * d.z + r.y * d.x);
}

vec3 sky_to_world(SkyRecord sky, vec3 d) {
    vec2 r = sky.rotation;
    return vec3(r.x * d.x + r.y * d.z, d.y, r.x * d.z - r.y * d.x);
}

// Place in the image in texels, x in [0, W], y in [0, H]. atan2 of (sin, cos) theta: acos loses half the digits at the poles.
vec2 sky_position(SkyRecord sky, vec3 world) {
    vec3 d = sky_from_world(sky, world);
    float u = 0.5 + m_atan2(d.x, -d.z) * INV_TWO_PI;
    float v = m_atan2(length(d.xz), d.y) * INV_PI;
    return vec2(u * float(sky.width), v * float(sky.height));
}

Spectrum sky_texel(SkyRecord sky, int column, int row) {
    int width = int(sky.width);
    column = column < 0 ? column + width : (column >= width ? column - width : column);
    row = clamp(row, 0, int(sky.height) - 1);
    return SkyTexelRecord_load_sky_texels(uint(row * width + column)).radiance;
}

// Bilinear between texel centres, wrapping in u, clamped in v.
Spectrum sky_radiance(vec3 d) {
    SkyRecord sky = SkyRecord_load_sky(0u);
    vec2 x = sky_position(sky, d) - 0.5;
    vec2 corner = floor(x);
    vec2 t = x - corner;
    int i = int(corner.x);
    int j = int(corner.y);
    Spectrum upper = mix(sky_texel(sky, i, j), sky_texel(sky, i + 1, j), t.x);
    Spectrum lower = mix(sky_texel(sky, i, j + 1), sky_texel(sky, i + 1, j + 1), t.x);
    return sky.scale * mix(upper, lower, t.y);
}

float sky_pdf(vec3 d) {
    SkyRecord sky = SkyRecord_load_sky(0u);
    uvec2 cell = min(uvec2(sky_position(sky, d)), uvec2(sky.width, sky.height) - 1u);
    return SkyTexelRecord_load_sky_texels(cell.y * sky.width + cell.x).cell_pdf;
}

#if HAS_LIGHT_SKY
uint alias_choose_sky(uint index_word, uint fraction_word, uint cell_count) {
    uint entry = alias_entry(index_word, cell_count);
    return alias_pick(sky_alias_row(entry >> 1), entry, fraction_word);
}

// Uniform in solid angle over a cell, in the image's frame: s = sin^2(theta/2), counted from the nearer pole, is uniform.
vec3 sky_direction_in_cell(SkyRecord sky, uint column, uint row, vec2 u) {
    bool is_lower = 2u * row >= sky.height;
    float from_pole = float(is_lower ? sky.height - 1u - row : row);
    float half_angle = HALF_PI / float(sky.height);
    float sin0;
    float sin1;
    float unused;
    m_sincos(from_pole * half_angle, sin0, unused);
    m_sincos((from_pole + 1.0) * half_angle, sin1, unused);
    float s = mix(sin0 * sin0, sin1 * sin1, u.y);
    float cos_theta = 1.0 - 2.0 * s;
    float sin_theta = 2.0 * sqrt(s * (1.0 - s));
    float sin_phi;
    float cos_phi;
    m_sincos(TWO_PI * ((float(column) + u.x) / float(sky.width) - 0.5), sin_phi, cos_phi);
    return vec3(sin_theta * sin_phi, is_lower ? -cos_theta : cos_theta, -sin_theta * cos_phi);
}

// `index_word` and `fraction_word` pick the cell, `u` the place in it.
SkySample sky_sample(uint index_word, uint fraction_word, vec2 u) {
    SkyRecord sky = SkyRecord_load_sky(0u);
    uint cell = alias_choose_sky(index_word, fraction_word, sky.width * sky.height);
    uint row = cell / sky.width;
    SkySample s;
    s.wi = sky_to_world(sky, sky_direction_in_cell(sky, cell - row * sky.width, row, u));
    s.radiance = sky_radiance(s.wi);
    s.pdf = SkyTexelRecord_load_sky_texels(cell).cell_pdf;
    return s;
}
#endif
#else
Spectrum sky_radiance(vec3 d) {
    return SkyRecord_load_sky(0u).scale;
}

float sky_pdf(vec3 d) {
    return uniform_sphere_pdf();
}

SkySample sky_sample(uint index_word, uint fraction_word, vec2 u) {
    return SkySample(uniform_sphere(u), SkyRecord_load_sky(0u).scale, uniform_sphere_pdf());
}
#endif

#if IN_KERNEL
// What the sky sends to a path that has left the scene.
void sky_light_arriving(inout PathState s) {
    float density = 0.0;
#if HAS_LIGHT_SKY
    // Everything-on has a sky's text in scenes without one: its row is no light's.
    uint light = SkyRecord_load_sky(0u).light;
    density = light != NONE ? sky_pdf(s.ray.d) * light_pmf(s.from, s.from_normal, light) : 0.0;
#endif
    path_gather(s, s.throughput * (sky_radiance(s.ray.d) * emission_weight(s, density)), s.edge, LIGHT_GROUP(SKY_GROUP));
}

#if HAS_LIGHT_SKY
LightSample sky_light_connect(PathState s, LightRecord light, vec3 p, vec2 u) {
    SkySample sky = sky_sample(path_word(s, SKY_INDEX), path_word(s, SKY_FRACTION), u);
    return LightSample(sky.wi, INFINITY, sky.pdf, sky.radiance, NONE, NONE, false);
}
#endif
#endif
