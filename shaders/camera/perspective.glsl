// Perspective camera; see src/camera/perspective.rs.
CameraRay perspective_ray(CameraRecord camera, vec2 film, SampleId id) {
    vec2 at = camera_plane(camera, film);
    return camera_plain(vec3(0.0), normalize(camera.forward + at.x * camera.right + at.y * camera.up));
}
