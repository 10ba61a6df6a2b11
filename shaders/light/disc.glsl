// A disc light, uniform in area; the density and what it does near by, far away and in the plane: src/light/disc.rs.
struct DiscLightSample {
    vec3 wi;
    float distance;
    float pdf;   // 1/sr; 0 means no sample (in the plane of the disc)
    vec2 place;  // in radii
};

// The disc's radii x and y are at a right angle, x cross y towards the front. In units of the largest coordinate, so that no cube
// overflows.
float disc_light_pdf(vec3 p, vec3 center, vec3 x, vec3 y, float distance) {
    vec3 to_center = center - p;
    float size = max_component(max(abs(to_center), max(abs(x), abs(y))));
    float inv = size > 0.0 ? 1.0 / size : 0.0;
    float volume = abs(dot(to_center * inv, cross(x * inv, y * inv)));
    float d = distance * inv;
    float pdf = volume > 0.0 ? INV_PI * (d * d * d) / volume : 0.0;
    return pdf < 1e37 ? pdf : 0.0;
}

DiscLightSample disc_light_sample(vec3 p, vec3 center, vec3 x, vec3 y, vec2 u) {
    vec2 place = concentric_disk(u);
    // Seen from p first: far from the origin the sum of small things keeps their digits.
    vec3 q = (center - p) + (place.x * x + place.y * y);
    float distance = length(q);
    DiscLightSample s;
    s.wi = distance > 0.0 ? q / distance : vec3(0.0, 0.0, 1.0);
    s.distance = distance;
    s.pdf = disc_light_pdf(p, center, x, y, distance);
    s.place = place;
    return s;
}

#if IN_KERNEL
// A disc of the scene: centre light.a, radii light.b and light.c, row light.shape of `discs`.
LightSample disc_light_connect(PathState s, LightRecord light, vec3 p, vec2 u) {
    DiscLightSample q = disc_light_sample(s.from, light.a, light.b, light.c, u);
    MaterialRecord material = MaterialRecord_load_materials(light.material);
    DiscRecord disc = DiscRecord_load_discs(light.shape);
    bool is_front = dot(q.wi, disc.normal) < 0.0;
    SurfacePoint point = disc_point_data(disc, light.a + (q.place.x * light.b + q.place.y * light.c));
    bool shines = is_front || (material.flags & MATERIAL_EMITS_TWO_SIDED) != 0u;
    Spectrum radiance = shines ? material_emission(material, point) : Spectrum(0.0);
    return LightSample(q.wi, q.distance, q.pdf, radiance, disc.primitive, NONE, false);
}

float disc_light_density(LightRecord light, vec3 p, vec3 wi, float distance, bool is_front) {
    return disc_light_pdf(p, light.a, light.b, light.c, distance);
}
#endif
