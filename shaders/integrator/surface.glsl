// From a hit to a surface point: position with its error, normals, uv, colour, material. Rules of the frame: src/integrator/path.rs.

struct Surface {
    vec3 p;
    vec3 error;  // bound on the rounding error of p, per component
    vec3 ng;     // geometric normal, front side
    vec3 ns;     // shading normal before normal mapping, on ng's side
    vec4 tangent;  // xyz, handedness in w; 0 where there is none
    SurfacePoint point;
    uint material;
    uint light;
};

Surface surface_load(Hit hit, Ray ray) {
    Surface s;
    s.p = ray.o;
    s.error = vec3(0.0);
    s.ng = -ray.d;
    s.ns = -ray.d;
    s.tangent = vec4(0.0);
    s.point = surface_point_none();
    s.material = 0u;
    s.light = NONE;
#if HAS_TRIANGLES
    if (hit.kind == HIT_TRIANGLE) {
        TriangleRecord triangle = TriangleRecord_load_triangles(hit.slot);
        s.material = triangle.material;
        s.light = triangle.light;
        s.p = triangle_point(triangle.v0, triangle.v1, triangle.v2, hit.b1, hit.b2, s.error);
        s.ng = triangle_normal(triangle.v0, triangle.v1, triangle.v2);
#if HAS_INSTANCES
        // Flat geometry keeps its own, tighter error.
        InstanceRecord placed = InstanceRecord_load_instances(hit.instance);
        bool is_placed = hit.instance != 0u;
        if (is_placed) {
            s.material = placed.material;
            s.p = instance_point(placed, s.p, s.error);
            s.ng = instance_normal(placed, s.ng);
        }
#endif
        s.ns = s.ng;
        FaceRecord face = FaceRecord_load_faces(triangle.face);
        s.point = triangle_point_data(face, hit.b1, hit.b2);
#if HAS_NORMALS
        NormalRecord n0 = NormalRecord_load_normals(face.vertices.x);
        float b0 = 1.0 - hit.b1 - hit.b2;
        vec3 n = n0.normal * b0 + NormalRecord_load_normals(face.vertices.y).normal * hit.b1
            + NormalRecord_load_normals(face.vertices.z).normal * hit.b2;
#if HAS_INSTANCES
        // Unit in the world before they are interpolated, as those of flat geometry: a picture does not depend on the levels.
        if (is_placed) {
            n = instance_normal(placed, n0.normal) * b0
                + instance_normal(placed, NormalRecord_load_normals(face.vertices.y).normal) * hit.b1
                + instance_normal(placed, NormalRecord_load_normals(face.vertices.z).normal) * hit.b2;
        }
#endif
        float length2 = dot(n, n);
        // Opposite vertex normals may cancel (1e-12: all digits gone): then the geometric normal stands.
        bool is_smooth = (face.flags & FACE_SMOOTH) != 0u && length2 > 1e-12;
        n = n * inversesqrt(max(length2, 1e-30));
        n = dot(n, s.ng) < 0.0 ? -n : n;
        s.ns = is_smooth ? n : s.ng;
#if HAS_TANGENTS
        vec3 t = TangentRecord_load_tangents(face.vertices.x).tangent * b0
            + TangentRecord_load_tangents(face.vertices.y).tangent * hit.b1
            + TangentRecord_load_tangents(face.vertices.z).tangent * hit.b2;
        s.tangent = (face.flags & FACE_TANGENTS) != 0u ? vec4(t, n0.handedness) : vec4(0.0);
#if HAS_INSTANCES
        if (is_placed && (face.flags & FACE_TANGENTS) != 0u) {
            t = instance_tangent(placed, TangentRecord_load_tangents(face.vertices.x).tangent) * b0
                + instance_tangent(placed, TangentRecord_load_tangents(face.vertices.y).tangent) * hit.b1
                + instance_tangent(placed, TangentRecord_load_tangents(face.vertices.z).tangent) * hit.b2;
            s.tangent = vec4(t, (placed.flags & INSTANCE_MIRRORED) != 0u ? -n0.handedness : n0.handedness);
        }
#endif
#endif
#endif
    }
#endif
#if HAS_SPHERES
    if (hit.kind == HIT_SPHERE) {
        SphereRecord sphere = SphereRecord_load_spheres(hit.slot);
        s.material = sphere.material;
        s.light = sphere.light;
        s.ng = sphere_normal(ray.o + hit.t * ray.d, sphere.center);
        s.p = sphere_point(s.ng, sphere.center, sphere.radius, s.error);
        s.ns = s.ng;
        s.point = sphere_point_data(sphere, s.ng);
#if HAS_TANGENTS
        // Towards growing u: the derivative of the point by the azimuth about the sphere's own y axis.
        vec3 axis = quaternion_rotate(vec4(-sphere.rotation.xyz, sphere.rotation.w), vec3(0.0, 1.0, 0.0));
        // u grows to the left seen from outside, and a normal map's y points up the picture: hence the sign.
        s.tangent = vec4(cross(s.ng, axis), -sphere.handedness);
#endif
    }
#endif
#if HAS_DISCS
    if (hit.kind == HIT_DISC) {
        DiscRecord disc = DiscRecord_load_discs(hit.slot);
        s.material = disc.material;
        s.light = disc.light;
        s.ng = disc.normal;
        s.p = disc_point(ray.o + hit.t * ray.d, disc.center, disc.normal, disc.radius, s.error);
        s.ns = s.ng;
        s.point = disc_point_data(disc, s.p);
#if HAS_TANGENTS
        s.tangent = vec4(disc.tangent, disc.handedness);
#endif
    }
#endif
    return s;
}
