// Edges of a path through media, and which boundaries of media are there. See src/prepare/media.rs.
//
// One medium: a path is in it or not. MEDIA_STACK, where dielectrics overlap: what a path is in stands in media_stack.glsl. A boundary
// that does not change which medium fills the space is not there, and what is there refracts between the two media that do fill it.

#if MEDIA_STACK
// Surfaces nearer to each other than this, relative to where they are, touch: f32 cannot order their hits (32 roundings).
const float TOUCHING = 1.9073486328125e-6;

// Where an edge ends, and between which media.
struct EdgeEnd {
    Hit hit;
    uvec4 medium;      // on the edge's last stretch
    uvec4 beyond;      // behind the surface
    float outside;     // index of refraction on the surface's front side, or where the path is if it bounds nothing
    float touching;    // surfaces up to this far away were taken as one, m
    Spectrum through;  // transmittance of the edge
};

// The first surface along the ray that is there: present by its alpha, and changing the medium if it bounds one. `excluded` is passed.
EdgeEnd trace_media(Ray ray, uvec4 medium, uint excluded, uint path_hash, uint vertex, uint ray_kind, inout Tally tally) {
    EdgeEnd e;
    e.medium = medium;
    e.beyond = medium;
    e.outside = 1.0;
    e.touching = 0.0;
    e.through = Spectrum(1.0);
    // Boundaries that touch gather at a place: crossed together, they are one change of medium.
    bool is_open = false;
    float place = 0.0;
    float reach = 0.0;
    uint place_entry = 0u;
    bool is_entered = false;
    float absorbed = 0.0;
    uint layer = 0u;
    Hit next = trace_closest_from(ray, 0.0, NONE);
    e.hit = next;
    bool is_searching = true;
    while (is_searching) {
        bool is_hit = next.kind != NO_HIT;
        bool is_there = is_hit && next.primitive != excluded;
#if HAS_ALPHA
        is_there = is_there && alpha_is_present(next, ray, path_hash, vertex, ray_kind);
#endif
        Surface surface = surface_load(next, ray);
        MaterialRecord material = MaterialRecord_load_materials(surface.material);
        uint entry = is_there ? medium_entry(material) : 0u;
        bool stops = !is_hit || is_there;
        bool joins = is_open && entry != 0u && next.t - place <= reach;
        bool closes = is_open && stops && !joins;
        bool is_change = media_current(e.medium) != media_current(e.beyond);
        bool is_end = closes ? is_change : stops && entry == 0u;
        // The surface behind ALPHA_LAYERS others that are not there is taken as there.
        bool is_far = !closes && !is_end && layer == ALPHA_LAYERS;
        tally.alpha_overflow += is_far ? 1u : 0u;
        is_end = is_end || is_far;
        // Absorption up to the place just closed, or to the end.
        float until = closes ? place : min(next.t, ray.t_max);
        Spectrum stretch = medium_transmittance(medium_row(media_current(e.medium)), until - absorbed);
        e.through *= closes || is_end ? stretch : Spectrum(1.0);
        absorbed = closes ? place : absorbed;
        is_open = is_open && !closes;
        if (closes) {
            // A boundary that is there, or a hidden one; after that, what comes next is looked at again.
            e.outside = medium_eta(media_current(is_entered ? e.medium : e.beyond));
            e.medium = is_change ? e.medium : e.beyond;
        } else if (is_end) {
            // A surface that bounds nothing, none, or one too many.
            e.hit = next;
            e.beyond = e.medium;
            e.touching = 0.0;
            e.outside = medium_eta(media_current(e.medium));
        } else {
            if (entry != 0u) {
                bool is_front = dot(surface.ng, ray.d) < 0.0;
                bool opens = !is_open;
                e.beyond = opens ? e.medium : e.beyond;
                // An open surface met from behind: the path has been inside all along.
                e.medium = opens && !is_front && e.medium.x == 0u ? media_enter(e.medium, entry) : e.medium;
                tally.media_overflow += is_front && e.beyond.w != 0u ? 1u : 0u;
                e.beyond = is_front ? media_enter(e.beyond, entry) : media_leave(e.beyond, entry);
                // The place's surface is that of the highest rank.
                bool is_chosen = opens || (entry >> 16) > (place_entry >> 16);
                if (is_chosen) {
                    e.hit = next;
                    place_entry = entry;
                    is_entered = is_front;
                }
                float grazing = max(abs(dot(surface.ng, ray.d)), 0.02);
                reach = opens ? TOUCHING * (max_component(abs(surface.p)) + next.t) / grazing : reach;
                e.touching = opens ? 0.0 : 2.0 * reach;
                place = opens ? next.t : place;
                is_open = true;
            }
            layer += 1u;
            next = trace_closest_from(ray, next.t, next.primitive);
        }
        is_searching = !is_end;
    }
    return e;
}
#endif

// The edge that the path is about to make; what is absorbed on it has left the throughput.
Hit trace_edge(inout PathState s, inout Tally tally) {
#if MEDIA_STACK
    EdgeEnd e = trace_media(s.ray, s.medium, NONE, s.hash, s.edge, RAY_CLOSEST, tally);
    s.throughput *= e.through;
    s.medium = e.medium;
    s.beyond = e.beyond;
    s.outside = e.outside;
    s.touching = e.touching;
    return e.hit;
#else
    Hit hit = trace_path(s.ray, s.hash, s.edge, tally);
#if HAS_MEDIA
    s.throughput *= medium_transmittance(s.medium, hit.t);
#endif
    return hit;
#endif
}

#if HAS_MEDIA && NEXT_EVENT
// Light reaches the start of `ray`, which lies in `inside`; `light` loses what is absorbed.
bool light_arrives(PathState s, Ray ray, uint excluded, Inside inside, inout Spectrum light, inout Tally tally) {
#if MEDIA_STACK
    EdgeEnd e = trace_media(ray, inside, excluded, s.hash, s.edge, RAY_SHADOW, tally);
    light *= e.through;
    return e.hit.kind == NO_HIT;
#else
    light *= medium_transmittance(inside, ray.t_max);
    return is_visible(ray, excluded, s.hash, s.edge, tally);
#endif
}
#endif

#if HAS_MEDIA
// The medium behind the surface towards `w`; a thin wall changes nothing.
Inside medium_beyond(PathState s, Surface surface, MaterialRecord material, vec3 w) {
#if MEDIA_STACK
    return s.beyond;
#else
    // Its interior on the way in, none on the way out.
    uint beyond = dot(w, surface.ng) < 0.0 ? material.interior : NONE;
    return (material.flags & MATERIAL_THIN) != 0u ? s.medium : beyond;
#endif
}
#endif
