// Where a surface meter measures; see src/camera/meter_surface.rs.

// How far from the surface rays start, in parts of the largest coordinate and extent.
const float SENSOR_LIFT = 4e-6;

struct SensorPoint {
    vec3 p;         // beside the surface, on the measured side
    vec3 normal;
    float weight;   // share by which the choice of the element missed its area
};

SensorPoint sensor_point(SampleId id) {
    uint entry = alias_entry(sample_u32(id, 0u, SENSOR_INDEX), ELEMENT_COUNT);
    uint index = alias_pick(sensor_alias_row(entry >> 1), entry, sample_u32(id, 0u, SENSOR_FRACTION));
    SensorElementRecord e = SensorElementRecord_load_sensor_elements(index);
    vec2 u = camera_square(id, LENS_U, LENS_V);
    bool is_sphere = e.kind == HIT_SPHERE;
    bool is_disc = e.kind == HIT_DISC;
    vec3 outward = uniform_sphere(u);
    vec3 e1 = e.b - e.a;
    vec3 e2 = e.c - e.a;
    vec2 b = uniform_triangle(u);
    vec2 d = concentric_disk(u);
    vec3 p = is_sphere ? e.a + e.b.x * outward : e.a + (is_disc ? d.x * e.b + d.y * e.c : b.x * e1 + b.y * e2);
    vec3 flat_normal = is_disc ? normalize(cross(e.b, e.c)) : triangle_normal(e.a, e.b, e.c);
    vec3 normal = e.side * (is_sphere ? outward : flat_normal);
    vec3 radii = max(abs(e.b), abs(e.c));
    float size = is_sphere ? e.b.x : max_component(is_disc ? radii : max(abs(e1), abs(e2)));
    float lift = SENSOR_LIFT * (max_component(abs(p)) + size);
    return SensorPoint(p + lift * normal, normal, e.weight);
}
