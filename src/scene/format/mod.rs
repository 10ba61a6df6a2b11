//! Scene file formats, one file each; `load` picks by the extension.

mod clean;
pub mod gltf;
pub mod image_file;
mod tangents;
pub mod toml;

use std::path::Path;

use super::{Error, Scene};

/// Reads a scene file. The camera may be unplaced and the light missing: see `scene::frame_camera`, `scene::ensure_light`.
pub fn load(path: &Path) -> Result<Scene, Error> {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
    let refuse = |reason: String| Err(Error::Format { path: path.to_path_buf(), reason });
    let mut scene = match extension.as_str() {
        "toml" => toml::load(path),
        "gltf" | "glb" => gltf::load(path).map(|loaded| loaded.scene),
        "obj" | "ply" => refuse(format!(
            ".{extension} files are not read yet; convert it to .glb, or give its triangles in a .toml scene"
        )),
        _ if path.is_dir() => refuse("is a directory; name the scene file inside it".into()),
        _ if !path.exists() => Err(Error::read(path, &std::io::Error::from(std::io::ErrorKind::NotFound))),
        "" => refuse("has no extension, so its format is unknown; name a .toml, .gltf or .glb file".into()),
        _ => refuse(format!(".{extension} is not a scene format; name a .toml, .gltf or .glb file")),
    }?;
    scene.source = path.to_path_buf();
    if scene.name.is_empty() {
        scene.name = path.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
    }
    Ok(scene)
}

/// The bytes of a file, with the project's words for what can go wrong.
pub(crate) fn read_bytes(path: &Path) -> Result<Vec<u8>, Error> {
    if path.is_dir() {
        return Err(Error::read(path, &std::io::Error::from(std::io::ErrorKind::IsADirectory)));
    }
    std::fs::read(path).map_err(|e| Error::read(path, &e))
}
