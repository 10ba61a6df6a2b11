//! From features to SPIR-V: records, GLSL text, compilation, reflection.

pub mod aovs;
pub mod assemble;
pub mod cache;
pub mod compile;
pub mod dispatch;
pub mod record;
pub mod reflect;
pub mod source;
pub mod tables;

#[cfg(test)]
mod snapshots;
