// Image textures: own bilinear filter over packed pages; formats and conventions in src/texture/image.rs.
// Tables `textures` (TextureRecord) and `texels` (4 RGBA8, 2 RGBA16 or 2 RGBA16F texels a row). Footprints: src/texture/mip.rs. Texel centres at (i + 0.5) / size,
// v down from the top row. Wrap per axis: 0 repeat, 1 mirror, 2 clamp. A coordinate that is NaN or infinite reads as 0.

// Columns (or rows) left and right of a coordinate, and the weight of the second.
struct TextureTap {
    uint first;
    uint second;
    float weight;
};

TextureTap texture_tap(float u, uint size, uint wrap, bool is_nearest) {
    u = abs(u) < INFINITY ? u : 0.0;
    float at = u - floor(u);
#if TEXTURE_HAS_MIRROR
    // precise: regrouped with the 1 below, a large u would lose it (found by probe row texture_image).
    precise float two = u - 2.0 * floor(0.5 * u);
    at = wrap == 1u ? 1.0 - abs(two - 1.0) : at;
#endif
#if TEXTURE_HAS_CLAMP
    at = wrap == 2u ? clamp(u, 0.0, 1.0) : at;
#endif
    float x = at * float(size);
    float left = floor(x - 0.5);
    TextureTap tap;
    tap.weight = (x - 0.5) - left;
    int last = int(size) - 1;
    // In -1..=last, and one more.
    int i = int(left);
    int j = i + 1;
    bool is_repeat = wrap == 0u;
    tap.first = uint(i < 0 ? (is_repeat ? last : 0) : min(i, last));
    tap.second = uint(j > last ? (is_repeat ? 0 : last) : j);
#if TEXTURE_HAS_NEAREST
    uint nearest = uint(min(int(x), last));
    tap.first = is_nearest ? nearest : tap.first;
    tap.second = is_nearest ? nearest : tap.second;
    tap.weight = is_nearest ? 0.0 : tap.weight;
#endif
    return tap;
}

#if TEXTURE_HAS_SRGB
// IEC 61966-2-1 decode of code values in [0,1]: with x = (v + 0.055) / 1.055, x^2.4 = x P(sqrt x). Remez fit of z^2.8 on
// [0.3, 1], relative error 2^-23.3; twelve of these a lookup are cheaper than twelve fetches from a table.
vec3 texture_srgb_decode(vec3 v) {
    vec3 x = (v + 0.055) * 0.94786729857819905213;
    vec3 z = sqrt(x);
    vec3 p = z * 0.013525989837944508 - 0.07473208010196686;
    p = p * z + 0.19138513505458832;
    p = p * z - 0.33466973900794983;
    p = p * z + 1.1200077533721924;
    p = p * z + 0.09130796790122986;
    p = p * z - 0.007164723239839077;
    p = p * z + 0.00033978570718318224;
    return mix(x * p, v * 0.077399380804953560372, lessThanEqual(v, vec3(0.04045)));
}
#endif

vec4 texture_texel(TextureRecord t, uint x, uint y) {
    uint index = y * t.width + x;
    bool has_pairs = false;
#if TEXTURE_HAS_HALF || TEXTURE_HAS_WIDE
    has_pairs = (t.flags & (TEXTURE_HALF | TEXTURE_WIDE)) != 0u;
#endif
    uvec4 row = texels_row(t.first_row + (has_pairs ? index >> 1 : index >> 2));
    uint word = row[index & 3u];
    vec4 v = vec4((uvec4(word) >> uvec4(0u, 8u, 16u, 24u)) & 255u) * (1.0 / 255.0);
#if TEXTURE_HAS_HALF || TEXTURE_HAS_WIDE
    uvec2 pair = (index & 1u) == 0u ? row.xy : row.zw;
#endif
#if TEXTURE_HAS_WIDE
    vec4 wide = vec4(pair.x & 65535u, pair.x >> 16, pair.y & 65535u, pair.y >> 16) * (1.0 / 65535.0);
    v = (t.flags & TEXTURE_WIDE) != 0u ? wide : v;
#endif
#if TEXTURE_HAS_SRGB
    v.rgb = (t.flags & TEXTURE_SRGB) != 0u ? texture_srgb_decode(v.rgb) : v.rgb;
#endif
#if TEXTURE_HAS_HALF
    v = (t.flags & TEXTURE_HALF) != 0u ? vec4(unpackHalf2x16(pair.x), unpackHalf2x16(pair.y)) : v;
#endif
    return v;
}

vec4 texture_filtered(TextureRecord t, vec2 uv, bool is_nearest) {
    TextureTap x = texture_tap(uv.x, t.width, (t.flags >> TEXTURE_WRAP_U_SHIFT) & 3u, is_nearest);
    TextureTap y = texture_tap(uv.y, t.height, (t.flags >> TEXTURE_WRAP_V_SHIFT) & 3u, is_nearest);
    vec4 a = texture_texel(t, x.first, y.first);
    vec4 b = texture_texel(t, x.second, y.first);
    vec4 c = texture_texel(t, x.first, y.second);
    vec4 d = texture_texel(t, x.second, y.second);
    vec4 top = a + x.weight * (b - a);
    vec4 bottom = c + x.weight * (d - c);
    return top + y.weight * (bottom - top);
}

// Linear RGBA; alpha is never sRGB-encoded.
vec4 texture_image(uint texture, vec2 uv) {
    TextureRecord t = TextureRecord_load_textures(texture);
    return texture_filtered(t, uv, (t.flags & TEXTURE_NEAREST) != 0u);
}

#if TEXTURE_HAS_MIPS
TextureRecord texture_level(TextureRecord t, uint level) {
    // The rows before level 0 say where the others begin; that of a texture without levels is its own.
    bool has_levels = (t.flags & TEXTURE_MIPS) != 0u;
    uvec4 offsets = texels_row(has_levels ? t.first_row - 4u + (level >> 2) : t.first_row);
    TextureRecord r = t;
    r.width = max(t.width >> level, 1u);
    r.height = max(t.height >> level, 1u);
    r.first_row = t.first_row + (has_levels ? offsets[level & 3u] : 0u);
    return r;
}

// Linear RGBA of a footprint of `area` in the unit square of uv.
vec4 texture_image_footprint(uint texture, vec2 uv, float area) {
    TextureRecord t = TextureRecord_load_textures(texture);
    float texels = area * float(t.width) * float(t.height);
    // NaN reads level 0.
    bool is_large = texels > 1.0;
    bool is_nearest = (t.flags & (is_large ? TEXTURE_MIN_NEAREST : TEXTURE_NEAREST)) != 0u;
    float last = float(findMSB(max(t.width, t.height)));
    float level = min(0.72134752044448170368 * m_log(is_large ? min(texels, 1e12) : 1.0), last);  // log2(texels) / 2
    level = (t.flags & TEXTURE_MIP_NEAREST) != 0u ? floor(level + 0.5) : level;
    level = (t.flags & TEXTURE_MIPS) != 0u ? level : 0.0;
    float lower = floor(level);
    vec4 a = texture_filtered(texture_level(t, uint(lower)), uv, is_nearest);
    vec4 b = texture_filtered(texture_level(t, uint((t.flags & TEXTURE_MIPS) != 0u ? min(lower + 1.0, last) : 0.0)), uv, is_nearest);
    return a + (level - lower) * (b - a);
}
#endif
