//! Files changed at random: whatever they hold then, the reader answers with a scene or with one sentence.

use std::path::PathBuf;

use steradian::scene;

/// Loads `rounds` versions of some files with one to three bytes changed in one of them, which `write` puts in place and names;
/// says how many loaded.
pub fn damaged(rounds: usize, files: &[&[u8]], mut write: impl FnMut(&[Vec<u8>]) -> PathBuf) -> usize {
    // Marsaglia 2003, xorshift.
    let mut state = 0x9e37_79b9u32;
    let mut random = |below: usize| {
        state ^= state << 13;
        state ^= state >> 17;
        state ^= state << 5;
        state as usize % below
    };
    let mut loaded = 0;
    for _ in 0..rounds {
        let mut parts: Vec<Vec<u8>> = files.iter().map(|f| f.to_vec()).collect();
        let part = random(parts.len());
        for _ in 0..1 + random(3) {
            let at = random(parts[part].len());
            match random(4) {
                0 => parts[part][at] = random(256) as u8,
                1 => parts[part][at] = b"0123456789-e."[random(13)],
                2 => parts[part][at] = b" \n/\\#f-"[random(7)],
                _ => parts[part].truncate(at.max(1)),
            }
        }
        match scene::load(&write(&parts)) {
            Ok(mut scene) => {
                scene::frame_camera(&mut scene);
                scene::ensure_light(&mut scene);
                loaded += 1;
            }
            Err(e) => assert!(!e.to_string().contains('\n'), "{e}"),
        }
    }
    loaded
}
