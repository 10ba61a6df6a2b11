// What a path carries from vertex to vertex, and what its slot collects. Shader functions take it whole, so that one loop and a
// split plan can both be made from them.

// What a path knows of the media it is in: a row of `media`, or up to four entries (media.glsl).
#if MEDIA_STACK
#define Inside uvec4
#else
#define Inside uint
#endif

struct PathState {
    Ray ray;
    Spectrum throughput;
    Spectrum radiance;
    float pdf;        // of the last direction, 1/sr; 0 after the camera or a delta lobe: emission then counts whole
    float eta_scale;  // product of refraction's factors in the throughput
    uint edge;        // edges traced so far; also the vertex the ray leaves
    uint hash;        // of (pixel, sample, seed), for randomness at a hit
    SampleId id;
#if NEXT_EVENT
    vec3 from;  // the point light was last sampled from: densities of emitters run into must be for this very point
    vec3 from_normal;  // the shading normal there, which a choice of lights may look at
#endif
#if HAS_MEDIA
    Inside medium;
#endif
#if MEDIA_STACK
    // Of the edge just traced: see EdgeEnd.
    uvec4 beyond;
    float outside;
    float touching;
#endif
#if TEXTURE_HAS_MIPS
    vec2 cone;  // diameter of the ray's cone where it starts, m, and its growth a metre
#endif
#if AOV_SPLIT
    Spectrum direct;  // the part of radiance by paths of at most two edges
#endif
    AOV_MEMBERS
};

// Sums over the samples of a slot; the layout written out is src/film/slot.rs.
struct Tally {
    uint rays;
    uint nan;
    uint infinite;
    uint negative;
    uint disagree;
    uint depth;
    uint cut;  // samples that are missing
#if HAS_ALPHA || MEDIA_STACK
    uint alpha_overflow;
#endif
#if MEDIA_STACK
    uint media_overflow;
#endif
    float lost_energy;
    uint first_bad;
#if AOVS
    AovSums aovs;
#endif
};

// Light of a group that came by a path of `edges` edges: every contribution to a sample's radiance passes here. Where no groups are
// kept, LIGHT_GROUP is 0 whatever it is asked.
void path_gather(inout PathState s, Spectrum light, uint edges, uint group) {
    s.radiance += light;
#if AOV_SPLIT
    s.direct += edges <= 2u ? light : Spectrum(0.0);
#endif
    AOV_GATHER
}

uint path_word(PathState s, uvec2 purpose) {
    return sample_u32(s.id, s.edge, purpose);
}

#if HAS_MEDIA
// Beer-Lambert transmittance of `medium` over `distance` metres. 0 * infinity does not arise: a miss inside a medium transmits 0
// where it absorbs and 1 where it does not.
Spectrum medium_transmittance(uint medium, float distance) {
    bool is_inside = medium != NONE;
    Spectrum absorption = MediumRecord_load_media(is_inside ? medium : 0u).absorption;
    Spectrum depth = absorption * min(distance, 3.0e38);
    Spectrum through = Spectrum(m_exp(-depth.x), m_exp(-depth.y), m_exp(-depth.z));
    return is_inside ? through : Spectrum(1.0);
}
#endif
