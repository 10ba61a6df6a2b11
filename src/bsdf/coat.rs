//! A clear dielectric coat: isotropic GGX facets with Schlick's reflectance (1994, eq. 15), present by `weight`; and what it
//! leaves to whatever lies below, by its directional albedo (Kelemen and Szirmay-Kalos 2001). Its own multiple scattering counts as passed.
//! Used by `plastic` and by glTF's clearcoat.

use super::fresnel;
use super::ggx::Ggx;
use super::ggx_albedo::{self, Albedo};

/// The device's half.
pub(super) const SHARED: super::Shared = super::shared("bsdf/coat.glsl");

#[derive(Clone, Copy, Debug)]
pub struct Coat {
    pub ggx: Ggx,
    pub f0: f64,
    pub weight: f64,
}

impl Coat {
    pub fn new(roughness: f64, f0: f64, weight: f64) -> Self {
        Self { ggx: Ggx::from_roughness(roughness, -1.0), f0, weight }
    }

    /// Reflectance of a facet at the cosine, presence included.
    pub fn fresnel(&self, cos: f64) -> f64 {
        self.weight * fresnel::schlick(cos, glam::DVec3::splat(self.f0)).x
    }

    /// Share of the light from this cosine that the facets send back.
    pub fn reflected(&self, cos: f64) -> f64 {
        let a = if self.ggx.is_smooth {
            Albedo { deficit: 0.0, schlick: (1.0 - cos).powi(5) }
        } else {
            ggx_albedo::table().at(cos, self.ggx.alpha_x)
        };
        self.weight * self.albedo(a)
    }

    /// The rest, which goes through.
    pub fn through(&self, cos: f64) -> f64 {
        1.0 - self.reflected(cos)
    }

    /// Cosine-weighted average of `through` over the hemisphere.
    pub fn through_average(&self) -> f64 {
        let a = if self.ggx.is_smooth {
            Albedo { deficit: 0.0, schlick: 1.0 / 21.0 }
        } else {
            ggx_albedo::table().average(self.ggx.alpha_x)
        };
        1.0 - self.weight * self.albedo(a)
    }

    fn albedo(&self, a: Albedo) -> f64 {
        self.f0 * (1.0 - a.deficit) + (1.0 - self.f0) * a.schlick
    }
}
