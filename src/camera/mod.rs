//! Cameras: where a ray through a place of the film goes. One camera is one file here and one GLSL file of the same stem.
//!
//! All records are rebased so that the camera stands at the origin (`prepare`): a camera gives directions only.

pub mod perspective;

/// Stem of the camera's GLSL file. There is one camera, so no record names its kind.
pub const KEYWORD: &str = "perspective";
