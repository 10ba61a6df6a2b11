// The start of a sample; see src/camera/mod.rs.

struct CameraRay {
    vec3 o;
    vec3 d;
    float weight;   // factor on the radiance that arrives
    vec3 receiver;  // normal of a meter that collects from a hemisphere, d then has density cos/pi; 0 for cameras
};

CameraRay camera_plain(vec3 o, vec3 d) {
    return CameraRay(o, d, 1.0, vec3(0.0));
}

// `film` in pixels, row 0 on top, to [-1, 1]^2, y up.
vec2 camera_plane(CameraRecord camera, vec2 film) {
    return vec2(film.x * camera.inv_width - 1.0, 1.0 - film.y * camera.inv_height);
}

vec2 camera_square(SampleId id, uvec2 x, uvec2 y) {
    return vec2(u01(sample_u32(id, 0u, x)), u01(sample_u32(id, 0u, y)));
}
