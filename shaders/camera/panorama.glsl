// Panorama, laid out as the sky's lat-long picture; see src/camera/panorama.rs.
CameraRay panorama_ray(CameraRecord camera, vec2 film, SampleId id) {
    vec2 at = camera_plane(camera, film);
    float sin_longitude;
    float cos_longitude;
    m_sincos(PI * at.x, sin_longitude, cos_longitude);
    float sin_latitude;
    float cos_latitude;
    m_sincos(0.5 * PI * at.y, sin_latitude, cos_latitude);
    vec3 level = sin_longitude * camera.right + cos_longitude * camera.forward;
    return camera_plain(vec3(0.0), normalize(cos_latitude * level + sin_latitude * camera.up));
}
