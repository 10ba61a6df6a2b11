// Placed meshes: rays into object space. Distances along the ray are those of the world, since d' = B d keeps its length's factor.
// What rounding does to the ray is in the placements' boxes (src/bvh/two_level.rs) and in the bound of placed points (placed.glsl).
// Operation for operation that of src/bvh/traverse.rs. Gate 5.

// Leaf word of row 0, the world: the way back.
const uint INSTANCE_WORLD_WORD = 0xe0000000u;

float affine_row(vec4 row, vec3 p) {
    precise float x = ((row.x * p.x + row.y * p.y) + row.z * p.z) + row.w;
    return x;
}

float linear_row(vec4 row, vec3 v) {
    precise float x = (row.x * v.x + row.y * v.y) + row.z * v.z;
    return x;
}

Ray instance_ray(InstanceRecord m, Ray ray) {
    vec3 o = vec3(affine_row(m.to_object0, ray.o), affine_row(m.to_object1, ray.o), affine_row(m.to_object2, ray.o));
    vec3 d = vec3(linear_row(m.to_object0, ray.d), linear_row(m.to_object1, ray.d), linear_row(m.to_object2, ray.d));
    return Ray(o, d, ray.t_max);
}
