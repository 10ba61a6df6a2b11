// Watertight ray/triangle test: Woop, Benthin, Wald 2013, "Watertight ray/triangle intersection", JCGT 2(1).
//
// Each vertex is moved into the ray's frame by operations that depend on that vertex and the ray alone, so two triangles that
// share an edge see the very same edge function with opposite sign. Rounding is monotone, so its sign is right unless both
// products round to the same number; then the difference of their rounding errors decides, found without f64 by Dekker 1971
// over 12-bit halves. `precise`: contraction or reassociation would break both arguments.
// Exact for |coordinates| in [1e-12, 2^60] seen from the ray's origin. The same in Rust: src/bvh/traverse.rs. Gate 5.

// The ray as z axis: the axis of largest |d|, and the shear that takes d onto it.
struct TriangleRay {
    vec3 o;
    vec3 shear;  // d.x/d.z, d.y/d.z, 1/d.z after the permutation
    bool z_is_x;
    bool z_is_y;
};

// t is negative where the ray passes by. b1, b2 weigh v1 and v2.
struct TriangleHit {
    float t;
    float b1;
    float b2;
};

// Cyclic permutation that brings the dominant axis to z; selects, since a vector cannot be indexed cheaply per lane.
vec3 triangle_permute(TriangleRay ray, vec3 v) {
    return ray.z_is_x ? v.yzx : (ray.z_is_y ? v.zxy : v);
}

TriangleRay triangle_ray(vec3 o, vec3 d) {
    vec3 a = abs(d);
    TriangleRay ray;
    ray.z_is_x = (a.x >= a.y) && (a.x >= a.z);
    ray.z_is_y = !ray.z_is_x && (a.y >= a.z);
    ray.o = o;
    vec3 p = triangle_permute(ray, d);
    precise float inverse = 1.0 / p.z;
    precise float x = p.x * inverse;
    precise float y = p.y * inverse;
    ray.shear = vec3(x, y, inverse);
    return ray;
}

vec3 triangle_shear(TriangleRay ray, vec3 v) {
    precise vec3 local = v - ray.o;
    vec3 p = triangle_permute(ray, local);
    precise float x = p.x - ray.shear.x * p.z;
    precise float y = p.y - ray.shear.y * p.z;
    precise float z = ray.shear.z * p.z;
    return vec3(x, y, z);
}

float high_half(float x) {
    return uintBitsToFloat(floatBitsToUint(x) & 0xfffff000u);
}

// Rounding error of the product a * b = p, exact unless it underflows.
float product_error(float a, float b, float p) {
    float ah = high_half(a);
    float bh = high_half(b);
    precise float al = a - ah;
    precise float bl = b - bh;
    precise float error = ((ah * bh - p) + ah * bl + al * bh) + al * bl;
    return error;
}

// a * b - c * d with the right sign.
float edge_function(float a, float b, float c, float d) {
    precise float p = a * b;
    precise float q = c * d;
    precise float e = p - q;
    precise float exact = product_error(a, b, p) - product_error(c, d, q);
    return (e == 0.0) ? exact : e;
}

// Points on an edge belong to the triangle; one seen edge-on is missed, which its neighbours in a closed mesh make up for.
TriangleHit triangle_intersect(TriangleRay ray, vec3 v0, vec3 v1, vec3 v2) {
    vec3 a = triangle_shear(ray, v0);
    vec3 b = triangle_shear(ray, v1);
    vec3 c = triangle_shear(ray, v2);
    float e0 = edge_function(b.x, c.y, b.y, c.x);
    float e1 = edge_function(c.x, a.y, c.y, a.x);
    float e2 = edge_function(a.x, b.y, a.y, b.x);
    bool has_negative = (e0 < 0.0) || (e1 < 0.0) || (e2 < 0.0);
    bool has_positive = (e0 > 0.0) || (e1 > 0.0) || (e2 > 0.0);
    precise float sum = (e0 + e1) + e2;
    precise float inverse = 1.0 / sum;
    precise float b0 = e0 * inverse;
    precise float b1 = e1 * inverse;
    precise float b2 = e2 * inverse;
    precise float t = (b0 * a.z + b1 * b.z) + b2 * c.z;
    bool is_missed = (has_negative && has_positive) || (sum == 0.0);
    return TriangleHit(is_missed ? -1.0 : t, b1, b2);
}
