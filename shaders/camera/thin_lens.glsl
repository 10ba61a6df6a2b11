// Thin lens; see src/camera/thin_lens.rs.
CameraRay thin_lens_ray(CameraRecord camera, vec2 film, SampleId id) {
    vec2 at = camera_plane(camera, film);
    vec3 focus = camera.focus_distance * (camera.forward + at.x * camera.right + at.y * camera.up);
    vec2 lens = concentric_disk(camera_square(id, LENS_U, LENS_V)) * camera.lens;
    vec3 o = lens.x * camera.right + lens.y * camera.up;
    return camera_plain(o, normalize(focus - o));
}
