// Irradiance at a point; see src/camera/meter_point.rs.
CameraRay meter_point_ray(CameraRecord camera, vec2 film, SampleId id) {
    vec3 normal = camera.forward;
    vec3 d = to_world(frame_from_normal(normal), cosine_hemisphere(camera_square(id, BSDF_U, BSDF_V)));
    return CameraRay(vec3(0.0), d, PI, normal);
}
