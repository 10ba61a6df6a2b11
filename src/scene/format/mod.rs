//! Scene file formats, one file each; `load` picks by the extension.

mod clean;
pub mod gltf;
pub mod image_file;
pub mod obj;
pub mod ply;
mod polygon;
mod tangents;
pub mod toml;

use std::path::Path;

use super::{Error, Scene};

/// What to take of a file that offers several.
#[derive(Clone, Copy, Debug, Default)]
pub struct Choice<'a> {
    /// Name of a material variant (KHR_materials_variants); None takes the materials that the primitives name.
    pub variant: Option<&'a str>,
    /// Number of the scene, from 0; None takes the file's default.
    pub scene: Option<usize>,
}

/// `load_choice` without a choice.
pub fn load(path: &Path) -> Result<Scene, Error> {
    load_choice(path, Choice::default())
}

/// Reads a scene file. The camera may be unplaced and the light missing: see `scene::frame_camera`, `scene::ensure_light`.
pub fn load_choice(path: &Path, choice: Choice<'_>) -> Result<Scene, Error> {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
    let refuse = |reason: String| Err(Error::Format { path: path.to_path_buf(), reason });
    let is_chosen = choice.variant.is_some() || choice.scene.is_some();
    let mut scene = match extension.as_str() {
        "gltf" | "glb" | "obj" | "ply" => load_model(path, choice).map(|loaded| loaded.scene),
        "toml" if is_chosen => refuse(
            "a variant or a scene is chosen in a .gltf or .glb file; here write `variant` or `scene` in its [[model]]"
                .into(),
        ),
        "toml" => toml::load(path),
        _ if path.is_dir() => refuse("is a directory; name the scene file inside it".into()),
        _ if !path.exists() => Err(Error::read(path, &std::io::Error::from(std::io::ErrorKind::NotFound))),
        "" => refuse("has no extension, so its format is unknown; name a .toml, .gltf, .glb, .obj or .ply file".into()),
        _ => refuse(format!(".{extension} is not a scene format; name a .toml, .gltf, .glb, .obj or .ply file")),
    }?;
    scene.source = path.to_path_buf();
    if scene.name.is_empty() {
        scene.name = path.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
    }
    Ok(scene)
}

/// Reads a model: a file that `[[model]]` can bring into a scene.
pub(crate) fn load_model(path: &Path, choice: Choice<'_>) -> Result<gltf::Loaded, Error> {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
    let refuse = |reason: &str| Err(Error::Format { path: path.to_path_buf(), reason: reason.into() });
    let is_chosen = choice.variant.is_some() || choice.scene.is_some();
    match extension.as_str() {
        "gltf" | "glb" => gltf::load(path, choice),
        "obj" | "ply" if is_chosen => refuse("holds one scene and no variants; leave the choice out"),
        "obj" => obj::load(path),
        "ply" => ply::load(path),
        _ => refuse("is no model; name a .gltf, .glb, .obj or .ply file"),
    }
}

/// The bytes of a file, with the project's words for what can go wrong.
pub(crate) fn read_bytes(path: &Path) -> Result<Vec<u8>, Error> {
    if path.is_dir() {
        return Err(Error::read(path, &std::io::Error::from(std::io::ErrorKind::IsADirectory)));
    }
    std::fs::read(path).map_err(|e| Error::read(path, &e))
}
