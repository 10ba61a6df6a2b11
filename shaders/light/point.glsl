// A point light, the same intensity in every direction: E = I cos/d^2. See src/light/point.rs.
#if IN_KERNEL
// light.a its position, light.c its intensity in W/sr.
LightSample point_light_connect(PathState s, LightRecord light, vec3 p, vec2 u) {
    PointView v = point_view(p, light.a);
    return LightSample(v.wi, v.distance, v.is_apart ? 1.0 : 0.0, light.c * v.inverse_square, NONE, NONE, true);
}
#endif
