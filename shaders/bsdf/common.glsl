// What every model returns from `x_sample`; src/bsdf/mod.rs has the same struct in f64 and the conventions.
const uint SAMPLE_DELTA = 1u;
const uint SAMPLE_TRANSMISSION = 2u;

struct BsdfSample {
    vec3 wi;
    Spectrum weight;  // eval / pdf; 0 means absorbed
    float pdf;        // 1/sr, or a probability for a delta lobe; 0 means absorbed
    uint flags;
    float eta_scale;
};

BsdfSample bsdf_sample_none() {
    return BsdfSample(vec3(0.0, 0.0, 1.0), Spectrum(0.0), 0.0, 0u, 1.0);
}

// f |cos wi| and the density of sampling it, for models that find both at once.
struct BsdfValue {
    Spectrum value;
    float pdf;
};

// Whether a choice of probability p is taken by 32 random bits.
bool bsdf_is_chosen(uint bits, float p) {
    return p >= 1.0 || bits < probability_threshold(p);
}
