// What patterns may read.
struct SurfacePoint {
    vec2 uv0;
    vec2 uv1;
    vec4 color;
};
