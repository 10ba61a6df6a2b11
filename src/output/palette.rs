//! Pictures of 256 colours: a third of the bytes, for sheets that are looked at and kept beside the text.
//!
//! Colours are chosen by variance-based median cut (Heckbert 1982, "Color image quantization for frame buffer display"; boxes are split
//! at the mean of their widest axis, the one with the largest squared error first), and the error is diffused to neighbours (Floyd and
//! Steinberg 1976). A picture of at most 256 colours keeps them all.

use std::collections::BTreeMap;
use std::path::Path;

use crate::error::Error;

/// Entries of a palette.
const COLORS: usize = 256;

/// A palette and a place in it for each pixel.
#[derive(Debug, PartialEq)]
pub struct Indexed {
    pub palette: Vec<[u8; 3]>,
    pub indices: Vec<u8>,
}

/// Writes sRGB bytes, three a pixel, as a PNG with a palette.
pub fn write_png(path: &Path, width: u32, height: u32, bytes: &[u8]) -> Result<(), Error> {
    let picture = quantize(width as usize, bytes);
    super::replace(path, |beside| {
        let file = std::fs::File::create(beside).map_err(|e| Error::io("write", path, e))?;
        let mut encoder = png::Encoder::new(std::io::BufWriter::new(file), width, height);
        encoder.set_color(png::ColorType::Indexed);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_compression(png::Compression::High);
        encoder.set_palette(picture.palette.concat());
        let mut writer = encoder.write_header().map_err(|e| Error::file(path, format!("cannot write: {e}")))?;
        writer.write_image_data(&picture.indices).map_err(|e| Error::file(path, format!("cannot write: {e}")))?;
        writer.finish().map_err(|e| Error::file(path, format!("cannot write: {e}")))
    })
}

/// `bytes` are rows of `width` pixels, three bytes each.
pub fn quantize(width: usize, bytes: &[u8]) -> Indexed {
    let pixels: Vec<[u8; 3]> = bytes.chunks_exact(3).map(|p| [p[0], p[1], p[2]]).collect();
    let mut counts: BTreeMap<[u8; 3], u32> = BTreeMap::new();
    pixels.iter().for_each(|p| *counts.entry(*p).or_default() += 1);
    let palette = palette(counts.into_iter().collect());
    // Two rows of error on their way to the right and down, in sixteenths.
    let mut errors = vec![[0i32; 3]; 2 * width];
    let mut known: BTreeMap<[u8; 3], u8> = BTreeMap::new();
    let mut indices = Vec::with_capacity(pixels.len());
    for (k, pixel) in pixels.iter().enumerate() {
        let (x, row) = (k % width, k / width % 2 * width);
        let below = width - row;
        if x == 0 {
            errors[below..below + width].fill([0; 3]);
        }
        let wanted: [i32; 3] =
            std::array::from_fn(|c| (i32::from(pixel[c]) * 16 + errors[row + x][c]).clamp(0, 255 * 16));
        let color = wanted.map(|v| ((v + 8) / 16) as u8);
        let index = *known.entry(color).or_insert_with(|| nearest(&palette, color));
        indices.push(index);
        for c in 0..3 {
            let error = wanted[c] - i32::from(palette[usize::from(index)][c]) * 16;
            let mut give = |at: usize, share: i32| errors[at][c] += error * share / 16;
            if x + 1 < width {
                give(row + x + 1, 7);
                give(below + x + 1, 1);
            }
            if x > 0 {
                give(below + x - 1, 3);
            }
            give(below + x, 5);
        }
    }
    Indexed { palette, indices }
}

fn nearest(palette: &[[u8; 3]], color: [u8; 3]) -> u8 {
    let distance = |p: &[u8; 3]| (0..3).map(|c| (i32::from(p[c]) - i32::from(color[c])).pow(2)).sum::<i32>();
    (0..palette.len()).min_by_key(|k| distance(&palette[*k])).unwrap_or(0) as u8
}

/// Colours with how often each occurs: one box of the cut.
type Colors = Vec<([u8; 3], u32)>;

fn palette(all: Colors) -> Vec<[u8; 3]> {
    let mut boxes = vec![(spread(&all), all)];
    while boxes.len() < COLORS {
        let widest = (0..boxes.len()).max_by(|a, b| boxes[*a].0.1.total_cmp(&boxes[*b].0.1)).unwrap_or(0);
        let ((axis, error), _) = boxes[widest];
        if error == 0.0 {
            break;
        }
        let (_, colors) = boxes.swap_remove(widest);
        let mean = mean(&colors)[axis];
        let (low, high): (Colors, Colors) = colors.into_iter().partition(|(color, _)| f64::from(color[axis]) <= mean);
        boxes.extend([low, high].map(|part| (spread(&part), part)));
    }
    boxes.iter().map(|(_, colors)| mean(colors).map(|v| (v + 0.5) as u8)).collect()
}

fn mean(colors: &[([u8; 3], u32)]) -> [f64; 3] {
    let count: f64 = colors.iter().map(|c| f64::from(c.1)).sum::<f64>().max(1.0);
    std::array::from_fn(|axis| colors.iter().map(|c| f64::from(c.0[axis]) * f64::from(c.1)).sum::<f64>() / count)
}

/// The axis along which the colours differ most, and their squared error along it.
fn spread(colors: &[([u8; 3], u32)]) -> (usize, f64) {
    let mean = mean(colors);
    let error =
        |axis: usize| colors.iter().map(|c| (f64::from(c.0[axis]) - mean[axis]).powi(2) * f64::from(c.1)).sum::<f64>();
    (0..3).map(|axis| (axis, error(axis))).max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0, 0.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_colours_are_kept_and_many_are_right_in_the_mean() {
        let few: Vec<u8> = (0..64u8).flat_map(|k| [k, 255 - k, 7]).collect();
        let kept = quantize(8, &few);
        let back: Vec<u8> = kept.indices.iter().flat_map(|i| kept.palette[usize::from(*i)]).collect();
        assert_eq!((back, kept.palette.len()), (few, 64));
        // A wedge of 64 x 64 x 16 colours.
        let (width, height) = (256usize, 256usize);
        let many: Vec<u8> = (0..width * height)
            .flat_map(|k| [(k % width) as u8, (k / width) as u8, (k % width / 16 * 16) as u8])
            .collect();
        let indexed = quantize(width, &many);
        assert_eq!(indexed.palette.len(), 256);
        for (corner, side) in [((0, 0), 256), ((32, 96), 32), ((200, 16), 32)] {
            let mut sum = [0.0f64; 3];
            for y in corner.1..corner.1 + side {
                for x in corner.0..corner.0 + side {
                    let at = y * width + x;
                    let shown = indexed.palette[usize::from(indexed.indices[at])];
                    (0..3).for_each(|c| sum[c] += f64::from(shown[c]) - f64::from(many[3 * at + c]));
                }
            }
            let off = sum.map(|s| (s / (side * side) as f64).abs());
            assert!(off.iter().all(|v| *v < 1.0), "{corner:?} {off:?}");
        }
    }

    #[test]
    fn a_png_with_a_palette_reads_back() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.png");
        write_png(&path, 2, 1, &[255, 0, 0, 0, 0, 255]).unwrap();
        let picture = crate::output::image::read(&path).unwrap();
        assert_eq!(picture.pixels, [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]);
    }
}
