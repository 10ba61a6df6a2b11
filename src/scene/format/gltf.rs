//! glTF 2.0.

use std::path::Path;

use crate::scene::{Error, Scene};

/// A model, and where its parts stand in the file.
pub struct Loaded {
    pub scene: Scene,
    /// For each material, its number in the file; None for the default one.
    pub material_source: Vec<Option<usize>>,
    /// For each instance, its node's number.
    pub node_source: Vec<usize>,
}

pub fn load(path: &Path) -> Result<Loaded, Error> {
    super::read_bytes(path)?;
    Err(Error::Format { path: path.to_path_buf(), reason: "glTF is not read yet".into() })
}
