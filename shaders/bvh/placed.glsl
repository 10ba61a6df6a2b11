// Points and normals of placed meshes, out of object space into the world.
//
// The error of a point is that of the matrix product, after Pharr, Jakob, Humphreys 2023, "Physically Based Rendering" 4th ed., Section
// 6.8.3, and covers the way back too: a ray that begins at the point is taken into object space again, where its origin must stay on
// the surface's own side. A row's products and sums round four times, the matrix itself once. Gate 5.

// Sum of the magnitudes of a row's products: what its rounding is relative to.
vec3 affine_magnitude(vec4 r0, vec4 r1, vec4 r2, vec3 p) {
    vec3 a = abs(p);
    return vec3(affine_row(abs(r0), a), affine_row(abs(r1), a), affine_row(abs(r2), a));
}

vec3 linear_magnitude(vec4 r0, vec4 r1, vec4 r2, vec3 v) {
    return vec3(linear_row(abs(r0), v), linear_row(abs(r1), v), linear_row(abs(r2), v));
}

// World point of an object's point q; `error` is q's bound before, p's after.
vec3 instance_point(InstanceRecord m, vec3 q, inout vec3 error) {
    vec3 p = vec3(affine_row(m.to_world0, q), affine_row(m.to_world1, q), affine_row(m.to_world2, q));
    vec3 forth = affine_magnitude(m.to_world0, m.to_world1, m.to_world2, q);
    vec3 back = affine_magnitude(m.to_object0, m.to_object1, m.to_object2, p);
    vec3 in_object = error + GAMMA_5 * back;
    error = linear_magnitude(m.to_world0, m.to_world1, m.to_world2, in_object) + GAMMA_5 * forth;
    return p;
}

// Unit normal through the inverse transpose, which keeps the front's side under mirrors; 0 stays 0.
vec3 instance_normal(InstanceRecord m, vec3 n) {
    precise vec3 w = (n.x * m.to_object0.xyz + n.y * m.to_object1.xyz) + n.z * m.to_object2.xyz;
    w = scale_to_unit(w);
    return w * (1.0 / sqrt(max(dot(w, w), 1e-30)));
}

vec3 instance_vector(InstanceRecord m, vec3 v) {
    return vec3(linear_row(m.to_world0, v), linear_row(m.to_world1, v), linear_row(m.to_world2, v));
}

// Unit tangent; 0 stays 0.
vec3 instance_tangent(InstanceRecord m, vec3 t) {
    vec3 w = scale_to_unit(instance_vector(m, t));
    return w * (1.0 / sqrt(max(dot(w, w), 1e-30)));
}
