//! From radiance to a picture of 8 bits: exposure, then a tone curve, then sRGB. EXR and HDR files hold radiance and know none of it.
//!
//! `neutral` is the Khronos PBR Neutral tone mapper (Khronos Group 2024, "Khronos PBR Neutral Tone Mapper", specification 1.0):
//! colours up to 0.8 stay as the material's base colour under a light of 1, brighter ones are compressed towards white.
//! The exposure of a camera's settings is `film::exposure`.

/// How brightness beyond white is treated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Tonemap {
    /// Clipped.
    #[default]
    None,
    /// Khronos PBR Neutral.
    Neutral,
}

/// What a PNG is made with.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Look {
    /// Factor on radiance, as a power of two.
    pub exposure_ev: f64,
    pub tonemap: Tonemap,
}

impl From<f64> for Look {
    fn from(exposure_ev: f64) -> Self {
        Self { exposure_ev, tonemap: Tonemap::None }
    }
}

impl Look {
    /// Linear Rec.709 that sRGB is made from; not yet clipped.
    pub fn apply(&self, radiance: [f32; 3]) -> [f32; 3] {
        let gain = self.exposure_ev.exp2();
        let exposed = radiance.map(|v| f64::from(v) * gain);
        match self.tonemap {
            Tonemap::None => exposed,
            Tonemap::Neutral => neutral(exposed.map(|v| if v.is_nan() { 0.0 } else { v.clamp(0.0, 1e30) })),
        }
        .map(|v| v as f32)
    }
}

/// Reflectance of a dielectric at normal incidence, which is taken off as a glare.
const GLARE: f64 = 0.04;
/// Where compression starts: 0.8 before the glare is taken off.
const START: f64 = 0.8 - GLARE;
/// How fast bright colours go to white.
const DESATURATION: f64 = 0.15;

/// Section "Implementation" of the specification; colour >= 0.
fn neutral(color: [f64; 3]) -> [f64; 3] {
    let least = color[0].min(color[1]).min(color[2]);
    // Down to 0 with a slope of 1 at 2 GLARE: least - offset = 6.25 least^2.
    let offset = if least < 2.0 * GLARE { least - least * least / (4.0 * GLARE) } else { GLARE };
    let color = color.map(|v| v - offset);
    let peak = color[0].max(color[1]).max(color[2]);
    if peak < START {
        return color;
    }
    let room = 1.0 - START;
    let compressed = 1.0 - room * room / (peak + room - START);
    let kept = 1.0 / (DESATURATION * (peak - compressed) + 1.0);
    color.map(|v| v * (compressed / peak) * kept + compressed * (1.0 - kept))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values by hand from the specification's text, to 12 digits, by another program.
    #[test]
    fn neutral_meets_its_specification() {
        let cases = [
            ([0.0, 0.0, 0.0], [0.0, 0.0, 0.0]),
            ([0.04, 0.04, 0.04], [0.01, 0.01, 0.01]),
            ([0.5, 0.3, 0.02], [0.4825, 0.2825, 0.0025]),
            ([0.8, 0.8, 0.8], [0.76, 0.76, 0.76]),
            NEUTRAL_BRIGHT[0],
            NEUTRAL_BRIGHT[1],
            NEUTRAL_BRIGHT[2],
        ];
        for (color, wanted) in cases {
            let found = neutral(color);
            for c in 0..3 {
                assert!((found[c] - wanted[c]).abs() < 1e-12, "{color:?}: {found:?}, not {wanted:?}");
            }
        }
        let look = Look { exposure_ev: 0.0, tonemap: Tonemap::Neutral };
        for strange in [f32::NAN, f32::INFINITY, -1.0] {
            assert!(look.apply([strange, 1.0, 0.0]).iter().all(|v| (0.0..=1.0).contains(v)), "{strange}");
        }
    }

    /// Rises everywhere, stays below 1.
    #[test]
    fn neutral_is_monotonic_in_grey() {
        let greys: Vec<f64> = (0..100_000).map(|i| neutral([f64::from(i) * 1e-3; 3])[0]).collect();
        assert!(greys.windows(2).all(|w| w[0] < w[1]) && greys.iter().all(|v| *v < 1.0));
    }

    const NEUTRAL_BRIGHT: [([f64; 3], [f64; 3]); 3] = [
        ([1.0, 1.0, 1.0], [0.869090909090909, 0.869090909090909, 0.869090909090909]),
        ([4.0, 2.0, 0.5], [0.983255813953488, 0.639951387047775, 0.382473066868490]),
        ([100.0, 0.0, 3.0], [0.999420989143546, 0.936366382661004, 0.938258020855481]),
    ];
}
