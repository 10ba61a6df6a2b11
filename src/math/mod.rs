//! f64 mathematics of the host and the oracle: warps, frames, spectra, special functions.

pub mod cie;
pub mod frame;
pub mod special;
pub mod spectrum;
pub mod warp;
