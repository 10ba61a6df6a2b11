// Orthographic camera; see src/camera/orthographic.rs.
CameraRay orthographic_ray(CameraRecord camera, vec2 film, SampleId id) {
    vec2 at = camera_plane(camera, film);
    return camera_plain(at.x * camera.right + at.y * camera.up, camera.forward);
}
