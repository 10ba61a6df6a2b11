//! GGX microfacets (Walter et al. 2007, eq. 33; Trowbridge and Reitz 1975), anisotropic, with the height-correlated Smith
//! term (Heitz 2014, eq. 99) and visible-normal sampling by spherical caps (Dupuy and Benyoub 2023, listing 3).
//! f64 as the papers write it; shaders/bsdf/ggx.glsl cancels the cosines beforehand. Directions here have z > 0 unless said.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

/// Below this width (both alphas) a surface is a mirror: the f32 half vector no longer resolves the lobe.
pub const SMOOTH_ALPHA: f64 = 1e-3;
/// The narrower alpha of an anisotropic surface is not allowed below.
pub const MIN_ALPHA: f64 = 1e-4;

/// Widths along x and y of the local frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ggx {
    pub alpha_x: f64,
    pub alpha_y: f64,
    pub is_smooth: bool,
}

impl Ggx {
    /// alpha = roughness^2 for each axis; `roughness_y < 0` means the same as x.
    pub fn from_roughness(roughness: f64, roughness_y: f64) -> Self {
        let x = roughness.clamp(0.0, 1.0).powi(2);
        let y = if roughness_y < 0.0 { x } else { roughness_y.min(1.0).powi(2) };
        Self { alpha_x: x.max(MIN_ALPHA), alpha_y: y.max(MIN_ALPHA), is_smooth: x.max(y) < SMOOTH_ALPHA }
    }

    /// Density of facet normals: int D(h) h.z dh = 1.
    pub fn d(&self, h: DVec3) -> f64 {
        let (x, y) = (h.x / self.alpha_x, h.y / self.alpha_y);
        let s = x * x + y * y + h.z * h.z;
        1.0 / (PI * self.alpha_x * self.alpha_y * s * s)
    }

    /// Smith's Lambda (Heitz 2014, eq. 72); `w.z != 0`.
    pub fn lambda(&self, w: DVec3) -> f64 {
        let (x, y) = (self.alpha_x * w.x, self.alpha_y * w.y);
        let a = (x * x + y * y) / (w.z * w.z);
        // (sqrt(1+a)-1)/2 without its cancellation
        0.5 * a / (1.0 + (1.0 + a).sqrt())
    }

    /// Fraction of the facets seen from `w`.
    pub fn g1(&self, w: DVec3) -> f64 {
        1.0 / (1.0 + self.lambda(w))
    }

    /// Fraction seen from both; the same form for reflection and refraction.
    pub fn g2(&self, o: DVec3, i: DVec3) -> f64 {
        1.0 / (1.0 + self.lambda(o) + self.lambda(i))
    }

    /// Density of `sample_visible`, per solid angle of h (Heitz 2018, eq. 3).
    pub fn visible_pdf(&self, o: DVec3, h: DVec3) -> f64 {
        self.g1(o) * o.dot(h).max(0.0) * self.d(h) / o.z
    }

    /// Density of reflections about visible normals: `visible_pdf` over 4 o.h, which cancels.
    pub fn reflection_pdf(&self, o: DVec3, h: DVec3) -> f64 {
        self.g1(o) * self.d(h) / (4.0 * o.z)
    }

    /// Facet normal seen from `o`, `o.z > 0`.
    pub fn sample_visible(&self, o: DVec3, u: [f64; 2]) -> DVec3 {
        let o_std = DVec3::new(self.alpha_x * o.x, self.alpha_y * o.y, o.z).normalize();
        let z = (1.0 - u[1]) * (1.0 + o_std.z) - o_std.z;
        let r = (1.0 - z * z).max(0.0).sqrt();
        let phi = TAU * u[0];
        let h_std = DVec3::new(r * phi.cos(), r * phi.sin(), z) + o_std;
        // h_std.z >= 0 in exact arithmetic; the bound keeps h above the horizon after rounding.
        DVec3::new(self.alpha_x * h_std.x, self.alpha_y * h_std.y, h_std.z.max(1e-300)).normalize()
    }

    /// Width of the isotropic surface that masks as much along `w`; the geometric mean towards the pole.
    pub fn alpha_towards(&self, w: DVec3) -> f64 {
        let (x, y) = (self.alpha_x * w.x, self.alpha_y * w.y);
        (x * x + y * y + self.alpha_x * self.alpha_y * w.z * w.z).sqrt()
    }

    /// Width of an isotropic surface that loses at least as much on average: between the root mean square and the wider one,
    /// so that the compensated surface stays below 1.
    pub fn alpha_average(&self) -> f64 {
        let rms = (0.5 * (self.alpha_x * self.alpha_x + self.alpha_y * self.alpha_y)).sqrt();
        0.5 * (rms + self.alpha_x.max(self.alpha_y))
    }
}

/// `w` mirrored about `h`.
pub fn reflect(w: DVec3, h: DVec3) -> DVec3 {
    h * (2.0 * w.dot(h)) - w
}

/// Half vector, above the surface; None where o = -i.
pub fn half_vector(o: DVec3, i: DVec3) -> Option<DVec3> {
    let h = (o + i).try_normalize()?;
    Some(if h.z < 0.0 { -h } else { h })
}

/// Cosine of either direction with their half vector. Half the length of the sum: o.h would cancel at grazing incidence.
pub fn half_cosine(o: DVec3, i: DVec3) -> f64 {
    (0.5 * (o + i).length()).min(1.0)
}
