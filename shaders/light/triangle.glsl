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
    vec3 a;  // from p to vertex 0
    vec3 e1;
    vec3 e2;
    vec3 to_a;  // unit vectors to the vertices
    vec3 to_b;
    vec3 to_c;
    float size;         // metres a unit
    float volume;       // |a . (e1 x e2)|
    float determinant;  // |to_a . (to_b x to_c)|
    float solid_angle;  // sr
    bool is_solid_angle;
};

// 1 + x.y + (x + y).z for unit vectors; for x and y nearly opposite the sum x + y keeps digits that the products lose.
float triangle_denominator(vec3 x, vec3 y, vec3 z) {
    vec3 sum = x + y;
    return dot(sum, 0.5 * sum + z);
}

TriangleView triangle_view(vec3 p, vec3 v0, vec3 v1, vec3 v2) {
    TriangleView t;
    vec3 a = v0 - p;
    vec3 b = v1 - p;
    vec3 c = v2 - p;
    vec3 m = max(abs(a), max(abs(b), abs(c)));
    t.size = max_component(m);
    float inv = t.size > 0.0 ? 1.0 / t.size : 0.0;
    t.a = a * inv;
    // From the vertices and not from a, b, c, which carry the rounding of p.
    t.e1 = (v1 - v0) * inv;
    t.e2 = (v2 - v0) * inv;
    vec3 lengths = max(vec3(length(t.a), length(b * inv), length(c * inv)), 1e-30);
    t.to_a = t.a / lengths.x;
    t.to_b = b * inv / lengths.y;
    t.to_c = c * inv / lengths.z;
    t.volume = abs(dot(t.a, cross(t.e1, t.e2)));
    t.determinant = t.volume / lengths.x / lengths.y / lengths.z;
    float ab = dot(t.to_a, t.to_b);
    float bc = dot(t.to_b, t.to_c);
    float ca = dot(t.to_c, t.to_a);
    // The widest pair goes first.
    bool is_ab = ab <= bc && ab <= ca;
    bool is_bc = !is_ab && bc <= ca;
    vec3 x = is_bc ? t.to_b : t.to_a;
    vec3 y = is_ab ? t.to_b : t.to_c;
    vec3 z = is_ab ? t.to_c : (is_bc ? t.to_a : t.to_b);
    t.solid_angle = 2.0 * m_atan2(t.determinant, triangle_denominator(x, y, z));
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
    vec3 a = t.to_a;
    vec3 b = t.to_b;
    vec3 across = triangle_across(t.to_c, a);
    // |A B A'| from the volume, so that u.x = 1 lands on C to rounding.
    float sin_ac = max(length(cross(a, t.to_c)), 1e-30);
    float height = t.determinant / sin_ac;
    float s;
    float k;
    m_sincos(0.5 * u.x * t.solid_angle, s, k);
    // tan(phi/2) = n / d. 1 + A.B = |A + B|^2 / 2 and B.A' = (A + B).A' keep digits when A and B are nearly opposite.
    vec3 sum = a + b;
    float n = s * 0.5 * dot(sum, sum);
    float d = max(k * height - s * dot(sum, across), 0.0);
    // Rounding must not carry C' beyond C: with A opposite to both others it would land across the sphere.
    vec3 sum_ac = a + t.to_c;
    float end = 0.5 * dot(sum_ac, sum_ac);
    bool is_beyond = n * end > d * sin_ac;
    n = is_beyond ? sin_ac : n;
    d = is_beyond ? end : d;
    float inv = 1.0 / max(n * n + d * d, 1e-38);
    // C' - A, then C' - B and C' + B: whichever is short keeps its digits. h = 1 - C'.B = |C' - B|^2 / 2, 2 - h = |C' + B|^2 / 2.
    vec3 from_a = across * (2.0 * n * d * inv) - a * (2.0 * n * n * inv);
    vec3 from_b = from_a + (a - b);
    vec3 from_opposite = from_a + sum;
    float h = 0.5 * dot(from_b, from_b);
    float rest = 0.5 * dot(from_opposite, from_opposite);
    vec3 w = h < 1.0 ? from_b + b * h : from_opposite - b * rest;
    w = w * (1.0 / sqrt(max(dot(w, w), 1e-30)));
    // 1 - cos and 1 + cos of the way from B, u.y of it.
    float g = u.y * h;
    float g_rest = 2.0 * (1.0 - u.y) + u.y * rest;
    vec3 q = b * (h < 1.0 ? 1.0 - g : g_rest - 1.0) + w * sqrt(g * g_rest);
    // From a point on the edge A B the arc is undefined, and its middle may be 0: any direction will do.
    float q2 = dot(q, q);
    return q2 > 0.5 ? q * (1.0 / sqrt(q2)) : b;
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

#if IN_KERNEL
// A triangle of the scene: light.a, b, c are its vertices, light.shape its face.
LightSample triangle_light_connect(PathState s, LightRecord light, vec3 p, vec2 u) {
    TriangleLightSample t = triangle_light_sample(s.from, light.a, light.b, light.c, u);
    MaterialRecord material = MaterialRecord_load_materials(light.material);
    SurfacePoint point = triangle_point_data(FaceRecord_load_faces(light.shape), t.b1, t.b2);
    bool is_front = dot(t.wi, triangle_normal(light.a, light.b, light.c)) < 0.0;
    bool shines = is_front || (material.flags & MATERIAL_EMITS_TWO_SIDED) != 0u;
    Spectrum radiance = shines ? material_emission(material, point) : Spectrum(0.0);
    return LightSample(t.wi, t.distance, t.pdf, radiance, light.shape, NONE, false);
}

float triangle_light_density(LightRecord light, vec3 p, vec3 wi, float distance, bool is_front) {
    return triangle_light_pdf(p, light.a, light.b, light.c, wi, distance);
}
#endif
