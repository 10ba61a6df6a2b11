// Ray cones: how much of a texture a hit stands for. src/texture/mip.rs says what they are.
#if TEXTURE_HAS_MIPS
void cone_travel(inout PathState s, float distance) {
    s.cone.x += s.cone.y * distance;
}

// Of what a cone as wide as s.cone.x covers at the hit, the areas in the units of both texture coordinates.
vec2 footprint_areas(PathState s, Hit hit, Surface surface) {
    vec2 areas = vec2(0.0);
#if HAS_TRIANGLES
    if (hit.kind == HIT_TRIANGLE) {
        TriangleRecord triangle = TriangleRecord_load_triangles(hit.slot);
        FaceRecord face = FaceRecord_load_faces(triangle.face);
        UvRecord a = UvRecord_load_uvs(face.vertices.x);
        UvRecord b = UvRecord_load_uvs(face.vertices.y);
        UvRecord c = UvRecord_load_uvs(face.vertices.z);
        vec3 u = triangle.v1 - triangle.v0;
        vec3 v = triangle.v2 - triangle.v0;
#if HAS_INSTANCES
        InstanceRecord placed = InstanceRecord_load_instances(hit.instance);
        u = instance_vector(placed, u);
        v = instance_vector(placed, v);
#endif
        vec3 across = cross(u, v);
        float covered = s.cone.x * s.cone.x / max(abs(dot(surface.ng, s.ray.d)), 1e-6);
        float part = covered / length(across);
        vec4 p = vec4(b.uv0, b.uv1) - vec4(a.uv0, a.uv1);
        vec4 q = vec4(c.uv0, c.uv1) - vec4(a.uv0, a.uv1);
        areas = part * abs(p.xz * q.yw - p.yw * q.xz);
    }
#endif
    return areas;
}

// After a direction was chosen: a smooth surface keeps the cone, a rough one widens it.
void cone_scatter(inout PathState s, bool is_delta, float pdf) {
    s.cone.y = is_delta ? s.cone.y : max(s.cone.y, CONE_SHARE * inversesqrt(pdf));
}
#endif
