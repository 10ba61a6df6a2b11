// Constants, small functions, and sums and products with their rounding errors, in f32 only; the bounds are gate 3's.
// `precise` stands where regrouping would lose the point of an expression.
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
