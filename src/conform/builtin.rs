//! The device's own operations that kernels rely on, a row each, because Vulkan promises less than drivers give
//! (SPIR-V environment, "Precision and Operation of SPIR-V Instructions"). The bound is what the kernels' own bounds assume.

use super::inputs::Inputs;
use super::probe::Probe;
use half::f16;

const ASSUMED: &str = "assumed by the rows of the kernels' functions";

fn length(v: [f64; 3]) -> f64 {
    v.iter().map(|c| c * c).sum::<f64>().sqrt()
}

fn vector(r: &mut Inputs) -> [f32; 3] {
    [(); 3].map(|_| r.signed_log(1e-12, 1e12))
}

fn two(r: &mut Inputs) -> [f32; 2] {
    [r.signed_log(1e-18, 1e18), r.signed_log(1e-18, 1e18)]
}

pub fn probes() -> Vec<Probe> {
    let positive: fn(&mut Inputs) -> [f32; 1] = |r| [r.log(1e-37, 3e38)];
    let row = |name: &str, glsl: &str, generate: fn(&mut Inputs) -> [f32; 1], f: fn([f64; 1]) -> [f64; 1], k: f64| {
        Probe::real(name, glsl, generate, f).k(k).because(ASSUMED)
    };
    vec![
        row("builtin sqrt", "y0 = sqrt(x0);", positive, |[x]| [x.sqrt()], 1.0),
        row("builtin inversesqrt", "y0 = inversesqrt(x0);", positive, |[x]| [1.0 / x.sqrt()], 4.0),
        row("builtin 1/x", "y0 = 1.0 / x0;", |r| [r.signed_log(1e-37, 1e37)], |[x]| [1.0 / x], 1.0),
        Probe::real("builtin x/y", "y0 = x0 / x1;", two, |[x, y]| [x / y]).k(1.0).because(ASSUMED),
        Probe::real("builtin x*y, x+y, x-y", "y0 = x0 * x1; y1 = x0 + x1; y2 = x0 - x1;", two, |[x, y]| {
            [x * y, x + y, x - y]
        })
        .k(1.0)
        .because(ASSUMED),
        Probe::real(
            "builtin mix",
            "y0 = mix(x0, x1, x2);",
            |r| [r.range(-1.0, 1.0), r.range(-1.0, 1.0), r.unit()],
            |[a, b, t]| [a + (b - a) * t],
        )
        .k(4.0)
        .absolute(1e-7, "of the larger operand: it may be a + t (b - a)"),
        Probe::real(
            "builtin normalize",
            "vec3 v = normalize(vec3(x0, x1, x2)); y0 = v.x; y1 = v.y; y2 = v.z;",
            vector,
            |v| v.map(|c| c / length(v)),
        )
        .vector()
        .k(6.0)
        .because(ASSUMED),
        Probe::real("builtin length", "y0 = length(vec3(x0, x1, x2));", vector, |v| [length(v)])
            .k(4.0)
            .because(ASSUMED),
        Probe::real("builtin floor", "y0 = floor(x0);", |r| [r.signed_log(1e-9, 1e9)], |[x]| [x.floor()]).k(0.0),
        Probe::bits(
            "builtin min, max, clamp of finite",
            "m0 = floatBitsToUint(min(x0, x1)); m1 = floatBitsToUint(max(x0, x1)); m2 = floatBitsToUint(clamp(x0, 0.25, 0.75));",
            |r| two(r).map(f32::to_bits),
            |[a, b]| {
                let (x, y) = (f32::from_bits(a), f32::from_bits(b));
                [x.min(y), x.max(y), x.clamp(0.25, 0.75)].map(f32::to_bits)
            },
        ),
        Probe::bits(
            "builtin float(uint), uint(float)",
            "m0 = floatBitsToUint(float(n0 >> 8)); m1 = uint(float(n0 >> 8));",
            |r| [r.word_or_edge()],
            |[n]| [((n >> 8) as f32).to_bits(), n >> 8],
        ),
        Probe::bits(
            "builtin umulExtended, bitfieldReverse",
            "umulExtended(n0, n1, m0, m1); m2 = bitfieldReverse(n0);",
            |r| [r.word_or_edge(), r.word_or_edge()],
            |[a, b]| {
                let p = u64::from(a) * u64::from(b);
                [(p >> 32) as u32, p as u32, a.reverse_bits()]
            },
        ),
        Probe::bits(
            "builtin unpackHalf2x16",
            "vec2 h = unpackHalf2x16(n0); m0 = floatBitsToUint(h.x); m1 = floatBitsToUint(h.y);",
            |r| {
                // Finite halves of normal size or 0: pages hold no others but denormals, which a device may flush.
                let half = |w: u32| if w & 0x7c00 == 0 || w & 0x7c00 == 0x7c00 { 0 } else { w & 0xffff };
                let w = r.word();
                [half(w & 0xffff) | (half(w >> 16) << 16)]
            },
            |[n]| [n, n >> 16].map(|w| f16::from_bits(w as u16).to_f32().to_bits()),
        ),
    ]
}
