//! Pixels from files: colour images of 8 or 16 bits (PNG, JPEG, WebP) and high-range ones (.hdr, .exr).
//!
//! Sizes are checked before memory is taken: a header is held against the budget and against what the file could
//! possibly hold. Sky pixels that are NaN, infinite or negative are counted and set to 0.

use std::io::Cursor;
use std::path::Path;
use std::sync::Arc;

use crate::math::special::srgb_decode;
use crate::scene::{Error, Image, Pixels};

/// Decoded bytes one image may take: 16384 x 16384 RGBA8.
const MAX_DECODED_BYTES: u64 = 1 << 30;
const EXR_MAGIC: &[u8] = &[0x76, 0x2f, 0x31, 0x01];
const MAX_SIDE: u32 = 65_535;
/// Deflate cannot pack better than 1032 to 1 (RFC 1951: 258 bytes from two bits), so a larger claim is a lie.
const MAX_DEFLATE_RATIO: u64 = 1040;
/// Pixels a byte: JPEG spends at least a bit on each block of its first scan, and a block is at most 32 x 32 pixels (ITU T.81, A.1.1).
const MAX_JPEG_RATIO: u64 = 8192;

/// `decode`, or EXR. High-range pixels that are no radiance are counted and set to 0.
pub fn decode_any(bytes: &[u8], name: &str, notes: &mut Vec<String>) -> Result<Image, String> {
    let mut image = match bytes.starts_with(EXR_MAGIC) {
        true => {
            let (width, height, rgb) = decode_exr(bytes)?;
            Image { name: name.into(), width, height, pixels: Pixels::RgbF32(Arc::new(rgb)) }
        }
        false => decode(bytes, name)?,
    };
    if let Pixels::RgbF32(rgb) = &mut image.pixels {
        let floats: &mut Vec<f32> = Arc::make_mut(rgb);
        clean("image", name, floats, notes);
    }
    Ok(image)
}

/// A colour image from the bytes of a PNG, JPEG, WebP or HDR file; `name` is for messages.
pub fn decode(bytes: &[u8], name: &str) -> Result<Image, String> {
    if bytes.is_empty() {
        return Err(format!("image {name} is empty (0 bytes); replace the file"));
    }
    let open = || {
        image::ImageReader::new(Cursor::new(bytes))
            .with_guessed_format()
            .map_err(|e| format!("image {name} cannot be read ({e}); replace the file"))
    };
    let reader = open()?;
    let Some(format) = reader.format() else {
        return Err(format!("image {name} is no PNG, JPEG, WebP or HDR file; convert it to PNG"));
    };
    let (width, height) =
        reader.into_dimensions().map_err(|e| format!("image {name} has no usable header ({e}); replace the file"))?;
    // 16-bit and high-range images take twice and three times as much; their decoders are held to `limits`.
    check_size(name, width, height, 4)?;
    let pixel_count = u64::from(width) * u64::from(height);
    let is_lying = match format {
        image::ImageFormat::Png => pixel_count / 8 > bytes.len() as u64 * MAX_DEFLATE_RATIO,
        image::ImageFormat::Jpeg => pixel_count > bytes.len() as u64 * MAX_JPEG_RATIO,
        _ => false,
    };
    if is_lying {
        return Err(format!(
            "image {name} says {width} x {height} but holds {} bytes, too few for that; replace the file",
            bytes.len()
        ));
    }
    let mut reader = open()?;
    let mut limits = image::Limits::default();
    limits.max_image_width = Some(MAX_SIDE);
    limits.max_image_height = Some(MAX_SIDE);
    limits.max_alloc = Some(3 * MAX_DECODED_BYTES);
    reader.limits(limits);
    let decoded = reader
        .decode()
        .map_err(|e| format!("image {name} ({width} x {height}) does not decode ({e}); replace the file"))?;
    if decoded.width() != width || decoded.height() != height {
        return Err(format!("image {name} says {width} x {height} and decodes to another size; replace the file"));
    }
    use image::DynamicImage as D;
    if matches!(decoded, D::ImageRgb32F(_) | D::ImageRgba32F(_)) {
        return Ok(Image {
            name: name.into(),
            width,
            height,
            pixels: Pixels::RgbF32(Arc::new(decoded.into_rgb32f().into_raw())),
        });
    }
    if matches!(decoded, D::ImageLuma16(_) | D::ImageLumaA16(_) | D::ImageRgb16(_) | D::ImageRgba16(_)) {
        let pixels = Pixels::Rgba16(Arc::new(decoded.into_rgba16().into_raw()));
        return Ok(Image { name: name.into(), width, height, pixels });
    }
    Ok(Image { name: name.into(), width, height, pixels: Pixels::Rgba8(Arc::new(decoded.into_rgba8().into_raw())) })
}

/// A lat-long sky in linear RGB from an .hdr or .exr file (8-bit images are taken as sRGB).
pub fn read_sky(path: &Path, notes: &mut Vec<String>) -> Result<Image, Error> {
    let bytes = super::read_bytes(path)?;
    let fail = |reason: String| Error::Image { path: path.to_path_buf(), reason };
    let name = path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
    let linear = |x: f64| srgb_decode(x) as f32;
    let is_exr = bytes.starts_with(EXR_MAGIC);
    let (width, height, mut rgb) = if is_exr {
        decode_exr(&bytes).map_err(fail)?
    } else {
        if !bytes.is_empty() && image::guess_format(&bytes).is_err() {
            return Err(fail(format!("sky {name} is no HDR or EXR file; convert it to .hdr or .exr")));
        }
        let image = decode(&bytes, &name).map_err(fail)?;
        let rgb = match image.pixels {
            Pixels::RgbF32(rgb) => Arc::try_unwrap(rgb).unwrap_or_else(|shared| shared.to_vec()),
            Pixels::Rgba8(rgba) => {
                notes.push(format!("sky {name} has 8 bits a channel: read as sRGB, its highlights are cut"));
                rgba.chunks_exact(4).flat_map(|p| [p[0], p[1], p[2]]).map(|b| linear(f64::from(b) / 255.0)).collect()
            }
            Pixels::Rgba16(rgba) => {
                notes.push(format!("sky {name} has 16 bits a channel: read as sRGB, its highlights are cut"));
                rgba.chunks_exact(4).flat_map(|p| [p[0], p[1], p[2]]).map(|b| linear(f64::from(b) / 65535.0)).collect()
            }
        };
        (image.width, image.height, rgb)
    };
    clean("sky", &name, &mut rgb, notes);
    Ok(Image { name, width, height, pixels: Pixels::RgbF32(Arc::new(rgb)) })
}

fn check_size(name: &str, width: u32, height: u32, bytes_per_pixel: u64) -> Result<(), String> {
    if width == 0 || height == 0 {
        return Err(format!("image {name} is {width} x {height}, it has no pixels; replace the file"));
    }
    let decoded = u64::from(width) * u64::from(height) * bytes_per_pixel;
    if width > MAX_SIDE || height > MAX_SIDE || decoded > MAX_DECODED_BYTES {
        return Err(format!(
            "image {name} says {width} x {height}, {decoded} bytes decoded, and the limit is {MAX_DECODED_BYTES}; make it smaller"
        ));
    }
    Ok(())
}

/// First layer with R, G and B, at full size.
fn decode_exr(bytes: &[u8]) -> Result<(u32, u32, Vec<f32>), String> {
    use exr::prelude::*;
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false)
        .map_err(|e| format!("the EXR header does not read ({e}); replace the file"))?;
    for header in &meta.headers {
        let size = header.layer_size;
        check_size(
            "in the EXR file",
            u32::try_from(size.0).unwrap_or(u32::MAX),
            u32::try_from(size.1).unwrap_or(u32::MAX),
            12,
        )?;
    }
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .rgb_channels(
            |size, _| (size.width(), vec![0f32; size.area() * 3]),
            |(width, pixels): &mut (usize, Vec<f32>), at, (r, g, b): (f32, f32, f32)| {
                let i = (at.y() * *width + at.x()) * 3;
                pixels[i..i + 3].copy_from_slice(&[r, g, b]);
            },
        )
        .first_valid_layer()
        .all_attributes()
        .from_buffered(Cursor::new(bytes))
        .map_err(|e| format!("the EXR pixels do not read ({e}); save it as ZIP-compressed RGB"))?;
    let size = image.layer_data.size;
    Ok((size.width() as u32, size.height() as u32, image.layer_data.channel_data.pixels.1))
}

/// Sets what is no radiance to 0 and says how much there was; warns where half floats were saturated.
fn clean(what: &str, name: &str, rgb: &mut [f32], notes: &mut Vec<String>) {
    let (mut nan, mut infinite, mut negative, mut saturated) = (0u64, 0u64, 0u64, 0u64);
    for x in rgb {
        match *x {
            v if v.is_nan() => nan += 1,
            v if v.is_infinite() => infinite += 1,
            v if v < 0.0 => negative += 1,
            v => {
                saturated += u64::from(v == 65_504.0);
                continue;
            }
        }
        *x = 0.0;
    }
    if nan + infinite + negative > 0 {
        notes.push(format!(
            "{what} {name}: {nan} NaN, {infinite} infinite and {negative} negative values were set to 0"
        ));
    }
    if saturated > 0 && what == "sky" {
        notes.push(format!(
            "sky {name}: {saturated} values are 65504, the largest half float: the sun was probably cut, and its light with it"
        ));
    }
}
