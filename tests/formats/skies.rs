//! The sky of scenes/mirror_ball.toml, made here: four quarters of four colours.

use std::path::Path;

use steradian::scene::{self, Pixels};

/// Left to right: u = 0.5 is -z, and the right half is +x.
fn quarters() -> Vec<u8> {
    const WIDTH: usize = 64;
    let (red, green, blue, yellow) = ([1.0, 0.1, 0.1], [0.1, 1.0, 0.1], [0.1, 0.1, 1.0], [1.0, 1.0, 0.1]);
    let pixels: Vec<image::Rgb<f32>> = (0..WIDTH * WIDTH / 2)
        .map(|i| match (i % WIDTH) * 8 / WIDTH {
            3 | 4 => red,
            5 | 6 => green,
            1 | 2 => yellow,
            _ => blue,
        })
        .map(image::Rgb)
        .collect();
    let mut bytes = Vec::new();
    image::codecs::hdr::HdrEncoder::new(&mut bytes).encode(&pixels, WIDTH, WIDTH / 2).unwrap();
    bytes
}

#[test]
fn quarters_hdr_is_what_its_maker_makes() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/textures/quarters.hdr");
    if std::env::var_os("STERADIAN_BLESS").is_some() {
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(&path, quarters()).unwrap();
    }
    assert!(std::fs::read(&path).unwrap() == quarters(), "run STERADIAN_BLESS=1 cargo test --test formats quarters");
    let scene = scene::load(&path.parent().unwrap().join("../mirror_ball.toml")).unwrap();
    let Pixels::RgbF32(pixels) = &scene.images[0].pixels else { panic!() };
    // The middle of the picture is -z, red.
    assert!(pixels[32 * 3] > 0.9 && pixels[32 * 3 + 1] < 0.2);
}
