//! From features to SPIR-V: records, GLSL text, compilation, reflection.

pub mod cache;
pub mod compile;
pub mod record;
pub mod reflect;
pub mod source;
