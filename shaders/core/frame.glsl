// Orthonormal frames: shading space has z = normal. Twin src/math/frame.rs.
struct Frame {
    vec3 t;
    vec3 b;
    vec3 n;
};

// Right-handed frame about the unit n, without a singularity (Duff et al. 2017, JCGT 6(1), listing 3).
Frame frame_from_normal(vec3 n) {
    float s = uintBitsToFloat((floatBitsToUint(n.z) & 0x80000000u) | 0x3f800000u);
    float a = -1.0 / (s + n.z);
    float b = n.x * n.y * a;
    return Frame(vec3(1.0 + s * n.x * n.x * a, s * b, -s * n.x), vec3(b, s + n.y * n.y * a, -n.y), n);
}

// Frame about the unit n whose x axis is the tangent made perpendicular to n (Gram-Schmidt); where the tangent is
// 0, not finite or along n (sin < 1e-4), the frame of the normal alone. The tangent's length does not matter.
Frame frame_from_tangent(vec3 n, vec3 tangent) {
    Frame f = frame_from_normal(n);
    float largest = max(abs(tangent.x), max(abs(tangent.y), abs(tangent.z)));
    bool is_usable = largest > 0.0 && largest < 1e38 && !is_nan_bits(tangent.x + tangent.y + tangent.z);
    vec3 v = is_usable ? tangent / largest : vec3(0.0);
    // Twice: the first projection leaves n |v| eps, which counts when v is nearly along n.
    vec3 t = v - n * dot(n, v);
    t = t - n * dot(n, t);
    float t2 = dot(t, t);
    is_usable = t2 > 1e-8 * dot(v, v);
    t = t * (1.0 / sqrt(is_usable ? t2 : 1.0));
    f.t = is_usable ? t : f.t;
    f.b = is_usable ? cross(n, t) : f.b;
    return f;
}

vec3 to_local(Frame f, vec3 v) {
    return vec3(dot(v, f.t), dot(v, f.b), dot(v, f.n));
}

vec3 to_world(Frame f, vec3 v) {
    return f.t * v.x + f.b * v.y + f.n * v.z;
}
