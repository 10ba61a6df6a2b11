//! Random numbers: counter-based, the same integers on every device and in Rust.
//!
//! The stream is a function of (pixel, sample, dimension, seed). One table, `DIMENSIONS`, maps (vertex, purpose) to a
//! dimension, the same in every kernel, plan and in the reference; the assembler writes it into the GLSL.

/// Four-dimensional sets reserved for a path vertex; unused ones stay reserved.
pub const SETS_PER_VERTEX: u32 = 16;

/// What a random number is for: `set` is one of the vertex's 16 four-dimensional sets, `dim` in 0..4 the place in it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Purpose {
    pub name: &'static str,
    pub set: u32,
    pub dim: u32,
}

macro_rules! dimensions {
    ($($(#[$meta:meta])* $name:ident = ($set:literal, $dim:literal);)*) => {
        $($(#[$meta])* pub const $name: Purpose = Purpose { name: stringify!($name), set: $set, dim: $dim };)*
        /// Every purpose; GLSL gets each as `const uvec2 NAME = uvec2(set, dim)`.
        pub const DIMENSIONS: &[Purpose] = &[$($name),*];
    };
}

dimensions! {
    /// Film position inside the pixel (vertex 0).
    PIXEL_X = (0, 0);
    PIXEL_Y = (0, 1);
    /// Which light: alias table index word and fraction word.
    LIGHT_INDEX = (1, 0);
    LIGHT_FRACTION = (1, 1);
    /// Where on the light.
    LIGHT_U = (2, 0);
    LIGHT_V = (2, 1);
    /// Which cell of the sky: alias table index word and fraction word.
    SKY_INDEX = (2, 2);
    SKY_FRACTION = (2, 3);
    BSDF_LOBE = (3, 0);
    BSDF_U = (3, 1);
    BSDF_V = (3, 2);
    ROULETTE = (4, 0);
}
