// GGX facets in f32, src/bsdf/ggx.rs names the papers. With s(w) = sqrt(ax^2 x^2 + ay^2 y^2 + z^2), Smith's terms become
// G1 = 2z/(z+s), G2 = 2 zo zi/(zo si + zi so): the cosines cancel against the denominators before anything is divided.

// alpha below which a surface is a mirror, and the least alpha of the narrower axis (src/bsdf/ggx.rs).
const float GGX_SMOOTH_ALPHA = 1e-3;
const float GGX_MIN_ALPHA = 1e-4;

struct Ggx {
    vec2 alpha;
    bool is_smooth;
};

Ggx ggx_from_roughness(float roughness, float roughness_y) {
    float x = sqr(clamp(roughness, 0.0, 1.0));
    float y = roughness_y < 0.0 ? x : sqr(min(roughness_y, 1.0));
    return Ggx(max(vec2(x, y), vec2(GGX_MIN_ALPHA)), max(x, y) < GGX_SMOOTH_ALPHA);
}

// 1/(pi ax ay (hx^2/ax^2 + hy^2/ay^2 + hz^2)^2): a sum of squares, not 1 - hz^2.
float ggx_d(Ggx g, vec3 h) {
    vec2 slope = h.xy / g.alpha;
    float s = dot(slope, slope) + h.z * h.z;
    return INV_PI / (g.alpha.x * g.alpha.y * s * s);
}

float ggx_stretch(Ggx g, vec3 w) {
    vec2 xy = g.alpha * w.xy;
    return sqrt(dot(xy, xy) + w.z * w.z);
}

// v to unit length; scaled first, since half vectors at grazing are as short as the cosines.
vec3 ggx_half(vec3 v) {
    vec3 a = abs(v);
    float scale = max_component(a);
    vec3 w = v / (scale > 0.0 ? scale : 1.0);
    float l2 = dot(w, w);
    return l2 > 0.0 ? w * inversesqrt(l2) : vec3(0.0, 0.0, 1.0);
}

// D G2 |zi| / (4 zo zi) and the density of i through the visible normals of o, D G1 / (4 zo); zo, zi > 0.
vec2 ggx_reflection(Ggx g, vec3 o, vec3 i, vec3 h) {
    float d = ggx_d(g, h);
    float so = ggx_stretch(g, o);
    float si = ggx_stretch(g, i);
    return vec2(0.5 * d * i.z / (o.z * si + i.z * so), 0.5 * d / (o.z + so));
}

// G2/G1: what is left of a visible facet's light after masking; zo > 0, zi of either sign.
float ggx_g2_over_g1(Ggx g, vec3 o, vec3 i) {
    float so = ggx_stretch(g, o);
    float zi = abs(i.z);
    return zi * (o.z + so) / (o.z * ggx_stretch(g, i) + zi * so);
}

// Refraction, zo > 0 > zi: without 1-F and 1/eta^2, (f |cos wi|, pdf) of facet h = normalised o + eta i, whose length is l.
vec2 ggx_refraction(Ggx g, vec3 o, vec3 i, vec3 h, float eta, float l) {
    float so = ggx_stretch(g, o);
    float jacobian = abs(dot(i, h)) * sqr(eta / l);
    float seen = 2.0 * ggx_d(g, h) * max(dot(o, h), 0.0) * jacobian;
    float zi = abs(i.z);
    return vec2(seen * zi / (o.z * ggx_stretch(g, i) + zi * so), seen / (o.z + so));
}

// Normal of a facet seen from o, zo > 0 (Dupuy and Benyoub 2023): cap point c of azimuth phi plus w. z of the cap and 1 - z^2 are products. A
// grazing facet is the small sum of nearly opposite c and w: along e = (cos phi, sin phi) it is r + w.e, and
// r^2 - (w.e)^2 = z (2 wz - z) + (w x e)^2 has no difference of numbers near 1. Where z is large that would cancel instead.
vec3 ggx_sample_visible(Ggx g, vec3 o, vec2 u) {
    vec3 w = vec3(g.alpha * o.xy, o.z);
    w *= inversesqrt(dot(w, w));
    float top = 1.0 + w.z;
    float z = (1.0 - u.y) * top;
    float r = sqrt(u.y * top * (z + dot(w.xy, w.xy) / top));
    float s;
    float c;
    m_sincos(TWO_PI * u.x, s, c);
    float along = w.x * c + w.y * s;
    float across = w.y * c - w.x * s;
    bool is_close = along < 0.0 && z < r - along;
    float sum = is_close ? (z * (2.0 * w.z - z) + across * across) / (r - along) : r + along;
    return normalize(vec3(g.alpha * vec2(sum * c - across * s, sum * s + across * c), z));
}

vec3 ggx_reflect(vec3 w, vec3 h) {
    return h * (2.0 * dot(w, h)) - w;
}
