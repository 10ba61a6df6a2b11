//! Parameter sweeps of glTF's surface.

use super::{Furnace, ROUGHNESS, Sweep};

/// One list an input: base_color, metallic, roughness, ior, transmission, thin, khronos_mix, compensation; specular,
/// specular_color, anisotropy, anisotropy_rotation, anisotropy_direction, clearcoat, clearcoat_roughness.
#[rustfmt::skip]
pub const SWEEPS: &[Sweep] = &[
    // The surface of the core specification.
    Sweep { furnace: Furnace::Unity, refracts_by: None, values: &[
        ONE, &[0.0, 1.0], ROUGHNESS, &[1.5], OFF, ONE, OFF, ONE, ONE, ONE, OFF, OFF, ONE, OFF, OFF] },
    Sweep { furnace: Furnace::Unity, refracts_by: None, values: &[
        ONE, &[0.0, 0.5], &[0.1, 0.6], &[0.0, 1.0, 2.4], OFF, ONE, OFF, ONE, ONE, ONE, OFF, OFF, ONE, OFF, OFF] },
    Sweep { furnace: Furnace::AtMostOne, refracts_by: None, values: &[
        &[0.0, 0.5], &[0.0, 0.3, 1.0], &[0.0, 0.3], &[1.5], OFF, ONE, OFF, &[0.0, 1.0], ONE, ONE, OFF, OFF, ONE, OFF, OFF] },
    // Transmission, thin and refracting.
    Sweep { furnace: Furnace::AtMostOne, refracts_by: None, values: &[
        ONE, &[0.0, 0.3], &[0.0, 0.3, 1.0], &[1.0, 1.5], &[0.6, 1.0], ONE, OFF, ONE, ONE, ONE, OFF, OFF, ONE, OFF, OFF] },
    Sweep { furnace: Furnace::AtMostOne, refracts_by: Some("ior"), values: &[
        ONE, &[0.0, 0.3], &[0.0, 0.3, 1.0], &[1.0, 1.5], &[0.6, 1.0], OFF, OFF, ONE, ONE, ONE, OFF, OFF, ONE, OFF, OFF] },
    Sweep { furnace: Furnace::Exempt, refracts_by: None, values: &[
        &[0.8], &[0.0, 0.5, 1.0], &[0.0, 0.4, 1.0], &[1.5], &[0.0, 0.5], ONE, ONE, ONE, ONE, ONE, OFF, OFF, ONE, OFF, OFF] },
    // Specular: white in the furnace while it is not coloured, whatever its strength.
    Sweep { furnace: Furnace::Unity, refracts_by: None, values: &[
        ONE, &[0.0, 0.5], &[0.0, 0.4], &[1.5], OFF, ONE, OFF, ONE, &[0.0, 0.5], &[0.3, 9.0], OFF, OFF, ONE, OFF, OFF] },
    Sweep { furnace: Furnace::AtMostOne, refracts_by: Some("ior"), values: &[
        ONE, OFF, &[0.0, 0.4], &[1.5], &[0.7], OFF, OFF, ONE, &[0.0, 0.5], ONE, OFF, OFF, ONE, OFF, OFF] },
    // Anisotropy: the albedo of two widths is that of one of them, too low by 0.004 at cos 0.04 and 0.0054 at cos 0.002 (measured).
    Sweep { furnace: Furnace::AtMost(1.006), refracts_by: None, values: &[
        ONE, &[0.0, 1.0], &[0.2, 0.7], &[1.5], OFF, ONE, OFF, ONE, ONE, ONE, &[0.4, 1.0], &[0.9], ONE, OFF, OFF] },
    // Clearcoat.
    Sweep { furnace: Furnace::AtMostOne, refracts_by: None, values: &[
        ONE, &[0.0, 1.0], &[0.0, 0.5, 1.0], &[1.5], OFF, ONE, OFF, ONE, ONE, ONE, OFF, OFF, ONE, ONE, &[0.0, 0.3]] },
    Sweep { furnace: Furnace::AtMost(1.005), refracts_by: None, values: &[
        ONE, &[0.5], &[0.5], &[1.5], OFF, ONE, OFF, ONE, ONE, ONE, &[0.6], &[0.3], ONE, &[0.5], &[0.3]] },
    Sweep { furnace: Furnace::AtMostOne, refracts_by: Some("ior"), values: &[
        &[0.9], &[0.2], &[0.0, 0.4], &[1.5], &[0.7], OFF, OFF, ONE, ONE, ONE, OFF, OFF, ONE, ONE, &[0.3]] },
];

const ONE: &[f64] = &[1.0];
const OFF: &[f64] = &[0.0];
