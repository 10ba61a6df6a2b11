// Ray/sphere intersection that keeps its accuracy for small, far and large spheres.
//
// Haines, Günther, Akenine-Möller 2019, "Precision improvements for ray/sphere intersection", Ray Tracing Gems ch. 7: the
// discriminant from the ray's perpendicular distance instead of b*b - a*c, and the root of smaller magnitude as c/q. Both
// differences of squares are written as products. Left out: distances below the f32 resolution of |o - center|.
// The same in Rust: src/bvh/traverse.rs. Gate 5.

// near <= far along the line; both are negative where the line misses. near < 0 < far: the origin is inside.
struct SphereHit {
    float near;
    float far;
};

SphereHit sphere_intersect(vec3 o, vec3 d, vec3 center, float radius) {
    precise vec3 f = o - center;
    precise float a = (d.x * d.x + d.y * d.y) + d.z * d.z;
    precise float b = -((f.x * d.x + f.y * d.y) + f.z * d.z);
    precise float s = b / a;
    precise vec3 l = f + s * d;  // from the centre to the line's nearest point
    precise float perpendicular = sqrt((l.x * l.x + l.y * l.y) + l.z * l.z);
    precise float discriminant = (radius - perpendicular) * (radius + perpendicular);
    precise float root = sqrt(a * max(discriminant, 0.0));
    precise float q = (b < 0.0) ? b - root : b + root;
    precise float distance_o = sqrt((f.x * f.x + f.y * f.y) + f.z * f.z);
    precise float c = (distance_o - radius) * (distance_o + radius);
    precise float t0 = c / q;
    precise float t1 = q / a;
    bool is_hit = discriminant >= 0.0;
    return SphereHit(is_hit ? min(t0, t1) : -1.0, is_hit ? max(t0, t1) : -1.0);
}
