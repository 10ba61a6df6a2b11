// Maps from [0,1)^2 to discs, directions and triangles, each with its density and its inverse. Twin src/math/warp.rs.

// Unit square to unit disc, area to area (Shirley and Chiu 1997, in the two-case form of Cline).
vec2 concentric_disk(vec2 u) {
    vec2 p = 2.0 * u - 1.0;
    bool is_wide = abs(p.x) > abs(p.y);
    float r = is_wide ? p.x : p.y;
    float other = is_wide ? p.y : p.x;
    float phi = r != 0.0 ? QUARTER_PI * (other / r) : 0.0;
    float s;
    float c;
    m_sincos(phi, s, c);
    // Beyond the diagonals the angle is pi/2 - phi.
    return r * (is_wide ? vec2(c, s) : vec2(s, c));
}

vec2 concentric_disk_inverse(vec2 d) {
    bool is_wide = abs(d.x) > abs(d.y);
    float major = is_wide ? d.x : d.y;
    float minor = is_wide ? d.y : d.x;
    float r = major < 0.0 ? -length(d) : length(d);
    float phi = m_atan2(major < 0.0 ? -minor : minor, abs(major));
    float other = r * (phi * 1.27323954473516268615);
    return 0.5 + 0.5 * (is_wide ? vec2(r, other) : vec2(other, r));
}

// Density cos/pi about +z (Malley). z = sqrt((1-r)(1+r)), r along the square's larger half axis: 1 - x^2 - y^2 cancels.
vec3 cosine_hemisphere(vec2 u) {
    vec2 p = abs(2.0 * u - 1.0);
    float r = max(p.x, p.y);
    return vec3(concentric_disk(u), sqrt((1.0 - r) * (1.0 + r)));
}

float cosine_hemisphere_pdf(float cos_theta) {
    return max(cos_theta, 0.0) * INV_PI;
}

vec2 cosine_hemisphere_inverse(vec3 d) {
    return concentric_disk_inverse(d.xy);
}

// (z, phi) to a direction; `radius` is sqrt(1 - z^2), which each caller computes without cancellation.
vec3 direction_from_z(float z, float radius, float turn) {
    float s;
    float c;
    m_sincos(TWO_PI * turn, s, c);
    return vec3(radius * c, radius * s, z);
}

// Angle about +z as a fraction of a turn, in [0,1).
float turn_of(vec2 d) {
    float t = m_atan2(d.y, d.x) * INV_TWO_PI;
    return min(t < 0.0 ? t + 1.0 : t, ONE_MINUS_EPS);
}

// z = 1 - u.x, so that z is never 0 for u < 1.
vec3 uniform_hemisphere(vec2 u) {
    return direction_from_z(1.0 - u.x, sqrt(u.x * (2.0 - u.x)), u.y);
}

float uniform_hemisphere_pdf(float cos_theta) {
    return cos_theta > 0.0 ? INV_TWO_PI : 0.0;
}

vec2 uniform_hemisphere_inverse(vec3 d) {
    return vec2(dot(d.xy, d.xy) / (1.0 + d.z), turn_of(d.xy));
}

vec3 uniform_sphere(vec2 u) {
    return direction_from_z(1.0 - 2.0 * u.x, 2.0 * sqrt(u.x * (1.0 - u.x)), u.y);
}

float uniform_sphere_pdf() {
    return 0.5 * INV_TWO_PI;
}

vec2 uniform_sphere_inverse(vec3 d) {
    return vec2(0.5 - 0.5 * d.z, turn_of(d.xy));
}

// Directions within a cone about +z; `one_minus_cos` is that of its half angle, kept as is for small cones.
vec3 uniform_cone(vec2 u, float one_minus_cos) {
    float h = u.x * one_minus_cos;
    return direction_from_z(1.0 - h, sqrt(h * (2.0 - h)), u.y);
}

float uniform_cone_pdf(float one_minus_cos) {
    return INV_TWO_PI / one_minus_cos;
}

vec2 uniform_cone_inverse(vec3 d, float one_minus_cos) {
    float h = d.z > 0.0 ? dot(d.xy, d.xy) / (1.0 + d.z) : 1.0 - d.z;
    return vec2(min(h / one_minus_cos, ONE_MINUS_EPS), turn_of(d.xy));
}

// Barycentric weights of vertices 1 and 2, uniform over the triangle: the square's halves folded at the diagonal
// towards the lower corner (Heitz 2019, "A Low-Distortion Map Between Triangle and Square"). Density 1/area.
vec2 uniform_triangle(vec2 u) {
    return u.y > u.x ? vec2(0.5 * u.x, u.y - 0.5 * u.x) : vec2(u.x - 0.5 * u.y, 0.5 * u.y);
}

vec2 uniform_triangle_inverse(vec2 b) {
    return b.y > b.x ? vec2(2.0 * b.x, b.y + b.x) : vec2(b.x + b.y, 2.0 * b.y);
}
