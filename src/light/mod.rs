//! Lights: how one is chosen, how a direction towards it is sampled, and with which density.
//!
//! Here the maths are f64. `alias`, `triangle`, `sphere` and `sky` are the models that kernels have too (shaders/light, same
//! stems), with the same map from random numbers to directions, for the replay oracle. `integrals` holds known answers. The
//! tables are made in `prepare::lights` and `sky_table`. Every density is per solid angle, in 1/sr; 0 means no sample.

pub mod alias;
#[cfg(test)]
mod independent;
pub mod integrals;
pub mod sky;
pub mod sky_table;
pub mod sphere;
pub mod triangle;
