//! Image textures (`type = "image"`): packed pages and their bilinear lookup in f64. GLSL: shaders/texture/image.glsl.
//!
//! Pages: 8-bit images stay RGBA8 (4 texels a row of 16 bytes), 16-bit ones RGBA16 and float images RGBA16F (2 a row). Texel
//! (i, j) has its centre at ((i + 0.5) / width, (j + 0.5) / height), v runs down from the top row (glTF 2.0, section 3.8). The
//! colour of an sRGB texture is decoded before it is filtered. Wrap per axis: repeat, mirror, clamp, for any coordinate; NaN and
//! infinity read as 0. Levels of detail: `mip`; they are off unless a scene asks, for a picture converges to the exact mean over its
//! pixels without them.

use glam::{DVec2, DVec4};
use half::f16;

use crate::math::special::srgb_decode;
use crate::prepare::records::*;
use crate::scene::{Encoding, Filter, Image, Minify, Pixels, Wrap};

/// The page of an image, to be appended to table `texels`. Pixels that the image lacks are 0; halves saturate at 65504, and
/// NaN becomes 0.
pub fn pack(image: &Image) -> Vec<[u32; 4]> {
    let count = image.width as usize * image.height as usize;
    let words: Vec<u32> = match &image.pixels {
        Pixels::Rgba8(bytes) => {
            let texel =
                |i: usize| bytes.get(4 * i..4 * i + 4).map_or(0, |b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]));
            (0..count).map(texel).collect()
        }
        Pixels::Rgba16(words) => {
            let texel = |i: usize| words.get(4 * i..4 * i + 4).map_or([0; 2], |w| pair([w[0], w[1], w[2], w[3]]));
            (0..count).flat_map(texel).collect()
        }
        Pixels::RgbF32(floats) => {
            let texel = |i: usize| halves([0, 1, 2].map(|c| floats.get(3 * i + c).copied().unwrap_or(0.0)));
            (0..count).flat_map(texel).collect()
        }
    };
    rows(&words)
}

/// Words to rows, the last one filled up with 0.
pub(super) fn rows(words: &[u32]) -> Vec<[u32; 4]> {
    words.chunks(4).map(|c| std::array::from_fn(|k| c.get(k).copied().unwrap_or(0))).collect()
}

pub(super) fn pair([r, g, b, a]: [u16; 4]) -> [u32; 2] {
    [u32::from(r) | (u32::from(g) << 16), u32::from(b) | (u32::from(a) << 16)]
}

/// RGB and 1 as half floats.
pub(super) fn halves(rgb: [f32; 3]) -> [u32; 2] {
    let half = |x: f32| f16::from_f32(if x.is_nan() { 0.0 } else { x.clamp(-65504.0, 65504.0) }).to_bits();
    let [r, g, b] = rgb.map(half);
    pair([r, g, b, f16::ONE.to_bits()])
}

/// Where a page stands in table `texels`.
#[derive(Clone, Copy, Debug)]
pub struct Page {
    /// Of level 0.
    pub first_row: u32,
    pub has_levels: bool,
}

/// The record of a texture whose page is `page`. `minify` None reads level 0 as near texels are read.
pub fn record(
    image: &Image,
    wrap: [Wrap; 2],
    filter: Filter,
    minify: Option<Minify>,
    encoding: Encoding,
    page: Page,
) -> TextureRecord {
    let code = |w: Wrap| match w {
        Wrap::Repeat => 0,
        Wrap::Mirror => 1,
        Wrap::Clamp => 2,
    };
    let is_half = matches!(image.pixels, Pixels::RgbF32(_));
    let minify = minify.unwrap_or(Minify { filter, levels: None });
    let mut flags = (code(wrap[0]) << TEXTURE_WRAP_U_SHIFT) | (code(wrap[1]) << TEXTURE_WRAP_V_SHIFT);
    for (bit, is_set) in [
        (TEXTURE_NEAREST, filter == Filter::Nearest),
        (TEXTURE_HALF, is_half),
        (TEXTURE_WIDE, matches!(image.pixels, Pixels::Rgba16(_))),
        // Float images are linear whatever the texture says.
        (TEXTURE_SRGB, encoding == Encoding::Srgb && !is_half),
        (TEXTURE_MIN_NEAREST, minify.filter == Filter::Nearest),
        (TEXTURE_MIPS, page.has_levels && minify.levels.is_some()),
        (TEXTURE_MIP_NEAREST, page.has_levels && minify.levels == Some(Filter::Nearest)),
    ] {
        flags |= if is_set { bit } else { 0 };
    }
    TextureRecord { width: image.width, height: image.height, first_row: page.first_row, flags }
}

/// Linear RGBA at `uv`, from the packed page in `texels`.
pub fn lookup(t: &TextureRecord, texels: &[[u32; 4]], uv: DVec2) -> DVec4 {
    lookup_by(t, texels, uv, t.flags & TEXTURE_NEAREST != 0)
}

pub(super) fn lookup_by(t: &TextureRecord, texels: &[[u32; 4]], uv: DVec2, is_nearest: bool) -> DVec4 {
    let [x0, x1, fx] = taps(uv.x, t.width, (t.flags >> TEXTURE_WRAP_U_SHIFT) & 3, is_nearest);
    let [y0, y1, fy] = taps(uv.y, t.height, (t.flags >> TEXTURE_WRAP_V_SHIFT) & 3, is_nearest);
    let at = |x: f64, y: f64| texel(t, texels, x as usize, y as usize);
    at(x0, y0).lerp(at(x1, y0), fx).lerp(at(x0, y1).lerp(at(x1, y1), fx), fy)
}

/// First and second texel of an axis, and the weight of the second.
fn taps(u: f64, size: u32, wrap: u32, is_nearest: bool) -> [f64; 3] {
    let u = if u.is_finite() { u } else { 0.0 };
    let size = f64::from(size);
    let x = size
        * match wrap {
            0 => u - u.floor(),
            1 => 1.0 - (u.rem_euclid(2.0) - 1.0).abs(),
            _ => u.clamp(0.0, 1.0),
        };
    if is_nearest {
        let i = x.floor().min(size - 1.0);
        return [i, i, 0.0];
    }
    let left = (x - 0.5).floor();
    let inside = |i: f64| if wrap == 0 { i.rem_euclid(size) } else { i.clamp(0.0, size - 1.0) };
    [inside(left), inside(left + 1.0), x - 0.5 - left]
}

pub(super) fn texel(t: &TextureRecord, texels: &[[u32; 4]], x: usize, y: usize) -> DVec4 {
    let index = y * t.width as usize + x;
    let first = t.first_row as usize;
    if t.flags & TEXTURE_HALF != 0 {
        let row = texels[first + index / 2];
        let half = |word: u32, shift: u32| f16::from_bits((word >> shift) as u16).to_f64();
        let [rg, ba] = [row[2 * (index % 2)], row[2 * (index % 2) + 1]];
        return DVec4::new(half(rg, 0), half(rg, 16), half(ba, 0), half(ba, 16));
    }
    let decode = |v: f64| if t.flags & TEXTURE_SRGB != 0 { srgb_decode(v) } else { v };
    if t.flags & TEXTURE_WIDE != 0 {
        let row = texels[first + index / 2];
        let unit = |word: u32, shift: u32| f64::from((word >> shift) & 0xffff) / 65535.0;
        let [rg, ba] = [row[2 * (index % 2)], row[2 * (index % 2) + 1]];
        return DVec4::new(decode(unit(rg, 0)), decode(unit(rg, 16)), decode(unit(ba, 0)), unit(ba, 16));
    }
    let bytes = texels[first + index / 4][index % 4].to_le_bytes();
    let v = bytes.map(|b| f64::from(b) / 255.0);
    DVec4::new(decode(v[0]), decode(v[1]), decode(v[2]), v[3])
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;

    const PAGE: Page = Page { first_row: 0, has_levels: false };
    const WRAPS: [Wrap; 3] = [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp];

    fn image(width: u32, height: u32) -> Image {
        let bytes = (0..width * height * 4).map(|i| (i * 37 % 251) as u8).collect();
        Image { name: "test".into(), width, height, pixels: Pixels::Rgba8(Arc::new(bytes)) }
    }

    /// Straight from the pixels: the tent filter summed over all texels near (u, v) of the wrapped plane.
    fn direct(image: &Image, wrap: [Wrap; 2], uv: DVec2) -> DVec4 {
        let Pixels::Rgba8(bytes) = &image.pixels else { unreachable!() };
        let fold = |i: i64, n: i64, wrap: Wrap| match wrap {
            Wrap::Repeat => i.rem_euclid(n),
            Wrap::Clamp => i.clamp(0, n - 1),
            Wrap::Mirror if i.rem_euclid(2 * n) < n => i.rem_euclid(2 * n),
            Wrap::Mirror => 2 * n - 1 - i.rem_euclid(2 * n),
        };
        let (w, h) = (i64::from(image.width), i64::from(image.height));
        let at = uv * DVec2::new(w as f64, h as f64) - 0.5;
        let mut sum = DVec4::ZERO;
        for j in at.y.floor() as i64..=at.y.floor() as i64 + 1 {
            for i in at.x.floor() as i64..=at.x.floor() as i64 + 1 {
                let weight = (1.0 - (at.x - i as f64).abs()) * (1.0 - (at.y - j as f64).abs());
                let k = 4 * (fold(j, h, wrap[1]) * w + fold(i, w, wrap[0])) as usize;
                sum += weight * DVec4::from_array(std::array::from_fn(|c| f64::from(bytes[k + c]) / 255.0));
            }
        }
        sum
    }

    #[test]
    fn packed_lookup_is_the_tent_filter_over_the_wrapped_plane() {
        for (width, height) in [(1, 1), (2, 3), (7, 4), (5, 1)] {
            let image = image(width, height);
            let page = pack(&image);
            for (wu, wv) in WRAPS.iter().flat_map(|&a| WRAPS.iter().map(move |&b| (a, b))) {
                let t = record(&image, [wu, wv], Filter::Linear, None, Encoding::Linear, PAGE);
                for k in 0..500 {
                    let uv = DVec2::new(f64::from(k) * 0.0137 - 3.0, f64::from(k % 97) * 0.071 - 2.5);
                    let (a, b) = (lookup(&t, &page, uv), direct(&image, [wu, wv], uv));
                    assert!(
                        (a - b).abs().max_element() < 1e-12,
                        "{width}x{height} {wu:?} {wv:?} {uv}: {a} against {b}"
                    );
                }
            }
        }
    }

    #[test]
    fn nearest_takes_the_texel_around_the_point() {
        let image = image(4, 2);
        let t = record(&image, [Wrap::Repeat; 2], Filter::Nearest, None, Encoding::Linear, PAGE);
        let page = pack(&image);
        for (u, v, i) in [(0.0, 0.0, 0), (0.26, 0.0, 1), (0.99, 0.6, 7), (-0.01, -0.01, 7), (1.0, 1.0, 0)] {
            assert_eq!(lookup(&t, &page, DVec2::new(u, v)), texel(&t, &page, i % 4, i / 4), "({u}, {v})");
        }
    }

    #[test]
    fn any_coordinate_gives_a_texel() {
        let image = image(3, 3);
        let page = pack(&image);
        let edges = [f64::NAN, f64::INFINITY, -f64::INFINITY, 1e6, -1e6, 1e30, -1e-30, 1.0, -0.0];
        for wrap in WRAPS {
            for filter in [Filter::Nearest, Filter::Linear] {
                let t = record(&image, [wrap; 2], filter, None, Encoding::Srgb, PAGE);
                for (u, v) in edges.iter().flat_map(|&u| edges.iter().map(move |&v| (u, v))) {
                    assert!(lookup(&t, &page, DVec2::new(u, v)).is_finite(), "{wrap:?} {u} {v}");
                }
            }
        }
    }

    #[test]
    fn floats_are_stored_as_halves_and_saturate() {
        let floats = vec![0.5, 70000.0, f32::NAN, f32::NEG_INFINITY, 1.0, 0.1, 0.25, 0.0, 2.0];
        let image = Image { name: String::new(), width: 3, height: 1, pixels: Pixels::RgbF32(Arc::new(floats)) };
        let page = pack(&image);
        assert_eq!(page.len(), 2);
        let t = record(&image, [Wrap::Clamp; 2], Filter::Nearest, None, Encoding::Srgb, PAGE);
        assert_eq!(t.flags & (TEXTURE_HALF | TEXTURE_SRGB), TEXTURE_HALF);
        let at = |u| lookup(&t, &page, DVec2::new(u, 0.5));
        assert_eq!(at(0.1), DVec4::new(0.5, 65504.0, 0.0, 1.0));
        assert_eq!(at(0.5), DVec4::new(-65504.0, 1.0, f64::from(f16::from_f32(0.1)), 1.0));
        assert_eq!(at(0.9), DVec4::new(0.25, 0.0, 2.0, 1.0));
    }

    #[test]
    fn sixteen_bits_are_kept() {
        let words = vec![0, 1, 65535, 32768, 257, 40000, 3, 65535];
        let image = Image { name: String::new(), width: 2, height: 1, pixels: Pixels::Rgba16(Arc::new(words.clone())) };
        let page = pack(&image);
        assert_eq!(page.len(), 1);
        let t = record(&image, [Wrap::Clamp; 2], Filter::Nearest, None, Encoding::Linear, PAGE);
        for (i, u) in [0.2, 0.8].into_iter().enumerate() {
            let wanted = DVec4::from_array(std::array::from_fn(|c| f64::from(words[4 * i + c]) / 65535.0));
            assert_eq!(lookup(&t, &page, DVec2::new(u, 0.5)), wanted);
        }
        let srgb = record(&image, [Wrap::Clamp; 2], Filter::Nearest, None, Encoding::Srgb, PAGE);
        let v = lookup(&srgb, &page, DVec2::new(0.8, 0.5));
        assert_eq!((v.y, v.w), (srgb_decode(40000.0 / 65535.0), 1.0));
    }

    #[test]
    fn a_short_image_is_padded() {
        let image = Image { name: String::new(), width: 4, height: 4, pixels: Pixels::Rgba8(Arc::new(vec![255; 5])) };
        assert_eq!(pack(&image).len(), 4);
    }
}
