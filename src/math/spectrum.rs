//! Spectra to colour: CIE 1931 XYZ and linear Rec.709, and the RGB index of refraction of a metal.
//!
//! Sums run over the 5 nm table of `cie`; curves are linear between their samples and constant beyond the ends. Rec.709's
//! matrix follows from its primaries (ITU-R BT.709, item 1.4) and the white of the table itself, so that a reflectance of 1
//! under D65 is exactly (1, 1, 1). Spectral transport would be a build with another `Spectrum`; here it is RGB.

use glam::{DMat3, DVec3};

use super::cie::{CIE_1931_D65, FIRST_NM, STEP_NM};
use crate::scene::Curve;

/// Radiometric quantity in every channel of the transport.
pub type Spectrum = DVec3;

/// Maximum luminous efficacy, lm/W (SI).
pub const LUMEN_PER_WATT: f64 = 683.0;

/// Sine and cosine of the second angle at which a metal's RGB index keeps the reflectance: 80 degrees.
const GRAZING_COS: f64 = 0.173_648_177_666_930_33;

/// No metal comes near it; beyond, a channel clamped at 0.9999 would run off to 40000 for the last digit.
const LARGEST_ETA: f64 = 10.0;

impl Curve {
    /// Value at a wavelength; 0 for an empty curve.
    pub fn at(&self, nm: f64) -> f64 {
        let count = self.wavelength_nm.len().min(self.value.len());
        if count == 0 {
            return 0.0;
        }
        let i = self.wavelength_nm[..count].partition_point(|&w| w <= nm);
        if i == 0 || i == count {
            return self.value[i.saturating_sub(1)];
        }
        let (w0, w1) = (self.wavelength_nm[i - 1], self.wavelength_nm[i]);
        self.value[i - 1] + (self.value[i] - self.value[i - 1]) * ((nm - w0) / (w1 - w0))
    }
}

/// Relative spectral power of D65 at a table row's wavelength, and of the equal-energy illuminant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Illuminant {
    D65,
    E,
}

/// Integral of `power` [x/nm] against the colour matching functions, in the unit x.
pub fn xyz(power: impl Fn(f64) -> f64) -> DVec3 {
    rows().map(|(nm, cmf, _)| cmf * power(nm) * STEP_NM).sum()
}

/// XYZ of a surface of this reflectance, Y = 1 for the perfect diffuser.
pub fn reflectance_xyz(reflectance: impl Fn(f64) -> f64, illuminant: Illuminant) -> DVec3 {
    let light = |d65: f64| if illuminant == Illuminant::D65 { d65 } else { 1.0 };
    let (sum, white) = rows().fold((DVec3::ZERO, DVec3::ZERO), |(sum, white), (nm, cmf, d65)| {
        let lit = cmf * light(d65);
        (sum + lit * reflectance(nm), white + lit)
    });
    sum / white.y
}

/// Linear Rec.709 of XYZ, both with Y of white = 1 (or any common unit: the map is linear).
pub fn xyz_to_rec709(xyz: DVec3) -> DVec3 {
    rec709_to_xyz().inverse() * xyz
}

/// Columns are the primaries scaled so that (1, 1, 1) is the white of D65.
pub fn rec709_to_xyz() -> DMat3 {
    let primary = |x: f64, y: f64| DVec3::new(x / y, 1.0, (1.0 - x - y) / y);
    let primaries = DMat3::from_cols(primary(0.64, 0.33), primary(0.30, 0.60), primary(0.15, 0.06));
    let scale = primaries.inverse() * reflectance_xyz(|_| 1.0, Illuminant::D65);
    primaries * DMat3::from_diagonal(scale)
}

/// Linear Rec.709 reflectance under D65. A saturated spectrum can leave [0, 1]; the caller decides what then.
pub fn reflectance_rgb(reflectance: impl Fn(f64) -> f64) -> DVec3 {
    xyz_to_rec709(reflectance_xyz(reflectance, Illuminant::D65))
}

/// RGB radiance [W/(m2 sr)] with the luminance (683 Y) and chromaticity of a spectral radiance [W/(m2 sr nm)].
pub fn radiance_rgb(radiance: impl Fn(f64) -> f64) -> DVec3 {
    xyz_to_rec709(xyz(radiance))
}

/// Linear Rec.709 of luminance 1 with the chromaticity of a black body (Planck's law; hc/k of the SI of 2019). What lies outside
/// Rec.709, below some 1900 K, is held to its edge.
pub fn blackbody_rgb(kelvin: f64) -> DVec3 {
    const SECOND_RADIATION_NM_K: f64 = 1.438_776_877e7;
    // Relative to 560 nm, so that neither end of the range leaves f64.
    let exponent = |nm: f64| SECOND_RADIATION_NM_K / (nm * kelvin);
    let power = |nm: f64| (560.0 / nm).powi(5) * exponent(560.0).exp_m1() / exponent(nm).exp_m1();
    let rgb = xyz_to_rec709(xyz(power)).max(DVec3::ZERO);
    rgb / super::special::luminance(rgb)
}

fn rows() -> impl Iterator<Item = (f64, DVec3, f64)> {
    (0u32..).zip(CIE_1931_D65).map(|(i, r)| (FIRST_NM + STEP_NM * f64::from(i), DVec3::new(r[0], r[1], r[2]), r[3]))
}

/// Unpolarised reflectance of a conductor in vacuum, index eta - ik (Born and Wolf, section 14.2, in the real form).
pub fn conductor_reflectance(cos: f64, eta: f64, k: f64) -> f64 {
    let (cos2, eta2, k2) = (cos * cos, eta * eta, k * k);
    let sin2 = 1.0 - cos2;
    let t0 = eta2 - k2 - sin2;
    let a2_b2 = (t0 * t0 + 4.0 * eta2 * k2).sqrt();
    let a = (0.5 * (a2_b2 + t0)).max(0.0).sqrt();
    let rs = (a2_b2 + cos2 - 2.0 * a * cos) / (a2_b2 + cos2 + 2.0 * a * cos);
    let (t3, t4) = (cos2 * a2_b2 + sin2 * sin2, 2.0 * a * cos * sin2);
    let rp = rs * (t3 - t4) / (t3 + t4);
    0.5 * (rs + rp)
}

/// (eta, k) in RGB whose reflectances at normal incidence and at 80 degrees are the RGB of the spectral reflectances there.
///
/// Averaged indices would not do: reflectance is not linear in them. Per channel the normal reflectance r fixes k for every eta
/// in [(1-r)/(1+r), (1+sqrt r)/(1-sqrt r)] (Gulbrandsen 2014, JCGT 3(4), eqs. 5 and 6); eta is then searched for the other
/// angle, and where that is out of reach the nearest is taken. Channels outside (0, 1) - metals of a colour outside Rec.709 -
/// are clamped to [0.001, 0.9999] first, and then need not reach the second angle.
pub fn fit_conductor_rgb(eta: &Curve, k: &Curve) -> (DVec3, DVec3) {
    let at = |cos: f64| {
        let rgb = reflectance_rgb(|nm| conductor_reflectance(cos, eta.at(nm), k.at(nm)));
        rgb.clamp(DVec3::splat(0.001), DVec3::splat(0.9999))
    };
    let (normal, grazing) = (at(1.0), at(GRAZING_COS));
    let fitted: [(f64, f64); 3] = std::array::from_fn(|c| fit_channel(normal[c], grazing[c]));
    (DVec3::from_array(fitted.map(|f| f.0)), DVec3::from_array(fitted.map(|f| f.1)))
}

fn fit_channel(normal: f64, grazing: f64) -> (f64, f64) {
    let (r, root) = (normal, normal.sqrt());
    let (low, high) = ((1.0 - r) / (1.0 + r), ((1.0 + root) / (1.0 - root)).min(LARGEST_ETA));
    let eta = |t: f64| low * (high / low).powf(t);
    let k = |n: f64| ((r * (n + 1.0).powi(2) - (n - 1.0).powi(2)) / (1.0 - r)).max(0.0).sqrt();
    let error = |t: f64| (conductor_reflectance(GRAZING_COS, eta(t), k(eta(t))) - grazing).abs();
    // A scan, because the reflectance need not be monotonic in eta, then a golden-section search around the best.
    let steps = 512;
    let at = |i: u32| f64::from(i) / f64::from(steps);
    let best = (0..=steps).min_by(|&a, &b| error(at(a)).total_cmp(&error(at(b)))).unwrap_or(0);
    let (mut a, mut b) = (at(best.saturating_sub(1)), at((best + 1).min(steps)));
    let golden = 0.618_033_988_749_894_9;
    for _ in 0..64 {
        let (c, d) = (b - golden * (b - a), a + golden * (b - a));
        (a, b) = if error(c) < error(d) { (a, d) } else { (c, b) };
    }
    let n = eta(0.5 * (a + b));
    (n, k(n))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(points: &[(f64, f64)]) -> Curve {
        Curve { wavelength_nm: points.iter().map(|p| p.0).collect(), value: points.iter().map(|p| p.1).collect() }
    }

    #[test]
    fn white_is_white_and_the_matrix_is_rec709() {
        assert!((reflectance_rgb(|_| 1.0) - DVec3::ONE).length() < 1e-12);
        // The second row of the matrix is BT.709's luminance equation.
        let y = rec709_to_xyz().row(1);
        assert!((y - DVec3::new(0.2126, 0.7152, 0.0722)).length() < 3e-4, "{y}");
        let white = reflectance_xyz(|_| 1.0, Illuminant::D65);
        // CIE 15: D65 is (0.3127, 0.3290) in x, y; equal energy is (1/3, 1/3).
        assert!((white.x / white.element_sum() - 0.3127).abs() < 1e-4, "{white}");
        let e = reflectance_xyz(|_| 1.0, Illuminant::E);
        assert!((e - DVec3::ONE).length() < 5e-4, "{e}");
    }

    #[test]
    fn a_line_at_555_nm_has_683_lumens_a_watt() {
        let watt = xyz(|nm| if nm == 555.0 { 1.0 / STEP_NM } else { 0.0 });
        assert!((LUMEN_PER_WATT * watt.y - 683.0).abs() < 0.01, "{watt}");
        let rgb = radiance_rgb(|nm| if nm == 555.0 { 1.0 / STEP_NM } else { 0.0 });
        assert!((rec709_to_xyz() * rgb - watt).length() < 1e-12);
    }

    /// CIE 1931 chromaticities of the Planckian locus: A (2856 K) is (0.4476, 0.4074), 6500 K is (0.3135, 0.3237) (CIE 15:2004).
    #[test]
    fn black_bodies_have_their_chromaticity() {
        for (kelvin, x, y) in [(2856.0, 0.4476, 0.4074), (6500.0, 0.3135, 0.3237)] {
            let xyz = rec709_to_xyz() * blackbody_rgb(kelvin);
            let sum = xyz.element_sum();
            assert!((xyz.x / sum - x).abs() < 3e-4 && (xyz.y / sum - y).abs() < 3e-4, "{kelvin}: {xyz}");
        }
        for kelvin in [500.0, 1000.0, 1e5] {
            let rgb = blackbody_rgb(kelvin);
            assert!(rgb.is_finite() && rgb.min_element() >= 0.0, "{kelvin}: {rgb}");
        }
    }

    #[test]
    fn curves_are_linear_inside_and_constant_outside() {
        let c = curve(&[(400.0, 1.0), (500.0, 3.0)]);
        assert_eq!([300.0, 400.0, 425.0, 500.0, 900.0].map(|w| c.at(w)), [1.0, 1.0, 1.5, 3.0, 3.0]);
        assert_eq!(curve(&[]).at(500.0), 0.0);
    }

    /// Gold, coarsely (Johnson and Christy 1972): reflectances are kept at both angles wherever they are inside the gamut.
    #[test]
    fn fitted_metals_reflect_what_the_spectrum_does() {
        let gold = (
            curve(&[(400.0, 1.66), (450.0, 1.55), (500.0, 0.85), (550.0, 0.43), (600.0, 0.25), (700.0, 0.16)]),
            curve(&[(400.0, 1.96), (450.0, 1.87), (500.0, 1.90), (550.0, 2.46), (600.0, 2.97), (700.0, 3.75)]),
        );
        let iron = (curve(&[(400.0, 2.1), (700.0, 2.9)]), curve(&[(400.0, 2.5), (700.0, 3.1)]));
        for (eta, k) in [&gold, &iron] {
            let (e, kk) = fit_conductor_rgb(eta, k);
            for (cos, tolerance) in [(1.0, 1e-9), (GRAZING_COS, 1e-6), (0.5, 0.01), (0.7, 0.01), (0.05, 0.02)] {
                let spectral = reflectance_rgb(|nm| conductor_reflectance(cos, eta.at(nm), k.at(nm)));
                let at_normal = reflectance_rgb(|nm| conductor_reflectance(1.0, eta.at(nm), k.at(nm)));
                for c in (0..3).filter(|&c| at_normal[c] < 0.9999) {
                    let rgb = conductor_reflectance(cos, e[c], kk[c]);
                    let wanted = spectral[c].clamp(0.001, 0.9999);
                    assert!(
                        (rgb - wanted).abs() < tolerance,
                        "cos {cos} channel {c}: {rgb} against {wanted}, {e} {kk}"
                    );
                }
            }
        }
    }

    #[test]
    fn nonsense_curves_give_finite_indices() {
        let zero = curve(&[]);
        let huge = curve(&[(500.0, 1e6)]);
        for (eta, k) in [(&zero, &zero), (&huge, &huge), (&zero, &huge)] {
            let (e, kk) = fit_conductor_rgb(eta, k);
            assert!(e.is_finite() && kk.is_finite(), "{e} {kk}");
        }
    }
}
