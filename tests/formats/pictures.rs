//! Pictures of textures: what is kept of them, and files that lie about themselves.

use std::io::Cursor;
use std::path::Path;

use image::{ImageBuffer, ImageFormat, Rgb, Rgba};
use steradian::scene::{self, Filter, Minify, Pixels, Texture, TextureFilter, Wrap};

use crate::triangle::*;

/// A scene that reads `file`, with more keys of its texture.
fn textured(folder: &Folder, file: &str, more: &str) -> std::path::PathBuf {
    let text = format!(
        "[[texture]]\nname = \"t\"\nfile = \"{file}\"\n{more}\n[[material]]\nname = \"m\"\nalbedo = {{ texture = \"t\" }}\n\
         [[shape]]\ntype = \"rectangle\"\nmaterial = \"m\"\n"
    );
    folder.write("scene.toml", text.as_bytes())
}

fn refused(path: &Path, wanted: &str) {
    let message = scene::load(path).map(|_| ()).unwrap_err().to_string();
    assert!(message.contains(wanted) && !message.contains('\n'), "\nwanted: {wanted}\nfound:  {message}");
}

#[test]
fn sixteen_bit_pngs_keep_their_bits() {
    let folder = Folder::new();
    let picture = ImageBuffer::from_fn(3, 2, |x, y| Rgba([257 * x as u16 + 1, 40_000, 3 * y as u16, 65_535]));
    let mut bytes = Cursor::new(Vec::new());
    picture.write_to(&mut bytes, ImageFormat::Png).unwrap();
    folder.write("deep.png", &bytes.into_inner());
    let scene = scene::load(&textured(&folder, "deep.png", "")).unwrap();
    let Pixels::Rgba16(words) = &scene.images[0].pixels else { panic!("{:?}", scene.images[0].pixels) };
    assert_eq!(words[..8], [1, 40_000, 0, 65_535, 258, 40_000, 0, 65_535]);
    assert!(scene.notes.is_empty(), "{:?}", scene.notes);
}

#[test]
fn high_range_textures_are_linear_and_cleaned() {
    let folder = Folder::new();
    exr::prelude::write_rgb_file(folder.0.path().join("a.exr"), 2, 1, |x, _| match x {
        0 => (f32::NAN, -1.0, 70_000.0f32),
        _ => (0.25, 0.5, 1.0),
    })
    .unwrap();
    let scene = scene::load(&textured(&folder, "a.exr", "")).unwrap();
    let Pixels::RgbF32(floats) = &scene.images[0].pixels else { panic!() };
    assert_eq!(floats[..], [0.0, 0.0, 70_000.0, 0.25, 0.5, 1.0]);
    assert!(scene.notes[0].contains("image a.exr: 1 NaN, 0 infinite and 1 negative values"), "{:?}", scene.notes);
    let mut bytes = Vec::new();
    image::codecs::hdr::HdrEncoder::new(&mut bytes).encode(&[Rgb([0.5f32, 2.0, 8.0])], 1, 1).unwrap();
    folder.write("a.hdr", &bytes);
    let scene = scene::load(&textured(&folder, "a.hdr", "")).unwrap();
    let Pixels::RgbF32(floats) = &scene.images[0].pixels else { panic!() };
    assert_eq!(floats[..], [0.5, 2.0, 8.0]);
}

/// Headers that claim more than memory, or more than their file can hold, are refused before anything is allocated.
#[test]
fn headers_that_lie() {
    let folder = Folder::new();
    folder.write("big.png", &lying_png(60_000, 60_000));
    refused(
        &textured(&folder, "big.png", ""),
        "says 60000 x 60000, 14400000000 bytes decoded, and the limit is 1073741824",
    );
    folder.write("big.png", &lying_png(16_384, 16_384));
    refused(&textured(&folder, "big.png", ""), "says 16384 x 16384 but holds");
    folder.write("big.hdr", b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 60000 +X 60000\n");
    refused(&textured(&folder, "big.hdr", ""), "says 60000 x 60000");
    let jpeg = |width: u16, height: u16| {
        let mut bytes = Cursor::new(Vec::new());
        ImageBuffer::from_pixel(8, 8, Rgb([90u8, 80, 70])).write_to(&mut bytes, ImageFormat::Jpeg).unwrap();
        let mut bytes = bytes.into_inner();
        // The frame header: FF C0, length, precision, height, width.
        let at = bytes.windows(2).position(|w| w == [0xff, 0xc0]).unwrap() + 5;
        bytes[at..at + 2].copy_from_slice(&height.to_be_bytes());
        bytes[at + 2..at + 4].copy_from_slice(&width.to_be_bytes());
        bytes
    };
    folder.write("big.jpg", &jpeg(60_000, 60_000));
    refused(&textured(&folder, "big.jpg", ""), "says 60000 x 60000");
    folder.write("big.jpg", &jpeg(16_000, 16_000));
    refused(&textured(&folder, "big.jpg", ""), "says 16000 x 16000 but holds");
    // EXR: a window of 60000 x 60000 in a file of one pixel.
    let path = folder.0.path().join("big.exr");
    exr::prelude::write_rgb_file(&path, 1, 1, |_, _| (1.0f32, 1.0f32, 1.0f32)).unwrap();
    let mut bytes = std::fs::read(&path).unwrap();
    let name = b"dataWindow\0box2i\0";
    let at = bytes.windows(name.len()).position(|w| w == name).unwrap() + name.len() + 4;
    for (k, edge) in [0i32, 0, 59_999, 59_999].into_iter().enumerate() {
        bytes[at + 4 * k..at + 4 * k + 4].copy_from_slice(&edge.to_le_bytes());
    }
    std::fs::write(&path, &bytes).unwrap();
    refused(&textured(&folder, "big.exr", ""), "says 60000 x 60000");
    bytes.truncate(40);
    std::fs::write(&path, &bytes).unwrap();
    refused(&textured(&folder, "big.exr", ""), "the EXR header does not read");
}

/// Single texels, and samplers in every word glTF has for them and some it has not.
#[test]
fn samplers() {
    let folder = Folder::new();
    folder.write("picture.png", &png(1, 1));
    let sampler = |fields: &str| {
        let text = TRIANGLE.replacen(TEXTURED.0, TEXTURED.1, 1).replacen(
            r#""textures": [{"source": 0}]"#,
            &format!(r#""textures": [{{"source": 0, "sampler": 0}}], "samplers": [{{{fields}}}]"#),
            1,
        );
        let scene = scene::load(&folder.write("triangle.gltf", text.as_bytes())).unwrap();
        let Texture::Image { wrap, filter, minify, .. } = scene.textures[0] else { panic!() };
        (wrap, filter, minify, scene.notes)
    };
    let of = |filter, levels| Minify { filter, levels };
    let (near, linear) = (Filter::Nearest, Filter::Linear);
    for (code, wanted) in [
        (9728, of(near, None)),
        (9729, of(linear, None)),
        (9984, of(near, Some(near))),
        (9985, of(linear, Some(near))),
        (9986, of(near, Some(linear))),
        (9987, of(linear, Some(linear))),
    ] {
        let (_, filter, minify, notes) = sampler(&format!(r#""minFilter": {code}, "magFilter": 9728"#));
        assert_eq!((filter, minify, notes.len()), (near, wanted, 0), "{code}");
    }
    let (wrap, _, minify, notes) = sampler(r#""wrapS": 1, "wrapT": 33071, "minFilter": 3"#);
    assert_eq!((wrap, minify), ([Wrap::Repeat, Wrap::Clamp], Minify::default()));
    assert!(notes.iter().any(|n| n.contains("wrap mode 1 does not exist, repeat taken")), "{notes:?}");
    assert!(notes.iter().any(|n| n.contains("minification filter 3 does not exist, trilinear taken")), "{notes:?}");
    let path = textured(&folder, "picture.png", "mipmap = \"nearest\"\n[film]\ntexture_filter = \"mipmap\"");
    let scene = scene::load(&path).unwrap();
    assert_eq!(scene.texture_filter, TextureFilter::Mipmap);
    assert!(matches!(scene.textures[0], Texture::Image { minify: Minify { levels: Some(Filter::Nearest), .. }, .. }));
    refused(&textured(&folder, "picture.png", "mipmap = \"tri\""), "must be \"linear\" or \"nearest\" or \"none\"");
    refused(&textured(&folder, "picture.png", "wrap = \"fold\""), "must be \"repeat\", \"mirror\" or \"clamp\"");
}
