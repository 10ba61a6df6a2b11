// Perspective camera; see src/camera/perspective.rs. `film` is in pixels, row 0 on top.
vec3 perspective_direction(CameraRecord camera, vec2 film) {
    vec3 d = camera.forward + (film.x * camera.inv_width - 1.0) * camera.right
        + (1.0 - film.y * camera.inv_height) * camera.up;
    return normalize(d);
}
