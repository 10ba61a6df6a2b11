// Where a ray that leaves a surface begins: beside the surface by the hit point's own error bound, never by a scene epsilon.
//
// Pharr, Jakob, Humphreys 2023, "Physically Based Rendering" 4th ed., Section 6.8. Hit points come from the primitive (by
// barycentrics, or projected onto the sphere or disc), not from o + t d, so that their error does not grow with the distance.
// gamma(n) = n eps / (1 - n eps), eps = 2^-24. Gate 5 (spawned rays do not hit the surface they left).

const float GAMMA_3 = 1.7881397e-7;
const float GAMMA_5 = 2.9802331e-7;
const float GAMMA_7 = 4.1723267e-7;
const float GAMMA_16 = 9.5367522e-7;
// Below any visible length, above the denormals: an error bound of 0 (a triangle through the origin) still separates.
const float SPAWN_FLOOR = 1e-30;

float next_up(float x) {
    int bits = floatBitsToInt(x);
    return (x == 0.0) ? uintBitsToFloat(1u) : intBitsToFloat(bits + ((bits >= 0) ? 1 : -1));
}

float next_down(float x) {
    return -next_up(-x);
}

float move_outward(float rounded, float offset) {
    float moved = (offset < 0.0) ? next_down(rounded) : rounded;
    return (offset > 0.0) ? next_up(rounded) : moved;
}

// Origin for the direction w, on the side of the unit normal ng to which w points; `error` bounds |p - true point| by component.
vec3 spawn_origin(vec3 p, vec3 error, vec3 ng, vec3 w) {
    float delta = dot(abs(ng), error);
    vec3 offset = ((dot(w, ng) < 0.0) ? -delta : delta) * ng;
    precise vec3 moved = p + offset;
    return vec3(move_outward(moved.x, offset.x), move_outward(moved.y, offset.y), move_outward(moved.z, offset.z));
}

// Point of a triangle at weights (1 - b1 - b2, b1, b2). The edges count in every direction, not only their own: the next ray's test
// of this plane rounds like their length, and would meet a floor of 20 m again at t > 0 (closed form "uniform sky"). Error: gamma_7 of the sum of magnitudes (PBR4 Section 6.8.1), with the
// smaller weights' own rounding in `1 - b1 - b2` included.
vec3 triangle_point(vec3 v0, vec3 v1, vec3 v2, float b1, float b2, out vec3 error) {
    precise float b0 = (1.0 - b1) - b2;
    precise vec3 p0 = b0 * v0;
    precise vec3 p1 = b1 * v1;
    precise vec3 p2 = b2 * v2;
    float edges = max_component(abs(v1 - v0) + abs(v2 - v0));
    error = GAMMA_7 * (abs(p0) + abs(p1) + abs(p2)) + vec3(GAMMA_16 * edges + SPAWN_FLOOR);
    precise vec3 p = (p0 + p1) + p2;
    return p;
}

// The direction from a sphere's centre to a point near its surface, unit length.
vec3 sphere_normal(vec3 near_surface, vec3 center) {
    return normalize(near_surface - center);
}

// Point of a sphere in the direction of its normal; projecting removes the error along it that o + t d has.
vec3 sphere_point(vec3 normal, vec3 center, float radius, out vec3 error) {
    precise vec3 p = center + radius * normal;
    error = GAMMA_5 * (abs(center) + abs(radius * normal)) + GAMMA_3 * vec3(radius) + vec3(SPAWN_FLOOR);
    return p;
}

// Point of a disc near `near_plane`, moved along the normal onto the plane. 3 gamma of |p|: its rounding and that of the step; 16 of
// the radius: the step's own length, and the next ray's test of this plane, which rounds like the distance to the centre.
vec3 disc_point(vec3 near_plane, vec3 center, vec3 normal, float radius, out vec3 error) {
    precise vec3 f = near_plane - center;
    precise float height = (f.x * normal.x + f.y * normal.y) + f.z * normal.z;
    precise vec3 p = near_plane - height * normal;
    error = GAMMA_3 * abs(p) + vec3(GAMMA_16 * radius + SPAWN_FLOOR);
    return p;
}

// v times a power of two, so that its largest component is in [1, 2): no bit is lost. 0 stays 0.
vec3 scale_to_unit(vec3 v) {
    float largest = max(abs(v.x), max(abs(v.y), abs(v.z)));
    uint exponent = min(floatBitsToUint(largest) >> 23, 253u);
    float scale = uintBitsToFloat((254u - exponent) << 23);
    return v * scale;
}

// Unit normal by the winding (front counter-clockwise), for triangles of any size: each edge is scaled by a power of two first,
// since f32 would lose the product of two edges of 1e-20 to underflow and of 1e20 to overflow.
vec3 triangle_normal(vec3 v0, vec3 v1, vec3 v2) {
    precise vec3 e1 = v1 - v0;
    precise vec3 e2 = v2 - v0;
    e1 = scale_to_unit(e1);
    e2 = scale_to_unit(e2);
    precise vec3 n = cross(e1, e2);
    n = scale_to_unit(n);
    return normalize(n);
}
