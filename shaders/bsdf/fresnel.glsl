// Fresnel reflectance in f32, arranged so that no difference of nearly equal numbers is left; f64 twin: src/bsdf/fresnel.rs.

// Reflectance in x, cosine on the other side in y (0 under total reflection), transmittance 1 - x in z. cos_o in [0,1]; eta: index there / index here.
// eta^2 cos_t^2 = (eta-1)(eta+1) + cos_o^2 and eta^2 cos_t^2 - cos_o^2 = eta^2 - 1 replace the subtractions of Born and Wolf
// 1.5.2 (20): near eta = 1 and at grazing every digit stays; near the critical angle the error is that of one ulp of cos_o.
// For eta^2 < 1/2 the same number is eta^2 - sin_o^2, whose terms are the smaller ones (found at eta = 0.1, cos_o = 0.9995).
vec3 fresnel_dielectric(float cos_o, float eta) {
    float e = (eta - 1.0) * (eta + 1.0);
    float sin2 = (1.0 - cos_o) * (1.0 + cos_o);
    float eta2 = eta * eta;
    float t2 = eta2 < 0.5 ? eta2 - sin2 : e + cos_o * cos_o;
    float eta_cos_t = safe_sqrt(t2);
    float cos_t = eta_cos_t / eta;
    float a = cos_o + eta_cos_t;
    float b = eta * cos_o + cos_t;
    // A ratio is 1 where its denominator vanishes: grazing incidence.
    float r_perpendicular = a > 0.0 ? e / (a * a) : 1.0;
    float r_parallel = b > 0.0 ? e * (eta2 * cos_o * cos_o - sin2) / (eta2 * b * b) : 1.0;
    float f = min(0.5 * (r_perpendicular * r_perpendicular + r_parallel * r_parallel), 1.0);
    // 1 - r^2 of both, as products.
    float t_perpendicular = a > 0.0 ? eta_cos_t / (a * a) : 0.0;
    float t_parallel = b > 0.0 ? eta_cos_t / (b * b) : 0.0;
    float t = min(2.0 * cos_o * (t_perpendicular + t_parallel), 1.0);
    return t2 > 0.0 ? vec3(f, min(cos_t, 1.0), t) : vec3(1.0, 0.0, 0.0);
}

// 2 int F(mu) mu dmu from outside, n >= 1 (the fit of Kulla and Conty 2017).
float fresnel_dielectric_average(float n) {
    return (n - 1.0) / (4.08567 + 1.00071 * n);
}

// Conductor of index eta - ik, per channel. a + ib = sqrt(n^2 - sin^2) by the root that adds; the amplitudes as sums of squares.
Spectrum fresnel_conductor(float cos_o, Spectrum eta, Spectrum k) {
    float sin2 = (1.0 - cos_o) * (1.0 + cos_o);
    Spectrum re = (eta - k) * (eta + k) - sin2;
    Spectrum ek = eta * k;
    Spectrum larger2 = 0.5 * (sqrt(re * re + 4.0 * ek * ek) + abs(re));
    Spectrum smaller2 = ek * ek / max(larger2, Spectrum(1e-30));
    Spectrum a2 = mix(smaller2, larger2, greaterThanEqual(re, Spectrum(0.0)));
    Spectrum b2 = mix(larger2, smaller2, greaterThanEqual(re, Spectrum(0.0)));
    Spectrum a = sqrt(a2);
    Spectrum minus = a - cos_o;
    Spectrum plus = a + cos_o;
    Spectrum below = plus * plus + b2;
    Spectrum r_perpendicular = mix(Spectrum(1.0), (minus * minus + b2) / max(below, Spectrum(1e-30)),
                                   greaterThan(below, Spectrum(1e-30)));
    minus = a * cos_o - sin2;
    plus = a * cos_o + sin2;
    Spectrum b_cos2 = b2 * (cos_o * cos_o);
    below = plus * plus + b_cos2;
    Spectrum ratio = mix(Spectrum(1.0), (minus * minus + b_cos2) / max(below, Spectrum(1e-30)),
                         greaterThan(below, Spectrum(1e-30)));
    return 0.5 * r_perpendicular * (1.0 + ratio);
}

float pow5(float x) {
    float x2 = x * x;
    return x2 * x2 * x;
}

// 1 - (1 - x)^5 with the digits of a small x.
float one_minus_pow5(float x) {
    return x * (5.0 + x * (-10.0 + x * (10.0 + x * (-5.0 + x))));
}

// Schlick 1994, eq. 15, f90 = 1.
Spectrum fresnel_schlick(float cos_o, Spectrum f0) {
    return f0 + (Spectrum(1.0) - f0) * pow5(1.0 - cos_o);
}

// 2 int F(mu) mu dmu of a conductor, by Schlick's curve bent to be exact at cos = 1/7; error stated at the f64 twin.
Spectrum fresnel_conductor_average(Spectrum eta, Spectrum k) {
    Spectrum f0 = fresnel_conductor(1.0, eta, k);
    const float mu = 1.0 / 7.0;
    // 7 (7/6)^6 = 1 / (mu (1-mu)^6)
    Spectrum a = (fresnel_schlick(mu, f0) - fresnel_conductor(mu, eta, k)) * 17.65138460219479;
    return clamp(f0 + (Spectrum(1.0) - f0) * (1.0 / 21.0) - a * (1.0 / 126.0), Spectrum(0.0), Spectrum(1.0));
}
