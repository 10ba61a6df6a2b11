//! Rows of shaders/texture.

use std::sync::Arc;

use glam::{DVec2, DVec4};

use super::inputs::Inputs;
use super::probe::{EPS, Probe};
use crate::math::special::srgb_decode;
use crate::prepare::records::*;
use crate::scene::{Encoding, Filter, Image, Minify, Pixels, Wrap};
use crate::shader::record::GpuRecord;
use crate::texture;

/// Image sizes of the row: single texels, odd and even, one long.
const SIZES: [(u32, u32); 6] = [(1, 1), (2, 3), (5, 1), (16, 16), (67, 33), (2048, 2)];
const MACROS: [&str; 7] = [
    "TEXTURE_HAS_WIDE",
    "TEXTURE_HAS_MIPS",
    "TEXTURE_HAS_HALF",
    "TEXTURE_HAS_SRGB",
    "TEXTURE_HAS_NEAREST",
    "TEXTURE_HAS_MIRROR",
    "TEXTURE_HAS_CLAMP",
];

struct Pages {
    records: Vec<TextureRecord>,
    texels: Vec<[u32; 4]>,
    /// Largest value of each texture.
    largest: Vec<f64>,
}

/// How look-ups are minified: at a point, or by levels in every combination.
const MINIFY: [Minify; 4] = [
    Minify { filter: Filter::Linear, levels: Some(Filter::Linear) },
    Minify { filter: Filter::Nearest, levels: Some(Filter::Linear) },
    Minify { filter: Filter::Linear, levels: Some(Filter::Nearest) },
    Minify { filter: Filter::Nearest, levels: Some(Filter::Nearest) },
];

/// Every size in every format, wrap, filter and encoding that `is_wanted` keeps; `minify` None is at a point.
fn pages(minify: &[Option<Minify>], is_wanted: fn(&TextureRecord) -> bool) -> Pages {
    let mut pages = Pages { records: Vec::new(), texels: Vec::new(), largest: Vec::new() };
    let mut r = Inputs::new("texels", 0);
    for (width, height) in SIZES {
        let count = (width * height) as usize;
        let bytes = Pixels::Rgba8(Arc::new((0..4 * count).map(|_| (r.word() >> 24) as u8).collect()));
        let floats = Pixels::RgbF32(Arc::new((0..3 * count).map(|_| r.log(1e-3, 100.0)).collect()));
        let words = Pixels::Rgba16(Arc::new((0..4 * count).map(|_| (r.word() >> 16) as u16).collect()));
        for pixels in [bytes, words, floats] {
            let image = Image { name: String::new(), width, height, pixels };
            for (minify, encoding) in
                minify.iter().flat_map(|&m| [Encoding::Linear, Encoding::Srgb].map(|encoding| (m, encoding)))
            {
                pages.add(&image, minify, encoding, is_wanted);
            }
        }
    }
    pages
}

impl Pages {
    fn add(
        &mut self,
        image: &Image,
        minify: Option<Minify>,
        encoding: Encoding,
        is_wanted: fn(&TextureRecord) -> bool,
    ) {
        let has_levels = minify.is_some();
        let before = if has_levels { texture::mip::OFFSET_ROWS } else { 0 };
        let page = texture::Page { first_row: (self.texels.len() + before) as u32, has_levels };
        self.texels.extend(if has_levels {
            texture::pack_levels(image, encoding, false)
        } else {
            texture::pack(image)
        });
        let wraps = [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp];
        for (u, v) in wraps.iter().flat_map(|&u| wraps.iter().map(move |&v| (u, v))) {
            for filter in [Filter::Linear, Filter::Nearest] {
                let record = texture::record(image, [u, v], filter, minify, encoding, page);
                if is_wanted(&record) {
                    self.records.push(record);
                    self.largest.push(if record.flags & TEXTURE_HALF != 0 { 100.0 } else { 1.0 });
                }
            }
        }
    }
}

fn coordinate(r: &mut Inputs) -> f32 {
    match r.below(6) {
        0 => r.range(-2.0, 3.0),
        1 => r.signed_log(1e-12, 1e6),
        // Texel edges and centres of the sizes.
        2 => r.below(64) as f32 / r.pick(&[2.0, 4.0, 10.0, 32.0, 134.0, 4096.0]),
        3 if r.once_in(4) => {
            r.pick(&[f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e6, -1e6, 1e30, -0.0, -1e-30, 1.0, 16_777_216.0])
        }
        _ => r.unit(),
    }
}

/// Error over bound: 8 eps of the largest texel for the arithmetic, and the place, 2 eps of the image's size, times the slope, which
/// is at most the largest texel a step. A nearest lookup may take either texel where the place is within that of an edge.
fn judge(t: &TextureRecord, pages: &Pages, largest: f64, uv: DVec2, got: DVec4) -> f64 {
    let is_nearest = t.flags & TEXTURE_NEAREST != 0;
    let slope = if is_nearest { 0.0 } else { 4.0 * f64::from(t.width + t.height) };
    let allowed = EPS * largest * (8.0 + slope);
    let away = |at: DVec2| (texture::lookup(t, &pages.texels, at) - got).abs().max_element();
    let mut error = away(uv);
    if is_nearest && error > allowed {
        for (a, b) in [-1.0, 0.0, 1.0].iter().flat_map(|&a| [-1.0, 0.0, 1.0].map(|b| (a, b))) {
            error = error.min(away(uv + 2.0 * EPS * DVec2::new(a, b)));
        }
    }
    let is_out = got.min_element() < 0.0 || got.max_element() > largest * (1.0 + 4.0 * EPS);
    if is_out || !got.is_finite() { f64::INFINITY } else { error / allowed }
}

fn image_row(name: &str, is_on: bool) -> Probe {
    let pages = Arc::new(if is_on { pages(&[None], |_| true) } else { pages(&[None], |t| t.flags == 0) });
    let count = pages.records.len() as u32;
    let held = pages.clone();
    let row = Probe::judged(
        name,
        "vec4 v = texture_image(n0, vec2(x1, x2)); y0 = v.x; y1 = v.y; y2 = v.z; y3 = v.w;",
        4,
        move |r: &mut Inputs| [f32::from_bits(r.below(count)), coordinate(r), coordinate(r)],
        move |x, y| {
            let i = x[0].to_bits() as usize;
            let got = DVec4::new(y[0].into(), y[1].into(), y[2].into(), y[3].into());
            judge(&held.records[i], &held, held.largest[i], DVec2::new(x[1].into(), x[2].into()), got)
        },
    )
    .because("eps (8 + 4 (W + H)) of the largest texel: the rest of a coordinate times the size is rounded once");
    over_pages(row, &pages, is_on)
}

/// Footprints of any area.
fn footprint_row() -> Probe {
    let pages = Arc::new(pages(&MINIFY.map(Some), |t| {
        // The same wrap on both axes: `texture_image` has them all.
        (t.flags >> TEXTURE_WRAP_U_SHIFT) & 3 == (t.flags >> TEXTURE_WRAP_V_SHIFT) & 3
    }));
    let count = pages.records.len() as u32;
    let held = pages.clone();
    let area = |r: &mut Inputs| match r.below(8) {
        0 => r.pick(&[0.0, f32::NAN, f32::INFINITY, -1.0, 1e-30, 1e30, 1.0]),
        // Whole levels of the sizes.
        1 => (r.below(12) as f32 - 12.0).exp2(),
        _ => r.log(1e-8, 4.0),
    };
    let row = Probe::judged(
        "texture_image_footprint",
        "vec4 v = texture_image_footprint(n0, vec2(x1, x2), x3); y0 = v.x; y1 = v.y; y2 = v.z; y3 = v.w;",
        4,
        move |r: &mut Inputs| [f32::from_bits(r.below(count)), coordinate(r), coordinate(r), area(r)],
        move |x, y| {
            let i = x[0].to_bits() as usize;
            let got = DVec4::new(y[0].into(), y[1].into(), y[2].into(), y[3].into());
            let uv = DVec2::new(x[1].into(), x[2].into());
            judge_footprint(&held.records[i], &held, held.largest[i], uv, x[3].into(), got)
        },
    )
    .because(
        "as texture_image, and 40 eps of the largest texel for the level: a logarithm of 22 bits and two products",
    );
    over_pages(row, &pages, true)
}

/// Error over bound. Where the filter or the nearest level changes within the rounding of the area, either side is right.
fn judge_footprint(t: &TextureRecord, pages: &Pages, largest: f64, uv: DVec2, area: f64, got: DVec4) -> f64 {
    let allowed = EPS * largest * (48.0 + 4.0 * f64::from(t.width + t.height));
    let mut error = f64::INFINITY;
    for k in [0.0, -8.0, 8.0] {
        for (a, b) in [0.0, -1.0, 1.0].iter().flat_map(|&a| [0.0, -1.0, 1.0].map(|b| (a, b))) {
            let at = uv + 2.0 * EPS * DVec2::new(a, b);
            let v = texture::mip::lookup_footprint(t, &pages.texels, at, area * (1.0 + k * EPS));
            error = error.min((v - got).abs().max_element());
            if error <= allowed {
                break;
            }
        }
    }
    let is_out = got.min_element() < -4.0 * EPS * largest || got.max_element() > largest * (1.0 + 8.0 * EPS);
    if is_out || !got.is_finite() { f64::INFINITY } else { error / allowed }
}

/// The row with its tables and the functions that read them.
fn over_pages(row: Probe, pages: &Pages, is_on: bool) -> Probe {
    let constants = [
        ("TEXTURE_WRAP_U_SHIFT", TEXTURE_WRAP_U_SHIFT),
        ("TEXTURE_WRAP_V_SHIFT", TEXTURE_WRAP_V_SHIFT),
        ("TEXTURE_NEAREST", TEXTURE_NEAREST),
        ("TEXTURE_SRGB", TEXTURE_SRGB),
        ("TEXTURE_HALF", TEXTURE_HALF),
        ("TEXTURE_WIDE", TEXTURE_WIDE),
        ("TEXTURE_MIPS", TEXTURE_MIPS),
        ("TEXTURE_MIP_NEAREST", TEXTURE_MIP_NEAREST),
        ("TEXTURE_MIN_NEAREST", TEXTURE_MIN_NEAREST),
    ];
    let mut prelude: String = constants.iter().map(|(n, v)| format!("const uint {n} = {v}u;\n")).collect();
    prelude += &(TextureRecord::glsl_struct() + &TextureRecord::glsl_loader("textures"));
    let mut row = row
        .prelude(&prelude)
        .table("textures", bytemuck::cast_slice(&pages.records).to_vec())
        .table("texels", pages.texels.clone())
        .files(&["texture/image.glsl"]);
    for name in MACROS {
        row = row.define(name, u32::from(is_on));
    }
    row
}

fn checker_row() -> Probe {
    Probe::judged(
        "texture_checker",
        "vec4 v = texture_checker(vec4(0.25), vec4(0.75, 0.5, 1.0, 2.0), vec2(x0, x1), vec2(x2, x3)); y0 = v.x; y1 = v.w;",
        2,
        |r: &mut Inputs| [r.log(1e-3, 1e3), r.log(1e-3, 1e3), coordinate(r), coordinate(r)],
        |x, y| {
            let [su, sv, u, v] = [x[0], x[1], x[2], x[3]].map(f64::from);
            let (a, b) = (DVec4::splat(0.25), DVec4::new(0.75, 0.5, 1.0, 2.0));
            // A product within a rounding of an edge may fall to either side.
            let shifts = [0.0, -EPS, EPS].map(|e| 1.0 + e);
            let is_right = shifts.iter().any(|eu| {
                shifts.iter().any(|ev| {
                    // The product rounded to f32, as the device has it; then moved by half an ulp.
                    let at = texture::checker::eval(a, b, DVec2::ONE, DVec2::new(su * u * eu, sv * v * ev));
                    at.x == f64::from(y[0]) && at.w == f64::from(y[1])
                })
            });
            let is_large = (su * u).abs().max((sv * v).abs()) >= 8_388_608.0;
            if is_right || is_large { 0.0 } else { f64::INFINITY }
        },
    )
    .because("equal; either square within half an ulp of an edge")
    .files(&["texture/checker.glsl"])
}

pub fn probes() -> Vec<Probe> {
    let mut decode = Probe::real(
        "texture_srgb_decode",
        "vec3 v = texture_srgb_decode(vec3(x0)); y0 = v.x; y1 = v.y; y2 = v.z;",
        |r| [if r.once_in(2) { r.below(256) as f32 / 255.0 } else { r.range(0.0, 1.0) }],
        |[v]| [srgb_decode(v); 3],
    )
    .k(8.0)
    .within(0.0, 1.000_000_2)
    .because("fit 1.5 eps, and seven steps")
    .prelude(&(TextureRecord::glsl_struct() + "TextureRecord TextureRecord_load_textures(uint i) {\n    return TextureRecord(1u, 1u, 0u, 0u);\n}\nuvec4 texels_row(uint i) {\n    return uvec4(i);\n}\nconst uint TEXTURE_WRAP_U_SHIFT = 0u;\nconst uint TEXTURE_WRAP_V_SHIFT = 2u;\nconst uint TEXTURE_NEAREST = 16u;\nconst uint TEXTURE_SRGB = 32u;\n"))
    .files(&["texture/image.glsl"]);
    for name in MACROS {
        decode = decode.define(name, u32::from(name == "TEXTURE_HAS_SRGB"));
    }
    vec![
        image_row("texture_image", true),
        image_row("texture_image least text", false),
        footprint_row(),
        decode,
        checker_row(),
        Probe::real(
            "texture_constant",
            "vec4 v = texture_constant(vec4(x0, x1, x0, x1)); y0 = v.x; y1 = v.w;",
            |r| [r.range(-1.0, 1.0), r.range(0.0, 1.0)],
            |[a, b]| {
                let v = texture::constant::eval(DVec4::new(a, b, a, b));
                [v.x, v.w]
            },
        )
        .k(0.0)
        .files(&["texture/constant.glsl"]),
    ]
}
