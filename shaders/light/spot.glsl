// A spot light: a point light whose intensity falls off from its axis. The three falloffs are one formula of h = 1 - cos(angle),
// x = offset - scale h: dark where x <= 0, else min(x, 1)^exponent, exponent 0 being the hard cone. See src/light/spot.rs.

// 1 - cos of the angle between unit vectors, without cancellation: half the squared chord.
float spot_one_minus_cos(vec3 axis, vec3 w) {
    vec3 chord = w - axis;
    return 0.5 * dot(chord, chord);
}

// Share of the intensity on the axis; `falloff` = (scale, offset, exponent).
float spot_falloff(float h, vec3 falloff) {
    float x = min(falloff.y - falloff.x * h, 1.0);
    float share = falloff.z == 0.0 ? 1.0 : m_exp(falloff.z * m_log(max(x, 1e-37)));
    return x > 0.0 ? share : 0.0;
}

#if IN_KERNEL
// light.a its position, light.b its axis, light.c the intensity on it in W/sr.
LightSample spot_light_connect(PathState s, LightRecord light, vec3 p, vec2 u) {
    PointView v = point_view(p, light.a);
    float share = spot_falloff(spot_one_minus_cos(light.b, -v.wi), light.falloff);
    return LightSample(v.wi, v.distance, v.is_apart ? 1.0 : 0.0, light.c * (share * v.inverse_square), NONE, NONE, true);
}
#endif
