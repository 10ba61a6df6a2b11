// Constants and elementary functions in f32 only; the host's f64 twin is src/math/special.rs, the bounds are gate 3's.
// Drivers' own acos, atan, log, tanh, ... lose up to all digits, so kernels use these. Polynomials: minimax fits by Remez
// exchange (40 digits), coefficients rounded to f32; "poly 2^-k" is the relative error left by fit and rounding.
// A NaN argument gives NaN. `precise` stands where regrouping would lose the point of an expression.
#define Spectrum vec3

const float PI = 3.14159265358979323846;
const float INV_PI = 0.31830988618379067154;
const float TWO_PI = 6.28318530717958647692;
const float INV_TWO_PI = 0.15915494309189533577;
const float HALF_PI = 1.57079632679489661923;
const float QUARTER_PI = 0.78539816339744830962;
const float ONE_MINUS_EPS = 0.99999994039535522461;  // 0x3f7fffff, the largest float below 1
#define INFINITY (uintBitsToFloat(0x7f800000u))
#define NOT_A_NUMBER (uintBitsToFloat(0x7fc00000u))

bool is_nan_bits(float x) {
    return (floatBitsToUint(x) & 0x7fffffffu) > 0x7f800000u;
}

bool is_inf_bits(float x) {
    return (floatBitsToUint(x) & 0x7fffffffu) == 0x7f800000u;
}

float sqr(float x) {
    return x * x;
}

// sqrt of what rounding pushed below 0 is 0; NaN stays NaN.
float safe_sqrt(float x) {
    return sqrt(x < 0.0 ? 0.0 : x);
}

float max_component(vec3 v) {
    return max(v.x, max(v.y, v.z));
}

// Y of linear Rec.709 (ITU-R BT.709, item 3.2: 0.2126, 0.7152, 0.0722).
float luminance(vec3 rgb) {
    return dot(rgb, vec3(0.2126, 0.7152, 0.0722));
}

// A word to [0,1): 24 bits, so the result is exact and never 1.
float u01(uint bits) {
    return float(bits >> 8) * 5.9604644775390625e-08;
}

// A choice of probability p is taken when `word < threshold`; p >= 1 gives the largest word, NaN and p <= 0 give 0.
uint probability_threshold(float p) {
    uint below_one = uint((p > 0.0 && p < 1.0 ? p : 0.0) * 4294967296.0);
    return p >= 1.0 ? 0xffffffffu : below_one;
}

// Product and its rounding error, without fma: Veltkamp's split, Dekker 1971. |a|, |b| < 2^100.
vec2 two_product(float a, float b) {
    precise float p = a * b;
    precise float ca = 4097.0 * a;
    precise float ah = ca - (ca - a);
    precise float al = a - ah;
    precise float cb = 4097.0 * b;
    precise float bh = cb - (cb - b);
    precise float bl = b - bh;
    precise float e = ((ah * bh - p) + ah * bl + al * bh) + al * bl;
    return vec2(p, e);
}

// Sum and its rounding error (Knuth 1969).
vec2 two_sum(float a, float b) {
    precise float s = a + b;
    precise float bb = s - a;
    precise float e = (a - (s - bb)) + (b - bb);
    return vec2(s, e);
}

// a b - c d to about one rounding of the result, where the plain expression cancels (Kahan; Jeannerod et al. 2013 use fma).
float difference_of_products(float a, float b, float c, float d) {
    vec2 ab = two_product(a, b);
    vec2 cd = two_product(c, d);
    vec2 s = two_sum(ab.x, -cd.x);
    precise float r = s.x + (s.y + (ab.y - cd.y));
    return r;
}

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
