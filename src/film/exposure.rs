//! Exposure by shutter, film speed and f-number: which radiance a picture shows as white.
//!
//! A film with shutter, ISO and f-number is exposed by the saturation-based speed of ISO 12232:2019: white is the luminous exposure
//! H = 78/S lx s, where a pixel of luminance L gets H = q L t/N^2 with q = 0.65 (Lagarde and de Rousiers 2014, "Moving Frostbite to
//! physically based rendering", section 5.1); then L_white = 1.2 2^EV100 cd/m2, EV100 = log2(N^2/t 100/S). A radiance of
//! 1 W/(m2 sr) has the luminance 683 Y. Keys: docs/scene.md, [film]; only 8-bit pictures are exposed.

use crate::math::spectrum::LUMEN_PER_WATT;

/// A camera's exposure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shutter {
    pub time_s: f64,
    pub iso: f64,
    pub f_number: f64,
}

/// ISO 12232: lens transmittance, vignetting and angle together.
const Q: f64 = 0.65;
/// ISO 12232: luminous exposure that saturates, times the speed, lx s.
const SATURATION: f64 = 78.0;

impl Shutter {
    /// log2(N^2/t 100/S).
    pub fn ev100(&self) -> f64 {
        (self.f_number * self.f_number / self.time_s * 100.0 / self.iso).log2()
    }

    /// Luminous exposure of the film where the scene has luminance `luminance` cd/m2, in lx s: the illuminance over the time.
    pub fn luminous_exposure(&self, luminance: f64) -> f64 {
        Q * luminance * self.time_s / (self.f_number * self.f_number)
    }

    /// The exposure in stops for which white is what saturates the film.
    pub fn exposure_ev(&self) -> f64 {
        (self.luminous_exposure(LUMEN_PER_WATT) / (SATURATION / self.iso)).log2()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sunny 16: f/16, 1/100 s, ISO 100 is EV 14.6; white is 1.2 2^EV cd/m2. A stop is a factor 2, by whichever of the three.
    #[test]
    fn exposure_by_shutter_iso_and_f_number() {
        let sunny = Shutter { time_s: 0.01, iso: 100.0, f_number: 16.0 };
        assert!((sunny.ev100() - 14.643_856_189_774_724).abs() < 1e-12);
        let white = 1.2 * sunny.ev100().exp2();
        assert!((white / 30_720.0 - 1.0).abs() < 1e-12);
        assert!((sunny.luminous_exposure(white) - 0.78).abs() < 1e-12, "78/S lx s at white");
        assert!((sunny.exposure_ev().exp2() * white / LUMEN_PER_WATT - 1.0).abs() < 1e-12);
        for (change, stops) in [
            (Shutter { time_s: 0.02, ..sunny }, 1.0),
            (Shutter { iso: 400.0, ..sunny }, 2.0),
            (Shutter { f_number: 8.0, ..sunny }, 2.0),
        ] {
            assert!((change.exposure_ev() - sunny.exposure_ev() - stops).abs() < 1e-12, "{change:?}");
        }
    }
}
