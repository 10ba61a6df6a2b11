// Which surfaces are there for a path: alpha on top of traversal. Randomness at a hit hashes (path, vertex, ray kind, primitive),
// never the order of visits.

const uint RAY_CLOSEST = 0u;
const uint RAY_SHADOW = 1u;

#if HAS_ALPHA
bool alpha_is_present(Hit hit, Ray ray, uint path_hash, uint vertex, uint ray_kind) {
    uint material_index;
    SurfacePoint point = hit_point_data(hit, ray, material_index);
    MaterialRecord material = MaterialRecord_load_materials(material_index);
    float alpha = material_alpha(material, point);
    // A sphere is met twice; each time decides for itself.
    uint far_side = 0u;
#if HAS_SPHERES
    if (hit.kind == HIT_SPHERE) {
        vec3 outward = ray.o + hit.t * ray.d - SphereRecord_load_spheres(hit.slot).center;
        far_side = dot(outward, ray.d) > 0.0 ? 0x80000000u : 0u;
    }
#endif
    uint word = hash_combine(hash_combine(path_hash, vertex * 2u + ray_kind), hit.primitive ^ far_side);
    bool is_masked = (material.flags & MATERIAL_MASK) != 0u;
    bool is_blended = (material.flags & MATERIAL_BLEND) != 0u;
    bool blend_present = alpha >= 1.0 || word < probability_threshold(clamp(alpha, 0.0, 1.0));
    return is_masked ? alpha >= material.alpha_cutoff : (!is_blended || blend_present);
}
#endif

#if !MEDIA_STACK
// Nearest surface that is there for this path. The one behind ALPHA_LAYERS that are not is taken as there, and counted.
Hit trace_path(Ray ray, uint path_hash, uint vertex, inout Tally tally) {
    Hit hit = trace_closest_from(ray, 0.0, NONE);
#if HAS_ALPHA
    uint layer = 0u;
    while (layer < ALPHA_LAYERS && hit.kind != NO_HIT && !alpha_is_present(hit, ray, path_hash, vertex, RAY_CLOSEST)) {
        hit = trace_closest_from(ray, hit.t, hit.primitive);
        layer += 1u;
    }
    tally.alpha_overflow += layer == ALPHA_LAYERS && hit.kind != NO_HIT ? 1u : 0u;
#endif
    return hit;
}

#if NEXT_EVENT
// Nothing stands between the ray's ends; the light's own primitive does not count.
bool is_visible(Ray ray, uint excluded, uint path_hash, uint vertex, inout Tally tally) {
#if HAS_ALPHA
    Hit hit = trace_closest_from(ray, 0.0, NONE);
    uint layer = 0u;
    while (layer < ALPHA_LAYERS && hit.kind != NO_HIT
        && (hit.primitive == excluded || !alpha_is_present(hit, ray, path_hash, vertex, RAY_SHADOW))) {
        hit = trace_closest_from(ray, hit.t, hit.primitive);
        layer += 1u;
    }
    tally.alpha_overflow += layer == ALPHA_LAYERS && hit.kind != NO_HIT ? 1u : 0u;
    return hit.kind == NO_HIT;
#else
    return !trace_any(ray, excluded);
#endif
}
#endif
#endif
