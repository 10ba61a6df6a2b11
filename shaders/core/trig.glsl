// Trigonometry in f32 only; conventions and fits as in core/exp.glsl, twin src/math/special.rs.

// sin and cos of |x| <= 12800 (n < 2^13 keeps the first two products exact); NaN beyond, which no kernel asks for.
// pi/2 in three parts of 8, 11 and 24 bits (Cody and Waite 1980). Poly: sin 2^-27.2, cos 2^-32.
void m_sincos(float x, out float s, out float c) {
    bool is_inside = abs(x) <= 12800.0;
    float a = is_inside ? x : 0.0;
    float k = floor(a * 0.63661977236758134308 + 0.5);
    int n = int(k);
    precise float r = ((a - k * 1.5703125) - k * 0.0004837512969970703) - k * 7.549790126404332e-08;
    float t = r * r;
    float ps = (-0.00019510870333760977 * t + 0.008332131430506706) * t - 0.16666653752326965;
    float pc = (2.4432250938843936e-05 * t - 0.0013887316454201937) * t + 0.04166664555668831;
    float sr = r + r * t * ps;
    float cr = (1.0 - 0.5 * t) + t * t * pc;
    bool is_odd = (n & 1) != 0;
    float s0 = is_odd ? cr : sr;
    float c0 = is_odd ? sr : cr;
    s = is_inside ? ((n & 2) != 0 ? -s0 : s0) : NOT_A_NUMBER;
    c = is_inside ? (((n + 1) & 2) != 0 ? -c0 : c0) : NOT_A_NUMBER;
}

// asin(x)/x - 1 over t = x^2, for |x| <= 1/2. Poly 2^-27.2 of the whole.
float asin_core(float t) {
    float p = 0.042170051485300064;
    p = p * t + 0.024181624874472618;
    p = p * t + 0.04546872526407242;
    p = p * t + 0.07495325803756714;
    p = p * t + 0.16666750609874725;
    return p * t;
}

// |x| > 1 is taken as 1: a dot product may overshoot by rounding.
float m_asin(float x) {
    float a = min(abs(x), 1.0);
    bool is_steep = a > 0.5;
    float t = is_steep ? 0.5 - 0.5 * a : a * a;
    float z = is_steep ? sqrt(t) : a;
    float y = z + z * asin_core(t);
    // pi/2 - 2 asin(sqrt((1-a)/2)), the tail of pi/2 kept.
    precise float steep = HALF_PI - (2.0 * y + 4.371138828673793e-08);
    y = is_steep ? steep : y;
    return is_nan_bits(x) ? x : (x < 0.0 ? -y : y);
}

// |x| > 1 is taken as 1. Relative accuracy is kept near x = 1, where the result goes to 0 as sqrt(2(1-x)).
float m_acos(float x) {
    float a = min(abs(x), 1.0);
    bool is_steep = a > 0.5;
    float t = is_steep ? 0.5 - 0.5 * a : a * a;
    float z = is_steep ? sqrt(t) : a;
    float y = z + z * asin_core(t);
    // pi/2 = HALF_PI - 4.37e-8, pi = 2 HALF_PI - 8.74e-8: both tails kept.
    precise float middle = HALF_PI - ((x < 0.0 ? -y : y) + 4.371138828673793e-08);
    precise float back = PI - (2.0 * y + 8.742277657347586e-08);
    float r = is_steep ? (x < 0.0 ? back : 2.0 * y) : middle;
    return is_nan_bits(x) ? x : r;
}

// Angle of (x, y) in [-pi, pi]. atan2(0, 0) = 0; the sign of y counts when it is -0, that of a zero x does not;
// infinities as limits along the diagonal. Poly 2^-29.8.
float m_atan2(float y, float x) {
    float ax = abs(x);
    float ay = abs(y);
    float hi = max(ax, ay);
    float lo = min(ax, ay);
    // Powers of two keep hi + lo finite and small ratios normal.
    float scale = hi > 1e30 ? 5.421010862427522e-20 : (hi < 1e-18 ? 1.8446744073709552e19 : 1.0);
    bool is_far = is_inf_bits(hi);
    lo = is_far ? (is_inf_bits(lo) ? 1.0 : 0.0) : lo * scale;
    hi = is_far ? 1.0 : hi * scale;
    // atan(q) = pi/4 + atan((q-1)/(q+1)) above tan(pi/8).
    bool is_upper = lo > 0.41421356237309503 * hi;
    float den = is_upper ? hi + lo : hi;
    float q = den > 0.0 ? (is_upper ? lo - hi : lo) / den : 0.0;
    float t = q * q;
    float p = -0.06091289594769478;
    p = p * t + 0.10599637031555176;
    p = p * t - 0.1424444168806076;
    p = p * t + 0.19998528063297272;
    p = p * t - 0.33333316445350647;
    // The angle is sign * small + base, base among 0, pi/4, pi/2, ... with the tail of its rounding.
    float small = q + q * t * p;
    float quarters = is_upper ? 1.0 : 0.0;
    if (ay > ax) {
        small = -small;
        quarters = 2.0 - quarters;
    }
    if (x < 0.0) {
        small = -small;
        quarters = 4.0 - quarters;
    }
    precise float r = quarters * QUARTER_PI + (small - quarters * 2.1855694143368964e-08);
    r = uintBitsToFloat(floatBitsToUint(r) | (floatBitsToUint(y) & 0x80000000u));
    return is_nan_bits(x) || is_nan_bits(y) ? NOT_A_NUMBER : r;
}
