// Nearest hit, ordered by (t, primitive) so that the answer does not depend on the order of the visits.
//
// While-while over BVH4 nodes (Aila, Laine 2009, "Understanding the efficiency of ray traversal on GPUs"), nearest child first,
// the others on a stack of BVH_STACK entries (`Bvh::stack_size`), which no tree can outgrow. Written without early exits: on
// lavapipe a branch is never skipped. HAS_TRIANGLES, HAS_SPHERES, HAS_DISCS and HAS_INSTANCES leave out what the scene lacks.
// Two levels share the loop, the stack and the table of nodes: a leaf of kind 3 takes the ray into an instance's space and goes on at
// its mesh's root; below, the stack holds the world's own leaf word, which takes the ray back.

void sort_pair(inout float t0, inout uint w0, inout float t1, inout uint w1) {
    bool swap = t1 < t0;
    float t = swap ? t0 : t1;
    uint w = swap ? w0 : w1;
    t0 = swap ? t1 : t0;
    w0 = swap ? w1 : w0;
    t1 = t;
    w1 = w;
}

// Replaces `best` when the candidate lies after (t_after, primitive_after) and before `best`.
void offer_hit(inout Hit best, Hit candidate, float t_after, uint primitive_after) {
    bool is_after = (candidate.t > t_after) || (candidate.t == t_after && candidate.primitive > primitive_after);
    bool is_nearer = (candidate.t < best.t) || (candidate.t == best.t && candidate.primitive < best.primitive);
    bool take = is_after && is_nearer;
    best.t = take ? candidate.t : best.t;
    best.b1 = take ? candidate.b1 : best.b1;
    best.b2 = take ? candidate.b2 : best.b2;
    best.kind = take ? candidate.kind : best.kind;
    best.slot = take ? candidate.slot : best.slot;
    best.primitive = take ? candidate.primitive : best.primitive;
#if HAS_INSTANCES
    best.instance = take ? candidate.instance : best.instance;
#endif
}

// Start with t_after = 0, primitive_after = NO_HIT; go on with those of the last hit. t = INFINITY when missed.
Hit trace_closest_from(Ray ray, float t_after, uint primitive_after) {
    RaySpace space = world_space(ray);
    Hit best = hit_at(ray.t_max, 0.0, 0.0, NO_HIT, NO_HIT, 0u);
    // Boxes well behind the last hit are skipped; the margin is far above the rounding of a hit's distance.
    float t_min = 0.999 * t_after;
    uint stack[BVH_STACK];
    stack[0] = BVH_DONE;
    float entry[BVH_STACK];
    entry[0] = -1.0;
    uint top = 1u;
    uint current = 0u;
    while (current != BVH_DONE) {
        while ((current & BVH_LEAF_BIT) == 0u) {
            uint row = current * 7u;
            vec4 t = box_entries(space.boxes, row, t_min, best.t);
            uvec4 w = bvh_row(row + 6u);
            sort_pair(t.x, w.x, t.y, w.y);
            sort_pair(t.z, w.z, t.w, w.w);
            sort_pair(t.x, w.x, t.z, w.z);
            sort_pair(t.y, w.y, t.w, w.w);
            sort_pair(t.y, w.y, t.z, w.z);
            uint popped = stack[top - 1u];
            stack[top] = w.w;
            entry[top] = t.w;
            top += (t.w < INFINITY) ? 1u : 0u;
            stack[top] = w.z;
            entry[top] = t.z;
            top += (t.z < INFINITY) ? 1u : 0u;
            stack[top] = w.y;
            entry[top] = t.y;
            top += (t.y < INFINITY) ? 1u : 0u;
            bool is_entered = t.x < INFINITY;
            current = is_entered ? w.x : popped;
            top -= is_entered ? 0u : 1u;
        }
        bool is_leaf = current != BVH_DONE;
        uint first = leaf_first(current);
        uint end = is_leaf ? leaf_end(current) : first;
#if HAS_TRIANGLES
        uint end_triangle = (leaf_kind(current) == 0u) ? end : first;
        for (uint slot = first; slot < end_triangle; ++slot) {
            TriangleRecord r = TriangleRecord_load_triangles(slot);
            TriangleHit h = triangle_intersect(space.sheared, r.v0, r.v1, r.v2);
            Hit candidate = hit_at(h.t, h.b1, h.b2, 0u, slot, r.face);
#if HAS_INSTANCES
            candidate.primitive += space.primitive_offset;
            candidate.instance = space.instance;
#endif
            offer_hit(best, candidate, t_after, primitive_after);
        }
#endif
#if HAS_SPHERES
        uint end_sphere = (leaf_kind(current) == 1u) ? end : first;
        for (uint slot = first; slot < end_sphere; ++slot) {
            SphereRecord r = SphereRecord_load_spheres(slot);
            SphereHit h = sphere_intersect(ray.o, ray.d, r.center, r.radius);
            offer_hit(best, hit_at(h.near, 0.0, 0.0, 1u, slot, r.primitive), t_after, primitive_after);
            offer_hit(best, hit_at(h.far, 0.0, 0.0, 1u, slot, r.primitive), t_after, primitive_after);
        }
#endif
#if HAS_DISCS
        uint end_disc = (leaf_kind(current) == 2u) ? end : first;
        for (uint slot = first; slot < end_disc; ++slot) {
            DiscRecord r = DiscRecord_load_discs(slot);
            float t = disc_intersect(ray.o, ray.d, r.center, r.normal, r.radius);
            offer_hit(best, hit_at(t, 0.0, 0.0, 2u, slot, r.primitive), t_after, primitive_after);
        }
#endif
#if HAS_INSTANCES
        bool is_placed = is_leaf && leaf_kind(current) == 3u;
        bool enters = is_placed && current != INSTANCE_WORLD_WORD;
        uint root = 0u;
        if (is_placed) {
            root = space_enter(space, first, ray);
        }
        // The way back, kept only when something is entered, and never skipped.
        stack[top] = INSTANCE_WORLD_WORD;
        entry[top] = -1.0;
        top += enters ? 1u : 0u;
        current = enters ? root : current;
        bool pops = is_leaf && !enters;
#else
        bool pops = is_leaf;
#endif
        // What lies behind the nearest hit so far is not looked into.
        float limit = best.t * BVH_BOX_SLACK;
        while (pops) {
            top -= 1u;
            current = stack[top];
            pops = entry[top] > limit;
        }
    }
    bool is_hit = best.kind != NO_HIT;
    best.t = is_hit ? best.t : INFINITY;
    best.primitive = is_hit ? best.primitive : NO_HIT;
    return best;
}

Hit trace_closest(Ray ray) {
    return trace_closest_from(ray, 0.0, NO_HIT);
}
