// Light arriving at a path vertex: sampled emitters (next-event estimation) and emitters that the path ran into, each with the weight
// of multiple importance sampling. The algorithm is stated in src/integrator/path.rs.

// Power heuristic with beta = 2 in a form that cannot overflow; `own` > 0. Veach 1997, eq. 9.13.
float mis_weight(float own, float other) {
    float r = other / own;
    return 1.0 / (1.0 + r * r);
}

#if NEXT_EVENT
struct LightSample {
    vec3 wi;
    float distance;
    float pdf;  // 1/sr, the choice of the light included
    Spectrum radiance;
    uint primitive;
    uint light;  // row of `lights`
};

LightSample light_sample(PathState s, vec3 p, vec3 n) {
    uint index = light_choose(p, n, path_word(s, LIGHT_INDEX), path_word(s, LIGHT_FRACTION));
    LightRecord light = LightRecord_load_lights(index);
    vec2 u = vec2(u01(path_word(s, LIGHT_U)), u01(path_word(s, LIGHT_V)));
    LightSample r = LightSample(vec3(0.0, 0.0, 1.0), 0.0, 0.0, Spectrum(0.0), NONE, index);
#if LIGHT_SKIES
    if (light.kind == LIGHT_SKY) {
        SkySample sky = sky_sample(path_word(s, SKY_INDEX), path_word(s, SKY_FRACTION), u);
        r = LightSample(sky.wi, INFINITY, sky.pdf, sky.radiance, NONE, index);
    }
#endif
#if LIGHT_TRIANGLES
    if (light.kind == LIGHT_TRIANGLE) {
        TriangleLightSample t = triangle_light_sample(p, light.a, light.b, light.c, u);
        MaterialRecord material = MaterialRecord_load_materials(light.material);
        SurfacePoint point = triangle_point_data(FaceRecord_load_faces(light.shape), t.b1, t.b2);
        bool is_front = dot(t.wi, triangle_normal(light.a, light.b, light.c)) < 0.0;
        bool shines = is_front || (material.flags & MATERIAL_EMITS_TWO_SIDED) != 0u;
        Spectrum radiance = shines ? material_emission(material, point) : Spectrum(0.0);
        r = LightSample(t.wi, t.distance, t.pdf, radiance, light.shape, index);
    }
#endif
#if LIGHT_SPHERES
    if (light.kind == LIGHT_SPHERE) {
        SphereLightSample q = sphere_light_sample(p, light.a, light.b.x, u);
        MaterialRecord material = MaterialRecord_load_materials(light.material);
        SphereRecord sphere = SphereRecord_load_spheres(light.shape);
        vec3 to_center = light.a - p;
        bool is_front = sphere_light_is_outside(p, light.a, light.b.x);
        SurfacePoint point = sphere_point_data(sphere, normalize(q.wi * q.distance - to_center));
        bool shines = is_front || (material.flags & MATERIAL_EMITS_TWO_SIDED) != 0u;
        Spectrum radiance = shines ? material_emission(material, point) : Spectrum(0.0);
        r = LightSample(q.wi, q.distance, q.pdf, radiance, sphere.primitive, index);
    }
#endif
    r.pdf *= light_pmf(p, n, index);
    return r;
}

// Solid-angle density with which `light_sample` from p and n would have found this emitter's front or back, choice included.
float light_pdf(uint index, vec3 p, vec3 n, vec3 wi, float distance, bool is_front) {
    float pdf = 0.0;
#if LIGHT_TRIANGLES || LIGHT_SPHERES
    LightRecord light = LightRecord_load_lights(index);
#if LIGHT_TRIANGLES
    if (light.kind == LIGHT_TRIANGLE) {
        pdf = triangle_light_pdf(p, light.a, light.b, light.c, wi, distance);
    }
#endif
#if LIGHT_SPHERES
    if (light.kind == LIGHT_SPHERE) {
        // The side that p does not see: reached through the sphere's own surface only, which light sampling does not try.
        pdf = sphere_light_is_outside(p, light.a, light.b.x) == is_front ? sphere_light_pdf(p, light.a, light.b.x) : 0.0;
    }
#endif
    pdf *= light_pmf(p, n, index);
#endif
    return pdf;
}
#endif

// Weight of emission that the path ran into by itself; `light_density` is 0 where light sampling cannot find it.
float emission_weight(PathState s, float light_density) {
    float weight = 1.0;
    bool counts_whole = s.pdf == 0.0 || light_density == 0.0;
#if ESTIMATOR_MIS
    weight = counts_whole ? 1.0 : mis_weight(s.pdf, light_density);
#elif ESTIMATOR_LIGHT
    weight = counts_whole ? 1.0 : 0.0;
#endif
    return weight;
}

#if HAS_SKY
void add_sky(inout PathState s) {
    float density = 0.0;
#if LIGHT_SKIES
    // Everything-on has a sky's text in scenes without one: its row is no light's.
    uint light = SkyRecord_load_sky(0u).light;
    density = light != NONE ? sky_pdf(s.ray.d) * light_pmf(s.from, s.from_normal, light) : 0.0;
#endif
    s.radiance += s.throughput * sky_radiance(s.ray.d) * emission_weight(s, density);
}
#endif

#if HAS_EMISSION
void add_emission(inout PathState s, Surface surface, MaterialRecord material, float distance) {
    bool is_front = dot(surface.ng, s.ray.d) < 0.0;
    bool shines = (material.flags & MATERIAL_EMITS) != 0u
        && (is_front || (material.flags & MATERIAL_EMITS_TWO_SIDED) != 0u);
    float density = 0.0;
#if NEXT_EVENT
    density = surface.light != NONE ? light_pdf(surface.light, s.from, s.from_normal, s.ray.d, distance, is_front) : 0.0;
#endif
    Spectrum emitted = shines ? material_emission(material, surface.point) : Spectrum(0.0);
    s.radiance += s.throughput * emitted * emission_weight(s, density);
}
#endif
