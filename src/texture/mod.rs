//! Textures: what a pattern can look up at (u, v). One kind is one file here, one GLSL file of the same stem and one variant
//! of `scene::Texture`. Pages are packed into table `texels`; gate 3 (src/conform/texture.rs) compares GLSL with the f64 here.

pub mod checker;
pub mod constant;
pub mod image;
pub mod mip;

pub use image::{Page, lookup, pack, record};
pub use mip::{CONE_SHARE, follows_footprint, pack_levels};
