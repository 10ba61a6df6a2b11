// Light from one direction, infinitely far away and without size, given by its perpendicular irradiance. See src/light/directional.rs.
#if IN_KERNEL
// light.b towards it, light.c the irradiance in W/m2.
LightSample directional_light_connect(PathState s, LightRecord light, vec3 p, vec2 u) {
    return LightSample(light.b, INFINITY, 1.0, light.c, NONE, NONE, true);
}
#endif
