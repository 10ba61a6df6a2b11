// What patterns read at a hit: texture coordinates and vertex colours of a triangle, a sphere or a disc.

#if HAS_TRIANGLES
SurfacePoint triangle_point_data(FaceRecord face, float b1, float b2) {
    SurfacePoint point = surface_point_none();
    float b0 = 1.0 - b1 - b2;
#if HAS_UVS
    UvRecord a = UvRecord_load_uvs(face.vertices.x);
    UvRecord b = UvRecord_load_uvs(face.vertices.y);
    UvRecord c = UvRecord_load_uvs(face.vertices.z);
    point.uv0 = a.uv0 * b0 + b.uv0 * b1 + c.uv0 * b2;
    point.uv1 = a.uv1 * b0 + b.uv1 * b1 + c.uv1 * b2;
#endif
#if HAS_COLORS
    point.color = ColorRecord_load_colors(face.vertices.x).rgba * b0
        + ColorRecord_load_colors(face.vertices.y).rgba * b1
        + ColorRecord_load_colors(face.vertices.z).rgba * b2;
#endif
    return point;
}
#endif

#if HAS_SPHERES
vec3 quaternion_rotate(vec4 q, vec3 v) {
    return v + 2.0 * cross(q.xyz, cross(q.xyz, v) + q.w * v);
}

SurfacePoint sphere_point_data(SphereRecord sphere, vec3 n) {
    SurfacePoint point = surface_point_none();
#if HAS_UVS
    vec3 l = sphere.handedness * quaternion_rotate(sphere.rotation, n);
    point.uv0 = vec2(m_atan2(l.x, -l.z) * INV_TWO_PI + 0.5, m_acos(clamp(l.y, -1.0, 1.0)) * INV_PI);
    point.uv1 = point.uv0;
#endif
    return point;
}
#endif

#if HAS_DISCS
SurfacePoint disc_point_data(DiscRecord disc, vec3 p) {
    SurfacePoint point = surface_point_none();
#if HAS_UVS
    vec3 local = (p - disc.center) / disc.radius;
    vec3 bitangent = disc.handedness * cross(disc.normal, disc.tangent);
    point.uv0 = vec2(0.5 + 0.5 * dot(local, disc.tangent), 0.5 - 0.5 * dot(local, bitangent));
    point.uv1 = point.uv0;
#endif
    return point;
}
#endif

#if HAS_ALPHA
// Material and pattern data of a hit, as far as alpha needs them.
SurfacePoint hit_point_data(Hit hit, Ray ray, out uint material) {
    SurfacePoint point = surface_point_none();
    material = 0u;
#if HAS_TRIANGLES
    if (hit.kind == HIT_TRIANGLE) {
        TriangleRecord triangle = TriangleRecord_load_triangles(hit.slot);
        material = triangle.material;
#if HAS_INSTANCES
        material = hit.instance == 0u ? material : InstanceRecord_load_instances(hit.instance).material;
#endif
        point = triangle_point_data(FaceRecord_load_faces(triangle.face), hit.b1, hit.b2);
    }
#endif
#if HAS_SPHERES
    if (hit.kind == HIT_SPHERE) {
        SphereRecord sphere = SphereRecord_load_spheres(hit.slot);
        material = sphere.material;
        point = sphere_point_data(sphere, sphere_normal(ray.o + hit.t * ray.d, sphere.center));
    }
#endif
#if HAS_DISCS
    if (hit.kind == HIT_DISC) {
        DiscRecord disc = DiscRecord_load_discs(hit.slot);
        material = disc.material;
        point = disc_point_data(disc, ray.o + hit.t * ray.d);
    }
#endif
    return point;
}
#endif
