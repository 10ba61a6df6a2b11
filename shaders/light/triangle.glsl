// A triangle light, uniform in solid angle inside [3e-4, 6.22] sr, uniform in area outside; see src/light/triangle.rs.
// The point on the arc A C' is solved for by half-angle tangents: with phi the arc from A to C' and A' the unit vector across,
// tan(S/2) = tan(phi/2) |A B A'| / (1 + A.B + tan(phi/2) B.A')  (Van Oosterom and Strackee 1983 put into tan(phi/2)), linear in
// tan(phi/2). No angle is subtracted from another, so f32 keeps its digits where Arvo's sum of angles has lost them.
const float TRIANGLE_SOLID_ANGLE_MIN = 3e-4;
const float TRIANGLE_SOLID_ANGLE_MAX = 6.22;

struct TriangleLightSample {
    vec3 wi;
    float distance;
    float pdf;  // 1/sr; 0 means no sample (exactly edge-on)
    float b1;   // weights of vertices 1 and 2
    float b2;
};

// The triangle seen from p, in units of its farthest coordinate, so that nothing overflows.
struct TriangleView {
    vec3 a;
    vec3 e1;
    vec3 e2;
    float size;         // metres a unit
    float volume;       // |a . (e1 x e2)|
    float solid_angle;  // sr
    bool is_solid_angle;
};

TriangleView triangle_view(vec3 p, vec3 v0, vec3 v1, vec3 v2) {
    TriangleView t;
    vec3 a = v0 - p;
    vec3 b = v1 - p;
    vec3 c = v2 - p;
    vec3 m = max(abs(a), max(abs(b), abs(c)));
    t.size = max_component(m);
    float inv = t.size > 0.0 ? 1.0 / t.size : 0.0;
    t.a = a * inv;
    b = b * inv;
    c = c * inv;
    // From the vertices and not from a, b, c, which carry the rounding of p.
    t.e1 = (v1 - v0) * inv;
    t.e2 = (v2 - v0) * inv;
    t.volume = abs(dot(t.a, cross(t.e1, t.e2)));
    float la = length(t.a);
    float lb = length(b);
    float lc = length(c);
    float parallel = la * lb * lc + dot(t.a, b) * lc + dot(b, c) * la + dot(c, t.a) * lb;
    t.solid_angle = 2.0 * m_atan2(t.volume, parallel);
    t.is_solid_angle = t.solid_angle >= TRIANGLE_SOLID_ANGLE_MIN && t.solid_angle <= TRIANGLE_SOLID_ANGLE_MAX;
    return t;
}

// Both densities, for a point at `distance` in units; 2 d^3 / volume is d^2 / (area cos), the same for every point of the plane.
float triangle_view_pdf(TriangleView t, float distance) {
    float by_area = t.volume > 0.0 ? 2.0 * (distance * distance * distance) / t.volume : 0.0;
    by_area = by_area < 1e37 ? by_area : 0.0;
    return t.is_solid_angle ? 1.0 / t.solid_angle : by_area;
}

float triangle_light_pdf(vec3 p, vec3 v0, vec3 v1, vec3 v2, vec3 wi, float distance) {
    TriangleView t = triangle_view(p, v0, v1, v2);
    return triangle_view_pdf(t, t.size > 0.0 ? distance / t.size : 0.0);
}

// Unit vector of v's part perpendicular to the unit n; something finite where there is none.
vec3 triangle_across(vec3 v, vec3 n) {
    vec3 w = v - n * dot(n, v);
    return w * (1.0 / sqrt(max(dot(w, w), 1e-30)));
}

// Direction uniform in the solid angle: C' at u.x of it along A C, then a point on the arc from B to C' (Arvo 1995).
vec3 triangle_direction(TriangleView t, vec2 u) {
    vec3 a = t.a * (1.0 / max(length(t.a), 1e-30));
    vec3 b = t.a + t.e1;
    vec3 c = t.a + t.e2;
    float lb = max(length(b), 1e-30);
    float lc = max(length(c), 1e-30);
    b = b / lb;
    c = c / lc;
    vec3 n_ac = cross(a, c);
    vec3 across = triangle_across(c, a);
    float sin_ac = max(length(n_ac), 1e-30);
    // |A B A'| from the volume, so that u.x = 1 lands on C to rounding.
    float height = t.volume / max(length(t.a) * lb * lc * sin_ac, 1e-30);
    float s;
    float k;
    m_sincos(0.5 * u.x * t.solid_angle, s, k);
    vec3 sum = a + b;
    // tan(phi/2) = n / d; 1 + A.B = |A + B|^2 / 2 keeps digits when they are nearly opposite.
    float n = s * 0.5 * dot(sum, sum);
    float d = max(k * height - s * dot(b, across), 0.0);
    float inv = 1.0 / max(n * n + d * d, 1e-38);
    // C' - A, then C' - B, so that short arcs keep digits: 1 - C'.B = |C' - B|^2 / 2.
    vec3 from_a = across * (2.0 * n * d * inv) - a * (2.0 * n * n * inv);
    vec3 from_b = from_a + (a - b);
    float h = 0.5 * dot(from_b, from_b);
    float g = u.y * h;
    vec3 w = from_b + b * h;
    w = w * (1.0 / sqrt(max(dot(w, w), 1e-30)));
    return normalize(b * (1.0 - g) + w * safe_sqrt(g * (2.0 - g)));
}

// Weights of vertices 1 and 2 where the ray along wi meets the plane (Cramer), moved into the triangle.
vec2 triangle_weights(TriangleView t, vec3 wi) {
    float det = dot(wi, cross(t.e1, t.e2));
    float inv = det != 0.0 ? 1.0 / det : 0.0;
    vec3 w = cross(wi, t.a);
    vec2 b = clamp(vec2(-dot(w, t.e2), dot(w, t.e1)) * inv, 0.0, 1.0);
    return b * (1.0 / max(b.x + b.y, 1.0));
}

TriangleLightSample triangle_light_sample(vec3 p, vec3 v0, vec3 v1, vec3 v2, vec2 u) {
    TriangleView t = triangle_view(p, v0, v1, v2);
    vec3 direction = triangle_direction(t, u);
    vec2 b = t.is_solid_angle ? triangle_weights(t, direction) : uniform_triangle(u);
    vec3 q = t.a + t.e1 * b.x + t.e2 * b.y;
    float distance = length(q);
    vec3 toward = distance > 0.0 ? q / distance : vec3(0.0, 0.0, 1.0);
    TriangleLightSample s;
    s.wi = t.is_solid_angle ? direction : toward;
    s.distance = distance * t.size;
    s.pdf = triangle_view_pdf(t, distance);
    s.b1 = b.x;
    s.b2 = b.y;
    return s;
}
