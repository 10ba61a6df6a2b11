//! Scene files, good and bad: every message is held to its words, and the sample models load.

mod assets;
mod bad;
mod damage;
mod gltf;
mod lights;
mod obj;
mod pictures;
mod ply;
mod silent;
mod skies;
#[path = "../support/triangle.rs"]
mod triangle;

/// The folder of sample models, or None after saying so: the skip is counted in the output.
fn assets_folder() -> Option<std::path::PathBuf> {
    let folder = std::env::var_os("STERADIAN_ASSETS")
        .map(std::path::PathBuf::from)
        .unwrap_or_else(|| std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/assets"));
    if folder.is_dir() {
        return Some(folder);
    }
    println!("skipped: no assets in {}", folder.display());
    None
}
