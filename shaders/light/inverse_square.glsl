// What a point p sees of a light that has no size: direction, distance, and the factor from intensity to irradiance.
struct PointView {
    vec3 wi;
    float distance;
    float inverse_square;  // 1/m2, towards wi
    bool is_apart;         // false at the light itself, which has no direction
};

PointView point_view(vec3 p, vec3 position) {
    vec3 to_light = position - p;
    float d2 = dot(to_light, to_light);
    bool is_apart = d2 > 0.0;
    float d = sqrt(d2);
    return PointView(to_light / (is_apart ? d : 1.0), d, 1.0 / (is_apart ? d2 : 1.0), is_apart);
}
