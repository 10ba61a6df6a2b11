//! Levels of detail and footprints, where a scene asks for `texture_filter = "mipmap"`. GLSL: shaders/texture/image.glsl.
//!
//! Level k + 1 is half of level k, rounded down, at least 1; each of its texels is the mean of the part of level k that it covers,
//! in linear light and before rounding to the page's format. Where a material's presence comes from the image's alpha, colours are
//! weighed by it, so that what is not there does not bleed in. The level for a footprint of n texels' area is log2(n) / 2.
//! The footprint is that of a ray cone (Akenine-Moller, Crassin, Boksansky, Belcour, Panteleev and Wright 2021, "Improved shader
//! and texture level of detail using ray cones"): a circle across the ray of diameter w covers a square of w^2 / cos on the surface.
//! A path's cone widens by `CONE_SHARE` at a vertex that scatters; curvature is left out. Spheres and discs read level 0, and so do
//! emission and presence: two estimators of the same light must see the same light.
//! Off by default, for it trades an unbiased picture for a biased one; docs/textures.md has the measurement.

use glam::{DVec2, DVec4};
use rayon::prelude::*;

use super::image::{halves, lookup_by, pack, pair, rows};
use crate::math::special::{srgb_decode, srgb_encode};
use crate::prepare::records::*;
use crate::scene::{Encoding, Image, Pixels};

/// Rows of a page before level 0: where the levels begin.
pub const OFFSET_ROWS: usize = 4;

/// A cone after a scattering of density p is at least `CONE_SHARE / sqrt(p)` wide a metre: about a hundredth of the solid angle 1/p
/// that one sample stands for. Wider blurs what is seen by reflection, narrower finds no level.
pub const CONE_SHARE: f32 = 0.1;

/// The look-up depends on how large the footprint is.
pub fn follows_footprint(t: &TextureRecord) -> bool {
    t.flags & TEXTURE_MIPS != 0 || (t.flags & TEXTURE_MIN_NEAREST != 0) != (t.flags & TEXTURE_NEAREST != 0)
}

/// The page of an image with its levels: `OFFSET_ROWS` rows that say how many rows after level 0 each level begins, level 0, the rest.
pub fn pack_levels(image: &Image, encoding: Encoding, is_alpha_weighted: bool) -> Vec<[u32; 4]> {
    let base = pack(image);
    let mut offsets = vec![0u32];
    let mut levels: Vec<[u32; 4]> = Vec::new();
    let is_srgb = encoding == Encoding::Srgb && !matches!(image.pixels, Pixels::RgbF32(_));
    let [mut w, mut h] = [image.width as usize, image.height as usize];
    let mut above: Vec<[f32; 4]> = Vec::new();
    while w > 1 || h > 1 {
        let [nw, nh] = [(w / 2).max(1), (h / 2).max(1)];
        let read = |x: usize, y: usize| match above.is_empty() {
            true => linear(image, is_srgb, y * w + x),
            false => above[y * w + x],
        };
        let next: Vec<[f32; 4]> = (0..nw * nh)
            .into_par_iter()
            .map(|i| mean(span(i % nw, nw, w), span(i / nw, nh, h), is_alpha_weighted, &read))
            .collect();
        offsets.push((base.len() + levels.len()) as u32);
        levels.extend(rows(&next.par_iter().flat_map_iter(|t| words(image, is_srgb, t)).collect::<Vec<u32>>()));
        (above, w, h) = (next, nw, nh);
    }
    // 65535 texels a side have 16 levels.
    offsets.resize(4 * OFFSET_ROWS, 0);
    let mut page = rows(&offsets);
    page.extend(base);
    page.extend(levels);
    page
}

/// Linear RGBA of the stored texel.
fn linear(image: &Image, is_srgb: bool, i: usize) -> [f32; 4] {
    let decode = |x: f64| if is_srgb { srgb_decode(x) as f32 } else { x as f32 };
    match &image.pixels {
        Pixels::Rgba8(p) => p.get(4 * i..4 * i + 4).map_or([0.0; 4], |t| {
            let [r, g, b, a] = [0, 1, 2, 3].map(|c| f64::from(t[c]) / 255.0);
            [decode(r), decode(g), decode(b), a as f32]
        }),
        Pixels::Rgba16(p) => p.get(4 * i..4 * i + 4).map_or([0.0; 4], |t| {
            let [r, g, b, a] = [0, 1, 2, 3].map(|c| f64::from(t[c]) / 65535.0);
            [decode(r), decode(g), decode(b), a as f32]
        }),
        Pixels::RgbF32(p) => p.get(3 * i..3 * i + 3).map_or([0.0; 4], |t| {
            let [r, g, b] = [t[0], t[1], t[2]].map(|x| if x.is_nan() { 0.0 } else { x.clamp(-65504.0, 65504.0) });
            [r, g, b, 1.0]
        }),
    }
}

/// Texels that texel `i` of `count` covers of a row of `size`, first and past the last, and how much of the outer two.
fn span(i: usize, count: usize, size: usize) -> (usize, usize, f64, f64) {
    let [from, to] = [i, i + 1].map(|k| k as f64 * size as f64 / count as f64);
    let (first, last) = (from.floor() as usize, (to.ceil() as usize).min(size));
    (first, last, 1.0 - (from - first as f64), 1.0 - (last as f64 - to))
}

fn mean(
    x: (usize, usize, f64, f64),
    y: (usize, usize, f64, f64),
    is_alpha_weighted: bool,
    read: &impl Fn(usize, usize) -> [f32; 4],
) -> [f32; 4] {
    let weight = |k: usize, (first, last, left, right): (usize, usize, f64, f64)| {
        if k == first {
            left
        } else if k + 1 == last {
            right
        } else {
            1.0
        }
    };
    let (mut color, mut plain, mut alpha, mut total) = (DVec4::ZERO, DVec4::ZERO, 0.0, 0.0);
    for j in y.0..y.1 {
        for i in x.0..x.1 {
            let w = weight(i, x) * weight(j, y);
            let t = DVec4::from_array(read(i, j).map(f64::from));
            color += w * t.w * t;
            plain += w * t;
            alpha += w * t.w;
            total += w;
        }
    }
    let rgb = if is_alpha_weighted && alpha > 0.0 { color / alpha } else { plain / total };
    rgb.with_w(alpha / total).as_vec4().to_array()
}

/// A texel as the page stores it.
fn words(image: &Image, is_srgb: bool, t: &[f32; 4]) -> Vec<u32> {
    let unit = |c: usize| if is_srgb && c < 3 { srgb_encode(f64::from(t[c])) } else { f64::from(t[c]) };
    match &image.pixels {
        Pixels::Rgba8(_) => {
            vec![u32::from_le_bytes([0, 1, 2, 3].map(|c| (unit(c).clamp(0.0, 1.0) * 255.0 + 0.5) as u8))]
        }
        Pixels::Rgba16(_) => pair([0, 1, 2, 3].map(|c| (unit(c).clamp(0.0, 1.0) * 65535.0 + 0.5) as u16)).to_vec(),
        Pixels::RgbF32(_) => halves([t[0], t[1], t[2]]).to_vec(),
    }
}

/// Linear RGBA of a footprint of `area` in the unit square of (u, v); not above a texel's, and NaN: level 0.
pub fn lookup_footprint(t: &TextureRecord, texels: &[[u32; 4]], uv: DVec2, area: f64) -> DVec4 {
    let texel_count = area * f64::from(t.width) * f64::from(t.height);
    let is_small = texel_count.is_nan() || texel_count <= 1.0;
    let is_nearest = t.flags & if is_small { TEXTURE_NEAREST } else { TEXTURE_MIN_NEAREST } != 0;
    if t.flags & TEXTURE_MIPS == 0 || is_small {
        return lookup_by(t, texels, uv, is_nearest);
    }
    let last = t.width.max(t.height).ilog2();
    let mut level = (0.5 * texel_count.log2()).min(f64::from(last));
    if t.flags & TEXTURE_MIP_NEAREST != 0 {
        level = (level + 0.5).floor();
    }
    let lower = level.floor();
    let at = |k: u32| lookup_by(&level_record(t, texels, k), texels, uv, is_nearest);
    at(lower as u32).lerp(at((lower as u32 + 1).min(last)), level - lower)
}

/// The record of one level, as if it were an image.
pub fn level_record(t: &TextureRecord, texels: &[[u32; 4]], level: u32) -> TextureRecord {
    let row = texels[t.first_row as usize - OFFSET_ROWS + level as usize / 4];
    TextureRecord {
        width: (t.width >> level).max(1),
        height: (t.height >> level).max(1),
        first_row: t.first_row + row[level as usize % 4],
        flags: t.flags,
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::super::image::{Page, record, texel};
    use super::*;
    use crate::scene::{Filter, Minify, Wrap};

    fn page(
        width: u32,
        height: u32,
        bytes: Vec<u8>,
        encoding: Encoding,
        weighted: bool,
    ) -> (TextureRecord, Vec<[u32; 4]>) {
        let image = Image { name: String::new(), width, height, pixels: Pixels::Rgba8(Arc::new(bytes)) };
        let at = Page { first_row: OFFSET_ROWS as u32, has_levels: true };
        let t = record(&image, [Wrap::Repeat; 2], Filter::Linear, Some(Minify::default()), encoding, at);
        (t, pack_levels(&image, encoding, weighted))
    }

    #[test]
    fn the_last_level_is_the_mean_of_the_image_in_linear_light() {
        for (w, h) in [(1u32, 1u32), (8, 8), (7, 5), (9, 2), (1, 13), (64, 3)] {
            let bytes: Vec<u8> = (0..w * h * 4).map(|i| (i * 97 % 251) as u8).collect();
            let (t, texels) = page(w, h, bytes.clone(), Encoding::Srgb, false);
            let last = level_record(&t, &texels, w.max(h).ilog2());
            assert_eq!((last.width, last.height), (1, 1));
            let got = texel(&last, &texels, 0, 0);
            for c in 0..4 {
                let decode = |b: u8| if c < 3 { srgb_decode(f64::from(b) / 255.0) } else { f64::from(b) / 255.0 };
                let mean: f64 = bytes.iter().skip(c).step_by(4).map(|b| decode(*b)).sum::<f64>() / f64::from(w * h);
                // Half a code of 8 bits, steepest at white.
                assert!((got[c] - mean).abs() < 2.3 / 510.0, "{w}x{h} channel {c}: {} against {mean}", got[c]);
            }
        }
    }

    #[test]
    fn what_is_not_there_does_not_bleed() {
        // One red texel that is there among green ones that are not.
        let mut bytes = [0u8, 255, 0, 0].repeat(4);
        bytes[..4].copy_from_slice(&[255, 0, 0, 255]);
        for (weighted, red) in [(true, 1.0), (false, 0.25)] {
            let (t, texels) = page(2, 2, bytes.clone(), Encoding::Linear, weighted);
            let got = texel(&level_record(&t, &texels, 1), &texels, 0, 0);
            assert!((got - DVec4::new(red, 1.0 - red, 0.0, 0.25)).abs().max_element() < 0.003, "{weighted}: {got}");
        }
    }

    #[test]
    fn levels_follow_the_footprint() {
        let bytes: Vec<u8> = (0..8 * 8 * 4).map(|i| if i / 4 % 2 == 0 { 255 } else { 0 }).collect();
        let (t, texels) = page(8, 8, bytes, Encoding::Linear, false);
        let uv = DVec2::new(0.0625, 0.3);
        let at = |area: f64| lookup_footprint(&t, &texels, uv, area).x;
        let first = lookup_by(&t, &texels, uv, false).x;
        assert_eq!((at(0.0), at(f64::NAN), at(1.0 / 64.0)), (first, first, first));
        // Columns of black and white: half from level 1 on.
        let half = 128.0 / 255.0;
        assert!((at(4.0 / 64.0) - half).abs() < 1e-12 && (at(f64::INFINITY) - half).abs() < 1e-12);
        assert!((at(2.0 / 64.0) - 0.5 * (first + half)).abs() < 1e-12);
    }
}
