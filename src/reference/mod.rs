//! The oracle: the same light transport in double precision, with its own intersection and its own path loop.
//!
//! `path` is the loop, generic over `world::World` (what the scene is) and `world::Random` (where numbers come from).
//! `replay` is a world over `Prepared`: the device's own records and integer streams, so that path by path one can see where
//! device and oracle part. `independent` is a world over `Scene`: its own transforms, normals, texture look-up and light
//! sampling, so that a fault in `Prepared` shows. `tree` intersects, `surface` holds the rules of shading frames, `render`
//! fills films with rayon. Formulas are written from the papers, never from the GLSL.

pub mod independent;
pub mod known;
pub mod known_nested;
pub mod meters;
pub mod nested;
pub mod path;
mod receiver;
pub mod render;
pub mod replay;
pub mod scenes;
pub mod surface;
pub mod tree;
pub mod world;

#[cfg(test)]
mod tests;
