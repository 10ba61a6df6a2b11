//! Rows of shaders/core/{math,trig}.glsl.

use super::inputs::Inputs;
use super::probe::Probe;
use crate::math::special;
use crate::sampler;

fn vec3(x: &[f64]) -> glam::DVec3 {
    glam::DVec3::new(x[0], x[1], x[2])
}

/// acos and asin take what a rounding pushed past 1 as 1.
fn inside(x: f64) -> f64 {
    if x.is_nan() { x } else { x.clamp(-1.0, 1.0) }
}

/// Cosines: everywhere, and close to -1, 0 and 1 on both sides.
fn cosine(r: &mut Inputs) -> f32 {
    match r.below(4) {
        0 => r.pick(&[1.0, -1.0]) * (1.0 - r.log(1e-8, 1e-1)),
        1 => r.signed_log(1e-30, 1.0),
        2 if r.once_in(8) => r.pick(&[1.000_001, -1.000_001, f32::NAN, 2.0, -0.0, 0.5, -0.5]),
        _ => r.range(-1.0, 1.0),
    }
}

/// atan2 as decided: a zero x has no sign, the sign of y counts.
fn atan2(y: f64, x: f64) -> f64 {
    if x == 0.0 { y.atan2(0.0) } else { y.atan2(x) }
}

/// x^y for x >= 0, NaN below and for NaN; x^0 = 1.
fn pow(x: f64, y: f64) -> f64 {
    if x.is_nan() || y.is_nan() || (x < 0.0 && y != 0.0) {
        f64::NAN
    } else if y == 0.0 {
        1.0
    } else {
        x.powf(y)
    }
}

pub fn probes() -> Vec<Probe> {
    let one = |name: &str, glsl: &str, generate: fn(&mut Inputs) -> [f32; 1], f: fn([f64; 1]) -> [f64; 1]| {
        Probe::real(name, glsl, generate, f)
    };
    let mut rows = vec![
        one("m_acos", "y0 = m_acos(x0);", |r| [cosine(r)], |[x]| [inside(x).acos()]).k(3.0).within(0.0, 3.2),
        one("m_asin", "y0 = m_asin(x0);", |r| [cosine(r)], |[x]| [inside(x).asin()]).k(3.0),
        one("m_log", "y0 = m_log(x0);", |r| [r.any_float()], |[x]| [x.ln()]).k(3.0),
        one("m_log near 1", "y0 = m_log(x0);", |r| [1.0 + r.signed_log(1e-7, 0.5)], |[x]| [x.ln()]).k(3.0),
        one("m_log1p", "y0 = m_log1p(x0);", |r| [r.any_float()], |[x]| [x.ln_1p()]).k(3.0),
        one("m_log1p near 0", "y0 = m_log1p(x0);", |r| [r.signed_log(1e-10, 1.0)], |[x]| [x.ln_1p()]).k(3.0),
        one("m_exp", "y0 = m_exp(x0);", |r| [r.range(-104.0, 89.0)], |[x]| [x.exp()]).k(3.0).within(0.0, f64::INFINITY),
        one("m_exp any", "y0 = m_exp(x0);", |r| [r.any_float()], |[x]| [x.exp()]).k(3.0).within(0.0, f64::INFINITY),
        one("m_expm1", "y0 = m_expm1(x0);", |r| [r.range(-20.0, 89.0)], |[x]| [x.exp_m1()]).k(3.0),
        one("m_expm1 any", "y0 = m_expm1(x0);", |r| [r.any_float()], |[x]| [x.exp_m1()]).k(3.0),
        one("m_tanh", "y0 = m_tanh(x0);", |r| [r.range(-12.0, 12.0)], |[x]| [x.tanh()]).k(5.0).within(-1.0, 1.0),
        one("m_tanh any", "y0 = m_tanh(x0);", |r| [r.any_float()], |[x]| [x.tanh()]).k(5.0).within(-1.0, 1.0),
        Probe::real(
            "m_sincos",
            "m_sincos(x0, y0, y1);",
            |r| [if r.once_in(2) { r.range(-7.0, 7.0) } else { r.signed_log(1e-30, 12_800.0) }],
            |[x]| [x.sin(), x.cos()],
        )
        .k(3.0)
        .because("|x| <= 12800"),
        Probe::real(
            "m_sincos outside",
            "m_sincos(x0, y0, y1);",
            |r| [if r.once_in(2) { r.signed_log(12_801.0, 3e38) } else { r.pick(&[f32::INFINITY, f32::NAN]) }],
            |_| [f64::NAN; 2],
        )
        .because("NaN is the stated result beyond 12800"),
        Probe::real("m_atan2", "y0 = m_atan2(x0, x1);", |r| [r.any_float(), r.any_float()], |[y, x]| [atan2(y, x)])
            .k(3.0),
        Probe::real(
            "m_atan2 all angles",
            "y0 = m_atan2(x0, x1);",
            |r| {
                let d = r.direction();
                let size = r.log(1e-15, 1e15);
                [d[0] * size, d[1] * size]
            },
            |[y, x]| [atan2(y, x)],
        )
        .k(3.0),
        Probe::real(
            "m_pow",
            "y0 = m_pow(x0, x1);",
            |r| [if r.once_in(4) { r.any_float() } else { r.log(1e-6, 1e6) }, r.range(-20.0, 20.0)],
            |[x, y]| [pow(x, y)],
        )
        .k(4.0)
        .within(0.0, f64::INFINITY),
        Probe::real(
            "difference_of_products",
            "y0 = difference_of_products(x0, x1, x2, x3);",
            |r| {
                let (a, b) = (r.signed_log(1e-9, 1e9), r.signed_log(1e-9, 1e9));
                // Half of them cancel: c d is a b up to a few roundings.
                let c = r.signed_log(1e-9, 1e9);
                let d = if r.once_in(2) { r.signed_log(1e-9, 1e9) } else { (a * b) / c };
                [a, b, c, d]
            },
            |[a, b, c, d]| [special::difference_of_products(a, b, c, d)],
        )
        .k(4.0)
        .absolute(0.0, "relative to the result even where the products cancel; see the row without conditioning"),
        Probe::judged(
            "difference_of_products relative",
            "y0 = difference_of_products(x0, x1, x2, x3);",
            1,
            |r: &mut Inputs| {
                let (a, b, c) = (r.signed_log(1e-6, 1e6), r.signed_log(1e-6, 1e6), r.signed_log(1e-6, 1e6));
                [a, b, c, (a * b) / c]
            },
            |x, y| {
                let [a, b, c, d] = [x[0], x[1], x[2], x[3]].map(f64::from);
                let wanted = special::difference_of_products(a, b, c, d);
                (f64::from(y[0]) - wanted).abs() / (2.0 * super::probe::EPS * wanted.abs() + 1e-37)
            },
        )
        .because("2 eps |y|: Jeannerod et al. 2013 prove 1.5 ulp"),
        Probe::judged(
            "two_product, two_sum are exact",
            "vec2 p = two_product(x0, x1); vec2 s = two_sum(x0, x1); y0 = p.x; y1 = p.y; y2 = s.x; y3 = s.y;",
            4,
            |r: &mut Inputs| [r.signed_log(1e-9, 1e9), r.signed_log(1e-9, 1e9)],
            |x, y| {
                let [a, b] = [x[0], x[1]].map(f64::from);
                let [p, pe, s, se] = [y[0], y[1], y[2], y[3]].map(f64::from);
                // f64 holds a product of two f32 exactly; a sum only where exponents are near, so compare the parts.
                let sum = f64::from(x[0] + x[1]);
                let sum_error = if (a / b).abs().log2().abs() < 25.0 { (a + b) - sum } else { se };
                if p + pe == a * b && s == sum && se == sum_error { 0.0 } else { f64::INFINITY }
            },
        )
        .because("the parts add up to the exact result"),
    ];
    rows.extend(small());
    rows
}

fn small() -> Vec<Probe> {
    vec![
        Probe::real(
            "luminance",
            "y0 = luminance(vec3(x0, x1, x2));",
            |r| [(); 3].map(|_| r.log(1e-10, 1e10)),
            |x| [special::luminance(vec3(&x))],
        ),
        Probe::real(
            "max_component",
            "y0 = max_component(vec3(x0, x1, x2));",
            |r| [(); 3].map(|_| r.signed_log(1e-30, 1e30)),
            |x| [vec3(&x).max_element()],
        )
        .k(0.0),
        Probe::real("sqr", "y0 = sqr(x0);", |r| [r.signed_log(1e-18, 1e18)], |[x]| [x * x]).k(1.0),
        Probe::real(
            "safe_sqrt",
            "y0 = safe_sqrt(x0);",
            |r| [r.any_float()],
            |[x]| [if x < 0.0 { 0.0 } else { x.sqrt() }],
        )
        .within(0.0, f64::INFINITY),
        Probe::bits(
            "u01",
            "m0 = floatBitsToUint(u01(n0));",
            |r| [r.word_or_edge()],
            |[n]| [(sampler::u01(n) as f32).to_bits()],
        ),
        Probe::bits(
            "probability_threshold",
            "m0 = probability_threshold(x0);",
            |r| [if r.once_in(4) { r.any_float() } else { r.range(0.0, 1.0) }.to_bits()],
            |[n]| [sampler::probability_threshold(f32::from_bits(n))],
        ),
        Probe::bits(
            "is_nan_bits, is_inf_bits",
            "m0 = is_nan_bits(x0) ? 1u : 0u; m1 = is_inf_bits(x0) ? 1u : 0u;",
            |r| [if r.once_in(2) { r.any_float().to_bits() } else { r.word() | 0x7f80_0000 }],
            |[n]| [u32::from(f32::from_bits(n).is_nan()), u32::from(f32::from_bits(n).is_infinite())],
        ),
    ]
}
