// Irradiance over a surface; see src/camera/meter_surface.rs.
CameraRay meter_surface_ray(CameraRecord camera, vec2 film, SampleId id) {
    SensorPoint at = sensor_point(id);
    vec3 d = to_world(frame_from_normal(at.normal), cosine_hemisphere(camera_square(id, BSDF_U, BSDF_V)));
    return CameraRay(at.p, d, PI * at.weight, at.normal);
}
