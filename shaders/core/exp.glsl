// Logarithm, exponential and what follows from them; the host's f64 twin is src/math/special.rs, the bounds are gate 3's.
// Drivers' own log, tanh, ... lose up to all digits, so kernels use these. Polynomials: minimax fits by Remez
// exchange (40 digits), coefficients rounded to f32; "poly 2^-k" is the relative error left by fit and rounding.
// A NaN argument gives NaN.

// log(1+f) for f in [sqrt(1/2)-1, sqrt(2)-1], as f - f^2/2 + f^3 P(f), plus k ln 2 and the small c. Poly 2^-27.2.
float log_core(float f, float k, float c) {
    float p = -0.07634498178958893;
    p = p * f + 0.127615824341774;
    p = p * f - 0.13160185515880585;
    p = p * f + 0.14201758801937103;
    p = p * f - 0.16623356938362122;
    p = p * f + 0.20001226663589478;
    p = p * f - 0.2500081956386566;
    p = p * f + 0.3333333134651184;
    float ff = f * f;
    // ln 2 as a head of 15 bits, so that k times it is exact, and a tail.
    precise float r = (k * 0.693145751953125) + (f + ((k * 1.428606765330187e-06 + c) + (ff * f * p - 0.5 * ff)));
    return r;
}

// ln x: 0 gives -inf, x < 0 NaN, +inf +inf. Denormals are scaled up first.
float m_log(float x) {
    bool is_small = x < 1.1754943508222875e-38;
    uint bits = floatBitsToUint(is_small ? x * 16777216.0 : x);
    // Mantissa in [sqrt(1/2), sqrt(2)): 0x3f3504f3 is sqrt(1/2).
    int k = int(bits - 0x3f3504f3u) >> 23;
    float m = uintBitsToFloat(bits - (uint(k) << 23));
    float r = log_core(m - 1.0, float(k) - (is_small ? 24.0 : 0.0), 0.0);
    r = x == 0.0 ? -INFINITY : r;
    r = x < 0.0 ? NOT_A_NUMBER : r;
    return is_nan_bits(x) || x == INFINITY ? x : r;
}

// ln(1+x), exact to rounding near 0: -1 gives -inf, below NaN.
float m_log1p(float x) {
    precise float u = 1.0 + x;
    // What the addition lost, relative to u.
    precise float lost = x >= 1.0 ? 1.0 - (u - x) : x - (u - 1.0);
    uint bits = floatBitsToUint(u);
    int k = int(bits - 0x3f3504f3u) >> 23;
    float f = k == 0 ? x : uintBitsToFloat(bits - (uint(k) << 23)) - 1.0;
    float c = k == 0 ? 0.0 : lost / u;
    float r = log_core(f, float(k), c);
    r = x == -1.0 ? -INFINITY : r;
    r = x < -1.0 ? NOT_A_NUMBER : r;
    return is_nan_bits(x) || x == INFINITY ? x : r;
}

// exp(r)-1 for |r| <= ln(2)/2, as r + r^2 P(r). Poly 2^-25.8.
float expm1_core(float r) {
    float p = 0.0013882488710805774;
    p = p * r + 0.008366710506379604;
    p = p * r + 0.04166720435023308;
    p = p * r + 0.16666541993618011;
    p = p * r + 0.4999999701976776;
    return r + r * r * p;
}

// 2^n for n in -126..127.
float exp2_int(int n) {
    return uintBitsToFloat(uint(n + 127) << 23);
}

// x - n ln 2 with n = round(x / ln 2), |x| < 130.
float exp_reduce(float x, out int n) {
    float k = floor(x * 1.4426950408889634 + 0.5);
    n = int(k);
    precise float r = (x - k * 0.693145751953125) - k * 1.428606765330187e-06;
    return r;
}

// e^x: overflows to inf, underflows through the denormals (where the device has them) to 0.
float m_exp(float x) {
    int n;
    float r = exp_reduce(clamp(x, -120.0, 120.0), n);
    // 2^n in two factors, for n below -126 and above 127.
    int h = n >> 1;
    float y = ((1.0 + expm1_core(r)) * exp2_int(h)) * exp2_int(n - h);
    return is_nan_bits(x) ? x : y;
}

// e^x - 1 without cancellation near 0.
float m_expm1(float x) {
    int n;
    // At 89 n is 128 and the result overflows; at -18 it is -1.
    float r = exp_reduce(clamp(x, -18.0, 89.0), n);
    // Half of 2^n, so that n = 128 does not overflow early.
    float s = exp2_int(n - 1);
    float y = 2.0 * (s * expm1_core(r) + (s - 0.5));
    y = n == 0 ? expm1_core(r) : y;
    return is_nan_bits(x) || x == INFINITY ? x : y;
}

float m_tanh(float x) {
    float t = m_expm1(2.0 * min(abs(x), 10.0));
    float y = t / (t + 2.0);
    return is_nan_bits(x) ? x : (x < 0.0 ? -y : y);
}

// x^y for x >= 0: x^0 = 1, 0^y = 0 or inf, x < 0 gives NaN. Relative error grows as |y ln x| eps, the conditioning in y.
float m_pow(float x, float y) {
    float r = m_exp(y * m_log(x));
    return y == 0.0 && !is_nan_bits(x) ? 1.0 : r;
}
