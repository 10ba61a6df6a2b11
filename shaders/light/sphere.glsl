// A sphere light: uniform in the cone it fills; from inside, over all directions. Derivations in src/light/sphere.rs.
struct SphereLightSample {
    vec3 wi;
    float distance;  // to the first surface point along wi
    float pdf;       // 1/sr; 0 means no sample
};

// From outside every visible point shows its front, from inside its back.
bool sphere_light_is_outside(vec3 p, vec3 center, float radius) {
    return length(center - p) > radius;
}

// 1 - cos of the cone's half angle for s = r/d: s^2 / (1 + sqrt(1 - s^2)), no cancellation far away. 1 - s^2 as (1-s)(1+s).
float sphere_light_cone(float s) {
    return s * s / (1.0 + safe_sqrt((1.0 - s) * (1.0 + s)));
}

float sphere_light_cone_pdf(float h) {
    return h > 1e-37 ? INV_TWO_PI / h : 0.0;
}

float sphere_light_pdf(vec3 p, vec3 center, float radius) {
    float d = length(center - p);
    bool is_outside = d > radius;
    return is_outside ? sphere_light_cone_pdf(sphere_light_cone(radius / (is_outside ? d : 1.0))) : uniform_sphere_pdf();
}

SphereLightSample sphere_light_sample(vec3 p, vec3 center, float radius, vec2 u) {
    vec3 to_center = center - p;
    float d = length(to_center);
    bool is_outside = d > radius;
    vec3 axis = is_outside ? to_center / d : vec3(0.0, 0.0, 1.0);
    float h = is_outside ? sphere_light_cone(radius / d) : 2.0;
    // A cone of height 2 is the whole sphere.
    vec3 wi = to_world(is_outside ? frame_from_normal(axis) : Frame(vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0), axis), uniform_cone(u, h));
    // Near root: product of the roots over the far one; the half chord is r sqrt(1 - sin^2/sin_max^2) written out.
    float half_chord = radius * safe_sqrt((1.0 - u.x) * (2.0 - h * (1.0 + u.x)) / (is_outside ? 2.0 - h : 1.0));
    float product = (d - radius) * (d + radius);
    float near = product / (is_outside ? d * (1.0 - u.x * h) + half_chord : 1.0);
    float along = dot(wi, to_center);
    float far = along + safe_sqrt(along * along - product);
    SphereLightSample s;
    s.wi = wi;
    s.distance = is_outside ? near : far;
    s.pdf = is_outside ? sphere_light_cone_pdf(h) : uniform_sphere_pdf();
    return s;
}

#if IN_KERNEL
// A sphere of the scene: centre light.a, radius light.b.x, row light.shape of `spheres`.
LightSample sphere_light_connect(PathState s, LightRecord light, vec3 p, vec2 u) {
    SphereLightSample q = sphere_light_sample(s.from, light.a, light.b.x, u);
    MaterialRecord material = MaterialRecord_load_materials(light.material);
    SphereRecord sphere = SphereRecord_load_spheres(light.shape);
    vec3 to_center = light.a - s.from;
    bool is_front = sphere_light_is_outside(s.from, light.a, light.b.x);
    SurfacePoint point = sphere_point_data(sphere, normalize(q.wi * q.distance - to_center));
    bool shines = is_front || (material.flags & MATERIAL_EMITS_TWO_SIDED) != 0u;
    Spectrum radiance = shines ? material_emission(material, point) : Spectrum(0.0);
    return LightSample(q.wi, q.distance, q.pdf, radiance, sphere.primitive, NONE, false);
}

float sphere_light_density(LightRecord light, vec3 p, vec3 wi, float distance, bool is_front) {
    // The side that p does not see: reached through the sphere's own surface only, which light sampling does not try.
    bool is_seen = sphere_light_is_outside(p, light.a, light.b.x) == is_front;
    return is_seen ? sphere_light_pdf(p, light.a, light.b.x) : 0.0;
}
#endif
