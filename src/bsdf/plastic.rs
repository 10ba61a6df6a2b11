//! Plastic and paint: a clear dielectric coat, smooth or rough, over a Lambertian base of albedo rho.
//!
//! The coat reflects E(o) of what arrives (src/bsdf/coat.rs); the base gets the rest, and what it sends back meets the coat
//! from below, where 1 - (1-E_avg)/eta^2 is reflected again (the inner and outer averages are bound by reciprocity):
//! f = rho (1-E(o)) (1-E(i)) / (pi (eta^2 - rho (eta^2 - 1 + E_avg))), summed over all orders as Orchard 1969 and Saunderson
//! 1942 did for smooth coats. Reciprocal; white conserves all light for every roughness; colours saturate as paint does.
//! Fresnel is Schlick's (off by 0.036 at most at eta = 1.5), so that coat and base share one table of albedo.

use std::f64::consts::FRAC_1_PI;

use glam::DVec3;

use super::coat::{self, Coat};
use super::ggx::{half_cosine, half_vector, reflect};
use super::{Bsdf, BsdfSample, Input, Model, SAMPLE_DELTA, ggx_albedo, is_chosen, shared};

pub const MODEL: Model = Model {
    keyword: "plastic",
    glsl_type: "Plastic",
    inputs: &[
        Input::color("color", [0.5; 3], (0.0, 1.0), "albedo of the base under the coat, linear RGB"),
        Input::scalar(
            "roughness",
            0.0,
            (0.0, 1.0),
            "of the coat: 0 smooth (varnish), 0.2 to 0.4 semi-gloss paint, 1 rough; GGX alpha = roughness^2",
        ),
        Input::scalar("eta", 1.5, (1.0, 3.0), "index of refraction of the coat, air being 1").index(),
    ],
    transmits: false,
    transmission_input: None,
    tables: &["ggx_albedo"],
    macros: &[],
    shared: &[shared("bsdf/fresnel.glsl"), shared("bsdf/ggx.glsl"), ggx_albedo::SHARED, coat::SHARED],
    doc: "plastic, varnish, paint: a clear coat over a diffuse base",
};

#[derive(Clone, Copy, Debug)]
pub struct Plastic {
    pub color: DVec3,
    pub coat: Coat,
    pub eta: f64,
}

impl Plastic {
    pub fn from_inputs(inputs: &[DVec3]) -> Self {
        let eta = inputs[2].x.max(1.0);
        let f0 = ((eta - 1.0) / (eta + 1.0)).powi(2);
        Self { color: inputs[0].clamp(DVec3::ZERO, DVec3::ONE), coat: Coat::new(inputs[1].x, f0, 1.0), eta }
    }

    /// pi f of the base without the two passages of the coat.
    fn base(&self) -> DVec3 {
        let eta2 = self.eta * self.eta;
        let inner = 1.0 - self.coat.through_average() / eta2;
        self.color / (eta2 * (DVec3::ONE - self.color * inner))
    }

    /// Probability of the cosine lobe: its share of the light that leaves towards wo.
    fn p_cosine(&self, wo: DVec3) -> f64 {
        let through = self.coat.through(wo.z);
        let base = self.base();
        let cosine = through * self.coat.through_average() * (base.x + base.y + base.z) / 3.0;
        if cosine > 0.0 { cosine / (cosine + self.coat.reflected(wo.z)) } else { 0.0 }
    }
}

impl Bsdf for Plastic {
    fn eval(&self, wo: DVec3, wi: DVec3) -> DVec3 {
        if wo.z <= 0.0 || wi.z <= 0.0 {
            return DVec3::ZERO;
        }
        let base = self.base() * (self.coat.through(wo.z) * self.coat.through(wi.z) * FRAC_1_PI * wi.z);
        let ggx = self.coat.ggx;
        match half_vector(wo, wi) {
            Some(h) if !ggx.is_smooth => {
                base + self.coat.fresnel(half_cosine(wo, wi)) * ggx.d(h) * ggx.g2(wo, wi) / (4.0 * wo.z)
            }
            _ => base,
        }
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        if wo.z <= 0.0 || wi.z <= 0.0 {
            return 0.0;
        }
        let p = self.p_cosine(wo);
        let coat = match half_vector(wo, wi) {
            Some(h) if !self.coat.ggx.is_smooth => self.coat.ggx.reflection_pdf(wo, h),
            _ => 0.0,
        };
        p * FRAC_1_PI * wi.z + (1.0 - p) * coat
    }

    fn sample(&self, wo: DVec3, choice: u32, u: [f64; 2]) -> Option<BsdfSample> {
        if wo.z <= 0.0 {
            return None;
        }
        let p = self.p_cosine(wo);
        let wi = if is_chosen(choice, p) {
            crate::math::warp::cosine_hemisphere(u)
        } else if self.coat.ggx.is_smooth {
            let weight = DVec3::splat(self.coat.fresnel(wo.z) / (1.0 - p));
            let wi = DVec3::new(-wo.x, -wo.y, wo.z);
            return Some(BsdfSample { wi, weight, pdf: 1.0 - p, flags: SAMPLE_DELTA, eta_scale: 1.0 });
        } else {
            reflect(wo, self.coat.ggx.sample_visible(wo, u))
        };
        let pdf = self.pdf(wo, wi);
        (pdf > 0.0).then(|| BsdfSample { wi, weight: self.eval(wo, wi) / pdf, pdf, flags: 0, eta_scale: 1.0 })
    }

    fn albedo(&self) -> DVec3 {
        self.color
    }

    fn is_delta(&self) -> bool {
        self.coat.ggx.is_smooth && self.color == DVec3::ZERO
    }
}
