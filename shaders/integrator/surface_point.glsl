// What patterns may read.
struct SurfacePoint {
    vec2 uv0;
    vec2 uv1;
    vec4 color;
#if TEXTURE_HAS_MIPS
    vec2 areas;  // of the ray's footprint, in units of uv0 and uv1 squared; 0: at a point
#endif
};

SurfacePoint surface_point_none() {
    SurfacePoint point;
    point.uv0 = vec2(0.0);
    point.uv1 = vec2(0.0);
    point.color = vec4(1.0);
#if TEXTURE_HAS_MIPS
    point.areas = vec2(0.0);
#endif
    return point;
}
