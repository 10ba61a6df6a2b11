//! Plain RGB pictures: read for comparisons, written as PNG and Radiance HDR.
//!
//! PNG is 8-bit sRGB (IEC 61966-2-1) of exposed radiance (`look`), clipped to [0, 1]; a radiance of 1 is white at EV 0 without a
//! tone curve.

use std::fs::File;
use std::io::{BufReader, BufWriter, Write};
use std::path::Path;

use image::ImageEncoder;
use image::codecs::png::PngEncoder;

use super::look::Look;
use super::{Format, hdr};
use crate::error::Error;
use crate::film::Film;

/// Linear RGB, row 0 on top.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    pub width: u32,
    pub height: u32,
    pub pixels: Vec<[f32; 3]>,
}

impl Picture {
    pub fn of_film(film: &Film) -> Self {
        Self { width: film.width(), height: film.height(), pixels: film.mean_f32() }
    }
}

/// Reads .exr, .png or .hdr. PNG is decoded from sRGB; its alpha is dropped.
pub fn read(path: &Path) -> Result<Picture, Error> {
    let format = Format::of(path)?;
    if path.is_dir() {
        return Err(Error::file(path, "cannot read: it is a directory"));
    }
    let file = File::open(path).map_err(|e| Error::io("read", path, e))?;
    let kind = match format {
        Format::Exr => return super::exr::read(path),
        Format::Png => image::ImageFormat::Png,
        Format::Hdr => image::ImageFormat::Hdr,
    };
    let decoded = image::ImageReader::with_format(BufReader::new(file), kind).decode();
    let decoded = decoded.map_err(|e| Error::file(path, format!("cannot read the picture: {e}")))?;
    let (width, height) = (decoded.width(), decoded.height());
    let rgb = decoded.into_rgb32f();
    let to_linear = |v: f32| if format == Format::Png { srgb_decode(v) } else { v };
    let pixels = rgb.pixels().map(|p| p.0.map(to_linear)).collect();
    Ok(Picture { width, height, pixels })
}

/// 8-bit sRGB of `picture` as `look` shows it.
pub fn write_png(path: &Path, picture: &Picture, look: impl Into<Look>) -> Result<(), Error> {
    let look = look.into();
    let bytes: Vec<u8> = picture.pixels.iter().flat_map(|&p| rgb8(p, &look)).collect();
    write_rgb8(path, picture.width, picture.height, &bytes)
}

/// A pixel's bytes.
pub fn rgb8(radiance: [f32; 3], look: &Look) -> [u8; 3] {
    look.apply(radiance).map(|v| (srgb_encode(v) * 255.0 + 0.5) as u8)
}

/// Three bytes a pixel, already encoded.
pub fn write_rgb8(path: &Path, width: u32, height: u32, bytes: &[u8]) -> Result<(), Error> {
    encode(path, |out| PngEncoder::new(out).write_image(bytes, width, height, image::ExtendedColorType::Rgb8))
}

/// A PNG in memory; three bytes a pixel, already encoded.
pub fn png_bytes(width: u32, height: u32, bytes: &[u8]) -> Result<Vec<u8>, Error> {
    let mut out = Vec::new();
    let encoded = PngEncoder::new(&mut out).write_image(bytes, width, height, image::ExtendedColorType::Rgb8);
    encoded.map_err(|e| Error::file("a picture in memory", format!("cannot encode: {e}")))?;
    Ok(out)
}

/// Radiance HDR: shared exponent, negative values become 0.
pub fn write_hdr(path: &Path, picture: &Picture) -> Result<(), Error> {
    encode(path, |out| {
        out.write_all(hdr::header(picture.width, picture.height).as_bytes())?;
        Ok(hdr::write_pixels(out, &picture.pixels)?)
    })
}

fn encode(
    path: &Path,
    encode: impl FnOnce(&mut BufWriter<File>) -> Result<(), image::ImageError>,
) -> Result<(), Error> {
    super::replace(path, |beside| {
        let file = File::create(beside).map_err(|e| Error::io("write", path, e))?;
        let mut out = BufWriter::new(file);
        encode(&mut out).map_err(|e| match e {
            image::ImageError::IoError(e) => Error::io("write", path, e),
            other => Error::file(path, format!("cannot write: {other}")),
        })?;
        out.flush().map_err(|e| Error::io("write", path, e))
    })
}

/// Linear to sRGB, clipped to [0, 1]; NaN becomes 0.
pub fn srgb_encode(linear: f32) -> f32 {
    let v = if linear.is_nan() { 0.0 } else { linear.clamp(0.0, 1.0) };
    if v <= 0.003_130_8 { 12.92 * v } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 }
}

/// sRGB in [0, 1] to linear.
pub fn srgb_decode(encoded: f32) -> f32 {
    if encoded <= 0.040_45 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}
