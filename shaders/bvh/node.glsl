// What both traversals share: rays, hits, and the test of a ray against the four boxes of a BVH4 node.
//
// Boxes after Ize 2013, "Robust BVH ray traversal", JCGT 2(2): the exit distance is scaled up, and a NaN (0 times infinity, when
// the origin lies in a face plane that the ray runs along) loses each comparison and drops out. The comparisons are written out
// since Vulkan's min and max may return a NaN. Node layout: src/bvh/mod.rs. Gate 5.

// `d` has unit length; hits lie at 0 < t < t_max, which may be INFINITY.
struct Ray {
    vec3 o;
    vec3 d;
    float t_max;
};

// kind 0: triangle, 1: sphere, 2: disc, NO_HIT: missed. `slot` is the place in leaf order, `primitive` the face number or
// `primitive` of the sphere's or disc's record; b1, b2 weigh v1 and v2 of a triangle.
struct Hit {
    float t;
    float b1;
    float b2;
    uint kind;
    uint slot;
    uint primitive;
#if HAS_INSTANCES
    uint instance;  // row of `instances`; 0 is the world
#endif
};

// A hit in the world; one on an instance sets `instance` besides.
Hit hit_at(float t, float b1, float b2, uint kind, uint slot, uint primitive) {
    Hit h;
    h.t = t;
    h.b1 = b1;
    h.b2 = b2;
    h.kind = kind;
    h.slot = slot;
    h.primitive = primitive;
#if HAS_INSTANCES
    h.instance = 0u;
#endif
    return h;
}

const uint NO_HIT = 0xffffffffu;
const uint BVH_LEAF_BIT = 0x80000000u;
// No leaf word: one of kind 3 has a count of 1.
const uint BVH_DONE = 0xffffffffu;
// 1 + 2 gamma_13: 3 roundings of a slab distance, and 10 ulp by which the triangle test may move an edge.
const float BVH_BOX_SLACK = 1.0 + 26.0 / 16777216.0;

// What the box tests need of a ray. `rows`: rows of a node that hold the near planes of x, y, z; the far ones are its other
// three, so that no value has to be selected by the direction's sign.
struct BoxRay {
    vec3 o;
    vec3 inverse;
    uvec3 near_row;
    uvec3 far_row;
};

BoxRay box_ray(Ray ray) {
    BoxRay b;
    b.o = ray.o;
    b.inverse = mix(1.0 / ray.d, vec3(INFINITY), equal(ray.d, vec3(0.0)));
    uvec3 is_negative = uvec3(lessThan(b.inverse, vec3(0.0)));
    b.near_row = uvec3(0u, 2u, 4u) + is_negative;
    b.far_row = uvec3(1u, 3u, 5u) - is_negative;
    return b;
}

vec4 bvh_plane(uint row) {
    return uintBitsToFloat(bvh_row(row));
}

vec4 larger_or_second(vec4 a, vec4 b) {
    return mix(b, a, greaterThan(a, b));
}

vec4 smaller_or_second(vec4 a, vec4 b) {
    return mix(b, a, lessThan(a, b));
}

// Entry distances of the four children of the node whose rows begin at `row`; INFINITY where the ray passes by, or enters
// after t_max, or leaves before t_min.
vec4 box_entries(BoxRay ray, uint row, float t_min, float t_max) {
    precise vec4 near_x = (bvh_plane(row + ray.near_row.x) - ray.o.x) * ray.inverse.x;
    precise vec4 near_y = (bvh_plane(row + ray.near_row.y) - ray.o.y) * ray.inverse.y;
    precise vec4 near_z = (bvh_plane(row + ray.near_row.z) - ray.o.z) * ray.inverse.z;
    precise vec4 far_x = (bvh_plane(row + ray.far_row.x) - ray.o.x) * ray.inverse.x;
    precise vec4 far_y = (bvh_plane(row + ray.far_row.y) - ray.o.y) * ray.inverse.y;
    precise vec4 far_z = (bvh_plane(row + ray.far_row.z) - ray.o.z) * ray.inverse.z;
    vec4 enter = larger_or_second(near_x, larger_or_second(near_y, larger_or_second(near_z, vec4(t_min))));
    vec4 leave = smaller_or_second(far_x, smaller_or_second(far_y, smaller_or_second(far_z, vec4(t_max))));
    return mix(vec4(INFINITY), enter, lessThanEqual(enter, leave * BVH_BOX_SLACK));
}

uint leaf_kind(uint word) {
    return (word >> 29) & 3u;
}

uint leaf_first(uint word) {
    return word & 0x03ffffffu;
}

uint leaf_end(uint word) {
    return (word & 0x03ffffffu) + ((word >> 26) & 7u) + 1u;
}
