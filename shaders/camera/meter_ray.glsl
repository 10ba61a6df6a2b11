// Radiance along one ray; see src/camera/meter_ray.rs.
CameraRay meter_ray_ray(CameraRecord camera, vec2 film, SampleId id) {
    return camera_plain(vec3(0.0), camera.forward);
}
