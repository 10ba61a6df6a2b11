// Whether anything lies on the ray: children in slot order, since the first hit ends the search and sorting costs more than it
// saves. Stack and structure as in closest.glsl.

bool trace_any(Ray ray, uint excluded_primitive) {
    RaySpace space = world_space(ray);
    bool is_hit = false;
    uint stack[BVH_STACK];
    stack[0] = BVH_DONE;
    uint top = 1u;
    uint current = 0u;
    while (current != BVH_DONE) {
        while ((current & BVH_LEAF_BIT) == 0u) {
            uint row = current * 7u;
            vec4 t = box_entries(space.boxes, row, 0.0, ray.t_max);
            uvec4 w = bvh_row(row + 6u);
            stack[top] = w.x;
            top += (t.x < INFINITY) ? 1u : 0u;
            stack[top] = w.y;
            top += (t.y < INFINITY) ? 1u : 0u;
            stack[top] = w.z;
            top += (t.z < INFINITY) ? 1u : 0u;
            bool is_entered = t.w < INFINITY;
            top -= is_entered ? 0u : 1u;
            current = is_entered ? w.w : stack[top];
        }
        bool is_leaf = current != BVH_DONE;
        uint first = leaf_first(current);
        uint end = is_leaf ? leaf_end(current) : first;
#if HAS_TRIANGLES
        uint end_triangle = (leaf_kind(current) == 0u) ? end : first;
        for (uint slot = first; slot < end_triangle; ++slot) {
            TriangleRecord r = TriangleRecord_load_triangles(slot);
            TriangleHit h = triangle_intersect(space.sheared, r.v0, r.v1, r.v2);
            uint primitive = r.face;
#if HAS_INSTANCES
            primitive += space.primitive_offset;
#endif
            is_hit = is_hit || (h.t > 0.0 && h.t < ray.t_max && primitive != excluded_primitive);
        }
#endif
#if HAS_SPHERES
        uint end_sphere = (leaf_kind(current) == 1u) ? end : first;
        for (uint slot = first; slot < end_sphere; ++slot) {
            SphereRecord r = SphereRecord_load_spheres(slot);
            SphereHit h = sphere_intersect(ray.o, ray.d, r.center, r.radius);
            bool near = h.near > 0.0 && h.near < ray.t_max;
            bool far = h.far > 0.0 && h.far < ray.t_max;
            is_hit = is_hit || ((near || far) && r.primitive != excluded_primitive);
        }
#endif
#if HAS_DISCS
        uint end_disc = (leaf_kind(current) == 2u) ? end : first;
        for (uint slot = first; slot < end_disc; ++slot) {
            DiscRecord r = DiscRecord_load_discs(slot);
            float t = disc_intersect(ray.o, ray.d, r.center, r.normal, r.radius);
            is_hit = is_hit || (t > 0.0 && t < ray.t_max && r.primitive != excluded_primitive);
        }
#endif
#if HAS_INSTANCES
        bool is_placed = is_leaf && leaf_kind(current) == 3u;
        bool enters = is_placed && current != INSTANCE_WORLD_WORD;
        uint root = 0u;
        if (is_placed) {
            root = space_enter(space, first, ray);
        }
        stack[top] = INSTANCE_WORLD_WORD;
        top += enters ? 1u : 0u;
        uint popped = enters ? root : stack[top - 1u];
        top -= (is_leaf && !enters && !is_hit) ? 1u : 0u;
        current = (is_leaf && !is_hit) ? popped : BVH_DONE;
#else
        uint popped = stack[top - 1u];
        top -= (is_leaf && !is_hit) ? 1u : 0u;
        current = (is_leaf && !is_hit) ? popped : BVH_DONE;
#endif
    }
    return is_hit;
}
