//! From features to SPIR-V: records, GLSL text, compilation, reflection.

pub mod record;
