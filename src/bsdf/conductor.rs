//! Metal: GGX facets (src/bsdf/ggx.rs) with the exact Fresnel reflectance of a complex index, and optionally the light that
//! single scattering loses, given back by the reciprocal lobe of Kulla and Conty 2017 (Revisiting physically based shading).
//! An anisotropic surface takes, for each direction, the deficit of the isotropic one that is as wide along it.

use std::f64::consts::FRAC_1_PI;

use glam::DVec3;

use super::ggx::{Ggx, half_cosine, half_vector, reflect};
use super::ggx_albedo::{self, Albedo, multiple_scattering, multiple_scattering_color};
use super::{Bsdf, BsdfSample, Input, Model, SAMPLE_DELTA, Shared, When, fresnel, is_chosen, shared};

pub const MODEL: Model = Model {
    keyword: "conductor",
    glsl_type: "Conductor",
    inputs: &[
        Input::color("eta", [0.2, 0.92, 1.1], (0.0, 100.0), "real part of the index of refraction").index(),
        Input::color("k", [3.9, 2.45, 2.14], (0.0, 100.0), "imaginary part of the index of refraction").index(),
        Input::scalar("roughness", 0.1, (0.0, 1.0), "0 smooth, 1 rough; GGX alpha = roughness^2"),
        Input::scalar("roughness_y", -1.0, (-1.0, 1.0), "roughness along the bitangent; -1: the same as roughness"),
        Input::scalar(
            "compensation",
            1.0,
            (0.0, 1.0),
            "1: give back what facets scatter more than once; 0: single scattering only",
        ),
    ],
    transmits: false,
    transmission_input: None,
    tables: &["ggx_albedo"],
    macros: &[("CONDUCTOR_COMPENSATION", When::NotZero(&["compensation"]))],
    shared: &[
        shared("bsdf/fresnel.glsl"),
        shared("bsdf/ggx.glsl"),
        Shared { only_with: Some("CONDUCTOR_COMPENSATION"), ..ggx_albedo::SHARED },
    ],
    doc: "metal, smooth or rough, isotropic or brushed",
};

#[derive(Clone, Copy, Debug)]
pub struct Conductor {
    pub eta: DVec3,
    pub k: DVec3,
    pub ggx: Ggx,
    pub is_compensated: bool,
    /// Averages of the facets' albedo, and the colour of multiple scattering.
    average: Albedo,
    multiple_color: DVec3,
}

impl Conductor {
    pub fn from_inputs(inputs: &[DVec3]) -> Self {
        let (eta, k) = (inputs[0].max(DVec3::ZERO), inputs[1].max(DVec3::ZERO));
        let ggx = Ggx::from_roughness(inputs[2].x, inputs[3].x);
        let average = ggx_albedo::table().average(ggx.alpha_average());
        Self {
            eta,
            k,
            ggx,
            is_compensated: inputs[4].x >= 0.5 && !ggx.is_smooth,
            average,
            multiple_color: multiple_scattering_color(fresnel::conductor_average(eta, k), average),
        }
    }

    fn albedo_at(&self, w: DVec3) -> Albedo {
        ggx_albedo::table().at(w.z, self.ggx.alpha_towards(w))
    }

    /// Probability of the cosine lobe: the share of light that leaves after more than one facet, at F = 1.
    fn multiple_probability(&self, wo: DVec3) -> f64 {
        if self.is_compensated { self.albedo_at(wo).deficit } else { 0.0 }
    }

    fn eval_pdf(&self, wo: DVec3, wi: DVec3) -> (DVec3, f64) {
        if wo.z <= 0.0 || wi.z <= 0.0 || self.ggx.is_smooth {
            return (DVec3::ZERO, 0.0);
        }
        let Some(h) = half_vector(wo, wi) else { return (DVec3::ZERO, 0.0) };
        let f = fresnel::conductor(half_cosine(wo, wi), self.eta, self.k);
        let mut value = f * (self.ggx.d(h) * self.ggx.g2(wo, wi) / (4.0 * wo.z));
        let p = self.multiple_probability(wo);
        if self.is_compensated {
            let lobe = multiple_scattering(self.albedo_at(wo), self.albedo_at(wi), self.average, wi.z);
            value += self.multiple_color * lobe;
        }
        let pdf = (1.0 - p) * self.ggx.reflection_pdf(wo, h) + p * FRAC_1_PI * wi.z;
        (value, pdf)
    }
}

impl Bsdf for Conductor {
    fn eval(&self, wo: DVec3, wi: DVec3) -> DVec3 {
        self.eval_pdf(wo, wi).0
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        self.eval_pdf(wo, wi).1
    }

    fn sample(&self, wo: DVec3, choice: u32, u: [f64; 2]) -> Option<BsdfSample> {
        if wo.z <= 0.0 {
            return None;
        }
        if self.ggx.is_smooth {
            let wi = DVec3::new(-wo.x, -wo.y, wo.z);
            let weight = fresnel::conductor(wo.z, self.eta, self.k);
            return Some(BsdfSample { wi, weight, pdf: 1.0, flags: SAMPLE_DELTA, eta_scale: 1.0 });
        }
        let is_multiple = is_chosen(choice, self.multiple_probability(wo));
        let wi = if is_multiple {
            crate::math::warp::cosine_hemisphere(u)
        } else {
            reflect(wo, self.ggx.sample_visible(wo, u))
        };
        let (value, pdf) = self.eval_pdf(wo, wi);
        (pdf > 0.0).then(|| BsdfSample { wi, weight: value / pdf, pdf, flags: 0, eta_scale: 1.0 })
    }

    fn albedo(&self) -> DVec3 {
        fresnel::conductor(1.0, self.eta, self.k)
    }

    fn is_delta(&self) -> bool {
        self.ggx.is_smooth
    }
}
