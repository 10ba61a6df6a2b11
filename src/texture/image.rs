//! Image textures (`type = "image"`): packed pages and their bilinear lookup in f64. GLSL: shaders/texture/image.glsl.
//!
//! Pages: 8-bit images stay RGBA8 (4 texels a row of 16 bytes), float images become RGBA16F (2 a row). Texel (i, j) has its
//! centre at ((i + 0.5) / width, (j + 0.5) / height), v runs down from the top row (glTF 2.0, section 3.8). 8-bit colour of an
//! sRGB texture is decoded before it is filtered. Wrap per axis: repeat, mirror, clamp, for any coordinate; NaN and infinity
//! read as 0. No mip levels: a texture is sampled as often as the film is.

use glam::{DVec2, DVec4};
use half::f16;

use crate::math::special::srgb_decode;
use crate::prepare::records::*;
use crate::scene::{Encoding, Filter, Image, Pixels, Wrap};

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
        Pixels::RgbF32(floats) => {
            let half = |x: Option<&f32>| {
                let x = x.copied().filter(|x| !x.is_nan()).unwrap_or(0.0);
                u32::from(f16::from_f32(x.clamp(-65504.0, 65504.0)).to_bits())
            };
            let one = u32::from(f16::ONE.to_bits());
            let texel = |i: usize| {
                let [r, g, b] = [0, 1, 2].map(|c| half(floats.get(3 * i + c)));
                [r | (g << 16), b | (one << 16)]
            };
            (0..count).flat_map(texel).collect()
        }
    };
    words.chunks(4).map(|c| std::array::from_fn(|k| c.get(k).copied().unwrap_or(0))).collect()
}

/// The record of a texture whose page starts at `first_row` of table `texels`.
pub fn record(image: &Image, wrap: [Wrap; 2], filter: Filter, encoding: Encoding, first_row: u32) -> TextureRecord {
    let code = |w: Wrap| match w {
        Wrap::Repeat => 0,
        Wrap::Mirror => 1,
        Wrap::Clamp => 2,
    };
    let is_half = matches!(image.pixels, Pixels::RgbF32(_));
    let mut flags = (code(wrap[0]) << TEXTURE_WRAP_U_SHIFT) | (code(wrap[1]) << TEXTURE_WRAP_V_SHIFT);
    flags |= if filter == Filter::Nearest { TEXTURE_NEAREST } else { 0 };
    flags |= if is_half { TEXTURE_HALF } else { 0 };
    // Float images are linear whatever the texture says.
    flags |= if encoding == Encoding::Srgb && !is_half { TEXTURE_SRGB } else { 0 };
    TextureRecord { width: image.width, height: image.height, first_row, flags }
}

/// Linear RGBA at `uv`, from the packed page in `texels`.
pub fn lookup(t: &TextureRecord, texels: &[[u32; 4]], uv: DVec2) -> DVec4 {
    let is_nearest = t.flags & TEXTURE_NEAREST != 0;
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

fn texel(t: &TextureRecord, texels: &[[u32; 4]], x: usize, y: usize) -> DVec4 {
    let index = y * t.width as usize + x;
    let first = t.first_row as usize;
    if t.flags & TEXTURE_HALF != 0 {
        let row = texels[first + index / 2];
        let half = |word: u32, shift: u32| f16::from_bits((word >> shift) as u16).to_f64();
        let [rg, ba] = [row[2 * (index % 2)], row[2 * (index % 2) + 1]];
        return DVec4::new(half(rg, 0), half(rg, 16), half(ba, 0), half(ba, 16));
    }
    let bytes = texels[first + index / 4][index % 4].to_le_bytes();
    let v = bytes.map(|b| f64::from(b) / 255.0);
    let decode = |v: f64| if t.flags & TEXTURE_SRGB != 0 { srgb_decode(v) } else { v };
    DVec4::new(decode(v[0]), decode(v[1]), decode(v[2]), v[3])
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;

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
                let t = record(&image, [wu, wv], Filter::Linear, Encoding::Linear, 0);
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
        let t = record(&image, [Wrap::Repeat; 2], Filter::Nearest, Encoding::Linear, 0);
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
                let t = record(&image, [wrap; 2], filter, Encoding::Srgb, 0);
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
        let t = record(&image, [Wrap::Clamp; 2], Filter::Nearest, Encoding::Srgb, 0);
        assert_eq!(t.flags & (TEXTURE_HALF | TEXTURE_SRGB), TEXTURE_HALF);
        let at = |u| lookup(&t, &page, DVec2::new(u, 0.5));
        assert_eq!(at(0.1), DVec4::new(0.5, 65504.0, 0.0, 1.0));
        assert_eq!(at(0.5), DVec4::new(-65504.0, 1.0, f64::from(f16::from_f32(0.1)), 1.0));
        assert_eq!(at(0.9), DVec4::new(0.25, 0.0, 2.0, 1.0));
    }

    #[test]
    fn a_short_image_is_padded() {
        let image = Image { name: String::new(), width: 4, height: 4, pixels: Pixels::Rgba8(Arc::new(vec![255; 5])) };
        assert_eq!(pack(&image).len(), 4);
    }
}
