//! The showcase: a still life on a terrace, made by this code, byte for byte the same on every run.
//!
//! `files()` returns what scenes/showcase.toml reads: `showcase.glb` (turned wood, a hammered copper bowl, a torus knot, chess
//! pieces, a vase, a tumbler with absorption, tiles; three procedural textures and two normal maps) and `showcase_sky.hdr`
//! (an evening sky with a hazy sun). Lengths are rounded to 2^-16 m and colours to bytes, so that the last bit of a platform's
//! sine does not show. The files are committed; the test regenerates and compares them: `steradian generate showcase -o scenes`.

mod glb;
mod mesh;
mod pattern;
mod profile;
mod sky;
pub mod statue;
mod still_life;
pub mod stones;

/// Name and bytes of every generated file.
pub fn files() -> Vec<(&'static str, Vec<u8>)> {
    vec![("showcase.glb", still_life::model()), ("showcase_sky.hdr", sky::picture())]
}

/// What the scenes on which other renderers were timed need besides themselves; made on demand and not committed.
pub fn peer_files() -> Vec<(&'static str, Vec<u8>)> {
    vec![("peer_b_statue.ply", statue::ply()), ("peer_c_sky.exr", small_sun())]
}

/// 256 x 128 of 0.1 with a sun of four texels, as scene c of the comparison has it; f32, since RGBE would round it.
fn small_sun() -> Vec<u8> {
    use exr::prelude::*;
    let pixel = |at: Vec2<usize>| {
        let is_sun = (92..94).contains(&at.x()) && (40..42).contains(&at.y());
        if is_sun { (600.0f32, 550.0f32, 450.0f32) } else { (0.1, 0.1, 0.1) }
    };
    let channels = SpecificChannels::rgb(pixel);
    let image = Image::from_encoded_channels((256, 128), Encoding::FAST_LOSSLESS, channels);
    let mut bytes = std::io::Cursor::new(Vec::new());
    image.write().to_buffered(&mut bytes).expect("an image of f32 in memory can be written");
    bytes.into_inner()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    #[test]
    fn the_committed_files_are_what_the_generator_makes() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
        let mut total = 0;
        for (name, bytes) in super::files() {
            total += bytes.len();
            let stored = std::fs::read(folder.join(name)).unwrap_or_default();
            assert!(stored == bytes, "scenes/{name} differs: `steradian generate showcase -o scenes` makes it again");
        }
        assert!(total < 1_500_000, "{total} bytes are too many to commit");
    }
}
