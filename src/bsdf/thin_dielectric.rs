//! Thin-walled dielectric: a pane without thickness. All orders of reflection between its two faces are summed,
//! R = F + (1-F)^2 F / (1 - F^2) = 2F/(1+F), and what passes goes straight on (Stokes 1862; without absorption between faces).
//! Smooth only; the two sides are alike.

use glam::DVec3;

use super::{Bsdf, BsdfSample, Input, Model, SAMPLE_DELTA, SAMPLE_TRANSMISSION, fresnel, is_chosen, shared};

pub const MODEL: Model = Model {
    keyword: "thin_dielectric",
    glsl_type: "ThinDielectric",
    inputs: &[
        Input::scalar("eta", 1.5, (0.1, 10.0), "index of refraction of the pane, air being 1").index(),
        Input::color("tint", [1.0; 3], (0.0, 1.0), "factor on the transmitted light, linear RGB"),
    ],
    transmits: true,
    transmission_input: None,
    tables: &[],
    macros: &[],
    shared: &[shared("bsdf/fresnel.glsl")],
    doc: "window pane, soap film without interference",
};

#[derive(Clone, Copy, Debug)]
pub struct ThinDielectric {
    pub eta: f64,
    pub tint: DVec3,
}

impl ThinDielectric {
    pub fn from_inputs(inputs: &[DVec3]) -> Self {
        Self { eta: inputs[0].x, tint: inputs[1] }
    }
}

impl Bsdf for ThinDielectric {
    fn eval(&self, _wo: DVec3, _wi: DVec3) -> DVec3 {
        DVec3::ZERO
    }

    fn pdf(&self, _wo: DVec3, _wi: DVec3) -> f64 {
        0.0
    }

    fn sample(&self, wo: DVec3, choice: u32, _u: [f64; 2]) -> Option<BsdfSample> {
        if wo.z == 0.0 {
            return None;
        }
        let (f, _) = fresnel::dielectric(wo.z.abs(), self.eta);
        let r = 2.0 * f / (1.0 + f);
        if is_chosen(choice, r) {
            let wi = DVec3::new(-wo.x, -wo.y, wo.z);
            return Some(BsdfSample { wi, weight: DVec3::ONE, pdf: r, flags: SAMPLE_DELTA, eta_scale: 1.0 });
        }
        let flags = SAMPLE_DELTA | SAMPLE_TRANSMISSION;
        let pdf = fresnel::dielectric_transmittance(wo.z.abs(), self.eta) / (1.0 + f);
        (pdf > 0.0).then_some(BsdfSample { wi: -wo, weight: self.tint, pdf, flags, eta_scale: 1.0 })
    }

    fn albedo(&self) -> DVec3 {
        self.tint
    }

    fn is_delta(&self) -> bool {
        true
    }
}
