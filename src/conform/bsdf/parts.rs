//! Gate 3 rows of the functions that models share: shaders/bsdf/{common,fresnel,ggx,ggx_albedo}.glsl.

use glam::DVec3;

use super::super::inputs::Inputs;
use super::super::probe::Probe;
use crate::bsdf::ggx::{self, Ggx};
use crate::bsdf::{dielectric_albedo, fresnel, ggx_albedo};

const FRESNEL: &[&str] = &["bsdf/common.glsl", "bsdf/fresnel.glsl"];
const GGX: &[&str] = &["bsdf/common.glsl", "bsdf/ggx.glsl"];
const ALBEDO: &[&str] =
    &["bsdf/common.glsl", "bsdf/fresnel.glsl", "bsdf/ggx.glsl", "bsdf/ggx_albedo.glsl", "bsdf/coat.glsl"];

pub fn probes() -> Vec<Probe> {
    let mut rows = fresnel_rows();
    rows.extend(ggx_rows());
    rows.extend(albedo_rows());
    rows.extend(dielectric_albedo_rows());
    rows.push(
        Probe::bits(
            "bsdf_is_chosen",
            "m0 = bsdf_is_chosen(n0, uintBitsToFloat(n1)) ? 1u : 0u;",
            choice,
            |[bits, p]| {
                let p = f64::from(f32::from_bits(p));
                [u32::from(crate::bsdf::is_chosen(bits, p))]
            },
        )
        .files(&["bsdf/common.glsl"]),
    );
    rows
}

fn choice(r: &mut Inputs) -> [u32; 2] {
    let p = r.range(0.0, 1.0);
    // Often right at the threshold.
    let near = (f64::from(p) * 4_294_967_296.0) as u32;
    let bits = if r.once_in(2) { r.word_or_edge() } else { near.wrapping_add(r.below(3)).wrapping_sub(1) };
    [bits, p.to_bits()]
}

fn index(r: &mut Inputs) -> f32 {
    if r.once_in(8) { r.pick(&[1.0, 1.000_000_1, 0.999_999_9, 1.001, 0.999, 10.0, 0.1]) } else { r.log(0.3, 3.0) }
}

fn cosine(r: &mut Inputs) -> f32 {
    if r.once_in(4) { r.log(1e-8, 1.0) } else { r.range(0.0, 1.0) }
}

/// 1 - F needs its own formula in f64 too once 1 - cos^2 rounds.
fn fresnel_rows() -> Vec<Probe> {
    vec![
        Probe::real(
            "fresnel_dielectric",
            "vec3 f = fresnel_dielectric(x0, x1); y0 = f.x; y1 = f.y; y2 = f.z;",
            |r| [cosine(r), index(r)],
            |[c, eta]| {
                let (f, cos_t) = fresnel::dielectric(c, eta);
                [f, cos_t, 1.0 - f]
            },
        )
        .files(FRESNEL)
        .k(128.0)
        .within(0.0, 1.0)
        .absolute(
            1e-12,
            "r_parallel passes through 0 at Brewster's angle: its square is held to (1e-6)^2; eta - 1 rounds to 1, \
             ten times an eta of 0.1",
        ),
        Probe::real(
            "fresnel_conductor",
            "y0 = fresnel_conductor(x0, vec3(x1), vec3(x2)).x;",
            |r| [cosine(r), r.range(0.0, 8.0), r.range(0.0, 8.0)],
            |[c, eta, k]| [fresnel::conductor_channel(c, eta, k)],
        )
        .files(FRESNEL)
        .k(16.0)
        .within(0.0, 1.000_001)
        .because("two quotients of sums of squares, a dozen operations each"),
        Probe::real(
            "fresnel_conductor_average",
            "y0 = fresnel_conductor_average(vec3(x0), vec3(x1)).x;",
            |r| [r.range(0.05, 8.0), r.range(0.0, 8.0)],
            |[eta, k]| [fresnel::conductor_average(DVec3::splat(eta), DVec3::splat(k)).x],
        )
        .files(FRESNEL)
        .k(16.0)
        .within(0.0, 1.0)
        .because("the fit cancels where F is small"),
        Probe::real(
            "fresnel_schlick",
            "y0 = fresnel_schlick(x0, vec3(x1)).x;",
            |r| [cosine(r), r.range(0.0, 1.0)],
            |[c, f]| [fresnel::schlick(c, DVec3::splat(f)).x],
        )
        .files(FRESNEL)
        .k(8.0)
        .within(0.0, 1.000_001),
        Probe::real(
            "one_minus_pow5",
            "y0 = one_minus_pow5(x0);",
            |r| [cosine(r)],
            |[x]| [x * (5.0 - x * (10.0 - x * (10.0 - x * (5.0 - x))))],
        )
        .files(FRESNEL)
        .k(16.0)
        .because("the terms sum to 31 times the result at x = 1"),
        Probe::real("pow5", "y0 = pow5(x0);", |r| [r.range(0.0, 1.0)], |[x]| [x.powi(5)]).files(FRESNEL),
    ]
}

fn widths(r: &mut Inputs) -> [f32; 2] {
    let x = r.log(1e-4, 1.0);
    [x, if r.once_in(2) { x } else { r.log(1e-4, 1.0) }]
}

fn surface(x: f64, y: f64) -> Ggx {
    Ggx { alpha_x: x, alpha_y: y, is_smooth: false }
}

fn v(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, y, z)
}

/// Alphas, and two directions of the upper half.
fn two_directions(r: &mut Inputs) -> [f32; 8] {
    let ([ax, ay], [a, b, c], [d, e, f]) = (widths(r), r.upper_direction(), r.upper_direction());
    [ax, ay, a, b, c, d, e, f]
}

fn one_direction(r: &mut Inputs) -> [f32; 5] {
    let ([ax, ay], [a, b, c]) = (widths(r), r.upper_direction());
    [ax, ay, a, b, c]
}

fn ggx_rows() -> Vec<Probe> {
    let with = |text: &str| format!("Ggx g = Ggx(vec2(x0, x1), false); {text}");
    vec![
        Probe::real(
            "ggx_from_roughness",
            "Ggx g = ggx_from_roughness(x0, x1); y0 = g.alpha.x; y1 = g.alpha.y;",
            |r| [r.range(0.0, 1.0), if r.once_in(2) { -1.0 } else { r.range(0.0, 1.0) }],
            |[x, y]| {
                let g = Ggx::from_roughness(x, y);
                [g.alpha_x, g.alpha_y]
            },
        )
        .files(GGX)
        .within(1e-4 * (1.0 - 1e-7), 1.0),
        Probe::real("ggx_d", &with("y0 = ggx_d(g, vec3(x2, x3, x4));"), one_direction, |[ax, ay, a, b, c]| {
            [surface(ax, ay).d(v(a, b, c))]
        })
        .files(GGX)
        .k(8.0)
        .within(0.0, 1e9),
        Probe::real("ggx_stretch", &with("y0 = ggx_stretch(g, vec3(x2, x3, x4));"), one_direction, |[ax, ay, a, b, c]| {
            [v(ax * a, ay * b, c).length()]
        })
        .files(GGX)
        .within(0.0, 1.000_001),
        Probe::real(
            "ggx_half",
            "vec3 h = ggx_half(vec3(x0, x1, x2) * x3); y0 = h.x; y1 = h.y; y2 = h.z;",
            |r| {
                let [a, b, c] = r.direction();
                [a, b, c, r.log(1e-30, 2.0)]
            },
            |[a, b, c, s]| (v(a, b, c) * s).try_normalize().unwrap_or(DVec3::Z).to_array(),
        )
        .files(GGX)
        .vector()
        .because("one vector, however short"),
        Probe::real(
            "ggx_reflection",
            &with("vec3 o = vec3(x2, x3, x4), i = vec3(x5, x6, x7); vec2 f = ggx_reflection(g, o, i, o); y0 = f.x; y1 = f.y;"),
            two_directions,
            |[ax, ay, a, b, c, d, e, f]| {
                // The facet is an argument of its own: here it is o.
                let (g, o, i) = (surface(ax, ay), v(a, b, c), v(d, e, f));
                [g.d(o) * g.g2(o, i) / (4.0 * o.z), g.d(o) * g.g1(o) / (4.0 * o.z)]
            },
        )
        .files(GGX)
        .k(16.0)
        .within(0.0, 1e12)
        .because("D, and one quotient of sums of positive terms"),
        Probe::real(
            "ggx_g2_over_g1",
            &with("y0 = ggx_g2_over_g1(g, vec3(x2, x3, x4), vec3(x5, x6, -x7));"),
            two_directions,
            |[ax, ay, a, b, c, d, e, f]| {
                let (g, o, i) = (surface(ax, ay), v(a, b, c), v(d, e, -f));
                [g.g2(o, i) / g.g1(o)]
            },
        )
        .files(GGX)
        .k(8.0)
        .within(0.0, 1.000_002),
        Probe::real(
            "ggx_refraction",
            &with(
                "vec3 o = vec3(x2, x3, x4), i = vec3(x5, x6, -x7); vec2 f = ggx_refraction(g, o, i, vec3(0.0, 0.0, 1.0), x8, x9); \
                 y0 = f.x; y1 = f.y;",
            ),
            |r| {
                let [ax, ay, a, b, c, d, e, f] = two_directions(r);
                [ax, ay, a, b, c, d, e, f, r.log(0.3, 3.0), r.log(1e-3, 3.0)]
            },
            |[ax, ay, a, b, c, d, e, f, eta, l]| {
                let (g, o, i) = (surface(ax, ay), v(a, b, c), v(d, e, -f));
                let jacobian = f * (eta / l).powi(2);
                [g.d(DVec3::Z) * g.g2(o, i) * jacobian, g.visible_pdf(o, DVec3::Z) * jacobian]
            },
        )
        .files(GGX)
        .k(16.0)
        .within(0.0, f64::INFINITY),
        Probe::real(
            "ggx_sample_visible",
            &with("vec3 h = ggx_sample_visible(g, vec3(x2, x3, x4), vec2(x5, x6)); y0 = h.x; y1 = h.y; y2 = h.z;"),
            |r| {
                let [ax, ay, a, b, c] = one_direction(r);
                [ax, ay, a, b, c, r.unit(), r.unit()]
            },
            |[ax, ay, a, b, c, u, w]| surface(ax, ay).sample_visible(v(a, b, c), [u, w]).to_array(),
        )
        .files(GGX)
        .vector()
        .k(32.0)
        .because("one vector; a dozen operations, and the sine and cosine of an angle that u gives"),
        Probe::real(
            "ggx_reflect",
            "vec3 w = ggx_reflect(vec3(x0, x1, x2), vec3(x3, x4, x5)); y0 = w.x; y1 = w.y; y2 = w.z;",
            |r| {
                let ([a, b, c], [d, e, f]) = (r.direction(), r.direction());
                [a, b, c, d, e, f]
            },
            |[a, b, c, d, e, f]| ggx::reflect(v(a, b, c), v(d, e, f)).to_array(),
        )
        .files(GGX)
        .vector()
        .k(8.0),
    ]
}

fn dielectric_albedo_rows() -> Vec<Probe> {
    let rows = || crate::bsdf::table_rows("dielectric_deficit").unwrap_or_default();
    let bits = move || rows().iter().map(|r| r.map(f32::to_bits)).collect::<Vec<_>>();
    let place = |n: f64| dielectric_albedo::index_place(n);
    let probes = vec![
        Probe::real(
            "dielectric_albedo_at",
            "vec2 d = dielectric_albedo_at(x0, 1.0 - x0, x1, dielectric_albedo_index(x2)); y0 = d.x; y1 = d.y;",
            |r| [cosine(r).max(1e-8), r.log(1e-4, 1.0), r.range(1.001, 4.0)],
            move |[mu, alpha, n]| dielectric_albedo::table().at(mu, alpha, place(n)),
        )
        .k(64.0)
        .within(0.0, 1.0)
        .absolute(1e-6, "the place within a cell is a difference of numbers up to 23^2, or up to 16"),
        Probe::real(
            "dielectric_albedo_average",
            "vec2 d = dielectric_albedo_average(x0, dielectric_albedo_index(x1)); y0 = d.x; y1 = d.y; \
             y2 = fresnel_dielectric_average(x1);",
            |r| [r.log(1e-4, 0.999), r.range(1.001, 4.0)],
            move |[alpha, n]| {
                let d = dielectric_albedo::table().average(alpha, place(n));
                [d[0], d[1], fresnel::dielectric_average(n)]
            },
        )
        .k(64.0)
        .within(0.0, 1.0)
        .absolute(1e-6, "the place among the indices is a difference of numbers up to 16"),
    ];
    let files = ["bsdf/common.glsl", "bsdf/fresnel.glsl", "bsdf/dielectric_albedo.glsl"];
    probes.into_iter().map(|p| p.files(&files).table("dielectric_deficit", bits())).collect()
}

fn albedo_rows() -> Vec<Probe> {
    let coat = |roughness: f64, f0: f64, weight: f64| crate::bsdf::coat::Coat::new(roughness, f0, weight);
    let rows = || ggx_albedo::rows().iter().map(|r| r.map(f32::to_bits)).collect::<Vec<_>>();
    let probes = vec![
        Probe::real(
            "ggx_albedo_at",
            "vec3 a = ggx_albedo_at(x0, x1); y0 = a.x; y1 = a.y; y2 = a.z;",
            |r| [cosine(r).max(1e-8), r.log(1e-4, 1.0)],
            |[mu, alpha]| {
                let a = ggx_albedo::table().at(mu, alpha);
                [a.deficit, a.schlick, 1.0 - a.schlick]
            },
        )
        .k(64.0)
        .within(0.0, 1.0)
        .absolute(1e-7, "the place within a cell is a difference of numbers up to 47^2"),
        Probe::real(
            "ggx_albedo_average",
            "vec2 a = ggx_albedo_average(x0); y0 = a.x; y1 = a.y;",
            |r| [r.log(1e-4, 0.999)],
            |[alpha]| {
                let a = ggx_albedo::table().average(alpha);
                [a.deficit, a.schlick]
            },
        )
        .k(8.0)
        .within(0.0, 1.0),
        Probe::real(
            "ggx_multiple_scattering",
            "y0 = ggx_multiple_scattering(x0, x1, x2, x3);",
            |r| [r.range(0.0, 0.7), r.range(0.0, 0.7), r.log(1e-8, 0.6), cosine(r)],
            |[a, b, average, cos]| [a * b * cos / (std::f64::consts::PI * average)],
        )
        .k(8.0),
        Probe::real(
            "ggx_multiple_scattering_color",
            "y0 = ggx_multiple_scattering_color(vec3(x0), x1).x;",
            |r| [r.range(0.0, 1.0), r.range(0.0, 0.6)],
            |[f, average]| [f * f * (1.0 - average) / (1.0 - f * average)],
        )
        .k(8.0)
        .within(0.0, 1.000_001),
        Probe::real(
            "coat_shares",
            "Coat c = coat_new(x0, x1, x2); vec2 s = coat_shares(c, x3); y0 = s.x; y1 = s.y; y2 = coat_through_average(c); \
             y3 = coat_fresnel(c, x3);",
            |r| {
                let roughness = if r.once_in(4) { 0.0 } else { r.range(0.0317, 1.0) };
                [roughness, r.range(0.0, 1.0), r.range(0.0, 1.0), cosine(r).max(1e-8)]
            },
            move |[roughness, f0, weight, mu]| {
                let c = coat(roughness, f0, weight);
                [c.through(mu), c.reflected(mu), c.through_average(), c.fresnel(mu)]
            },
        )
        .k(64.0)
        .within(0.0, 1.000_001)
        .absolute(1e-7, "the table's place within a cell"),
    ];
    probes.into_iter().map(|p| p.files(ALBEDO).table("ggx_albedo", rows())).collect()
}
