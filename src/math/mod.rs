//! f64 mathematics of the host and the oracle: warps, frames, spectra, special functions.

pub mod frame;
pub mod special;
pub mod warp;
