//! Lambertian reflection: f = rho/pi, the same in every direction (Lambert 1760). Two-sided.
//! Sampled by the cosine-weighted hemisphere (Malley's method over the concentric disk of Shirley and Chiu 1997).

use std::f64::consts::FRAC_1_PI;

use glam::DVec3;

use super::{Bsdf, BsdfSample, Input, Model};

pub const MODEL: Model = Model {
    keyword: "lambert",
    glsl_type: "Lambert",
    inputs: &[Input::color("albedo", [0.5; 3], (0.0, 1.0), "fraction of light reflected, linear RGB")],
    transmits: false,
    transmission_input: None,
    tables: &[],
    macros: &[],
    shared: &[],
    doc: "light scattered equally in all directions",
};

#[derive(Clone, Copy, Debug)]
pub struct Lambert {
    pub albedo: DVec3,
}

impl Lambert {
    pub fn from_inputs(inputs: &[DVec3]) -> Self {
        Self { albedo: inputs[0] }
    }
}

impl Bsdf for Lambert {
    fn eval(&self, wo: DVec3, wi: DVec3) -> DVec3 {
        if wo.z > 0.0 && wi.z > 0.0 { self.albedo * (FRAC_1_PI * wi.z) } else { DVec3::ZERO }
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        if wo.z > 0.0 && wi.z > 0.0 { FRAC_1_PI * wi.z } else { 0.0 }
    }

    fn sample(&self, wo: DVec3, _choice: u32, u: [f64; 2]) -> Option<BsdfSample> {
        let wi = crate::math::warp::cosine_hemisphere(u);
        let pdf = self.pdf(wo, wi);
        (pdf > 0.0).then_some(BsdfSample { wi, weight: self.albedo, pdf, flags: 0, eta_scale: 1.0 })
    }

    fn albedo(&self) -> DVec3 {
        self.albedo
    }

    fn is_delta(&self) -> bool {
        false
    }
}
