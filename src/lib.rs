//! steradian: a headless, progressive Monte Carlo renderer whose every number can be checked.

#![deny(unsafe_code)]

pub mod bsdf;
pub mod bvh;
pub mod camera;
pub mod conform;
pub mod error;
pub mod film;
pub mod gpu;
pub mod integrator;
pub mod light;
pub mod math;
pub mod measure;
pub mod metric;
pub mod output;
pub mod prepare;
pub mod reference;
pub mod render;
pub mod report;
pub mod sampler;
pub mod scene;
pub mod shader;
pub mod showcase;
pub mod texture;
