// Ray/disc: where the ray meets the plane, kept when that is no farther from the centre than the radius.
//
// The distance is that of the plane, (c - o).n / d.n, so that its error is a few ulp of |c - o| over |d.n|, as for a triangle; the
// place in the disc is measured from the centre, t d - (c - o), which does not grow with the distance from the world's origin.
// Edge-on the quotient is infinite or NaN and the comparison fails. Radii whose square vanishes in f32 are dropped by the build.
// The same in Rust: src/bvh/traverse.rs. Gate 5.

// Negative where the ray passes by.
float disc_intersect(vec3 o, vec3 d, vec3 center, vec3 normal, float radius) {
    precise vec3 f = center - o;
    precise float height = (f.x * normal.x + f.y * normal.y) + f.z * normal.z;
    precise float along = (d.x * normal.x + d.y * normal.y) + d.z * normal.z;
    precise float t = height / along;
    precise vec3 h = t * d - f;
    precise float square = (h.x * h.x + h.y * h.y) + h.z * h.z;
    return square <= radius * radius ? t : -1.0;
}
