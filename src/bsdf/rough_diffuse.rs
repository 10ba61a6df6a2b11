//! EON, the energy-preserving rough diffuse surface of Portsmouth, Kutz and Hill 2024 (EON: A practical energy-preserving
//! rough diffuse BRDF, arXiv 2410.18026): Fujii's improvement of Oren and Nayar 1994, eqs. 8 to 11, and a lobe that gives back
//! what it loses, eqs. 16 to 20, with the albedo in closed form. White stays white; a colour saturates with roughness.
//! Back-scatters: brighter where light comes from the viewer's side. Sampled by a mixture of the cosine and the uniform
//! hemisphere, which bounds the weight where 1/max(cos, cos) has no bound.

use std::f64::consts::{FRAC_1_PI, PI};

use glam::DVec3;

use super::{Bsdf, BsdfSample, Input, Model};

pub const MODEL: Model = Model {
    keyword: "rough_diffuse",
    glsl_type: "RoughDiffuse",
    inputs: &[
        Input::color("color", [0.5; 3], (0.0, 1.0), "albedo of a single facet, linear RGB"),
        Input::scalar("roughness", 0.5, (0.0, 1.0), "0: Lambert; 1: full back-scattering"),
    ],
    transmits: false,
    transmission_input: None,
    tables: &[],
    macros: &[],
    shared: &[],
    doc: "plaster, clay, the moon: diffuse with back-scattering, energy preserving (EON)",
};

/// 1/2 - 2/(3 pi): what Fujii's coefficient A takes for 1 at grazing incidence (eq. 10).
const GRAZING: f64 = 0.5 - 2.0 / (3.0 * PI);
/// 2/3 - 28/(15 pi): the same of the average (eq. 19).
const AVERAGE: f64 = 2.0 / 3.0 - 28.0 / (15.0 * PI);

#[derive(Clone, Copy, Debug)]
pub struct RoughDiffuse {
    pub color: DVec3,
    pub sigma: f64,
    /// Fujii's A; B = sigma A.
    a: f64,
    average: f64,
}

impl RoughDiffuse {
    pub fn from_inputs(inputs: &[DVec3]) -> Self {
        let (color, sigma) = (inputs[0].clamp(DVec3::ZERO, DVec3::ONE), inputs[1].x.clamp(0.0, 1.0));
        let a = 1.0 / (1.0 + GRAZING * sigma);
        Self { color, sigma, a, average: a * (1.0 + AVERAGE * sigma) }
    }

    /// Directional albedo of the single lobe for white (eqs. 13 and 14).
    fn albedo_at(&self, mu: f64) -> f64 {
        let theta = mu.clamp(0.0, 1.0).acos();
        let (sin, cos) = theta.sin_cos();
        let g = sin * (theta - sin * cos) + 2.0 / 3.0 * (sin / cos * (1.0 - sin.powi(3)) - sin);
        self.a * (1.0 + self.sigma * g * FRAC_1_PI)
    }

    /// Probability of the uniform hemisphere: none where the surface is Lambert's or seen from the pole.
    fn p_uniform(&self, wo: DVec3) -> f64 {
        0.5 * self.sigma * (1.0 - wo.z * wo.z).max(0.0).sqrt()
    }
}

impl Bsdf for RoughDiffuse {
    fn eval(&self, wo: DVec3, wi: DVec3) -> DVec3 {
        if wo.z <= 0.0 || wi.z <= 0.0 {
            return DVec3::ZERO;
        }
        let s = wo.x * wi.x + wo.y * wi.y;
        let t = if s > 0.0 { wo.z.max(wi.z) } else { 1.0 };
        let single = self.color * (FRAC_1_PI * self.a * (1.0 + self.sigma * s / t));
        let lost = |w: DVec3| 1.0 - self.albedo_at(w.z);
        let e = self.average;
        let multiple_color = self.color * self.color * e / (DVec3::ONE - self.color * (1.0 - e));
        let multiple = if e < 1.0 { FRAC_1_PI * lost(wo) * lost(wi) / (1.0 - e) } else { 0.0 };
        (single + multiple_color * multiple) * wi.z
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        if wo.z <= 0.0 || wi.z <= 0.0 {
            return 0.0;
        }
        let p = self.p_uniform(wo);
        (1.0 - p) * FRAC_1_PI * wi.z + p * 0.5 * FRAC_1_PI
    }

    fn sample(&self, wo: DVec3, choice: u32, u: [f64; 2]) -> Option<BsdfSample> {
        let is_uniform = super::is_chosen(choice, self.p_uniform(wo));
        let warp =
            if is_uniform { crate::math::warp::uniform_hemisphere } else { crate::math::warp::cosine_hemisphere };
        let wi = warp(u);
        let pdf = self.pdf(wo, wi);
        (pdf > 0.0).then(|| BsdfSample { wi, weight: self.eval(wo, wi) / pdf, pdf, flags: 0, eta_scale: 1.0 })
    }

    fn albedo(&self) -> DVec3 {
        self.color
    }

    fn is_delta(&self) -> bool {
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The albedo in closed form against the sum of the paper's f over directions.
    #[test]
    fn the_albedo_is_the_integral_of_the_lobe() {
        for sigma in [0.0, 0.3, 1.0] {
            let b = RoughDiffuse::from_inputs(&[DVec3::ONE, DVec3::splat(sigma)]);
            let mut average = 0.0;
            let n = 400;
            for i in 0..40 {
                let mu = (i as f64 + 0.5) / 40.0;
                let wo = DVec3::new((1.0 - mu * mu).sqrt(), 0.0, mu);
                let mut sum = 0.0;
                for j in 0..n * n {
                    let (z, phi) = ((j / n) as f64 + 0.5, (j % n) as f64 + 0.5);
                    let (z, phi) = (z / n as f64, phi / n as f64 * std::f64::consts::TAU);
                    let r = (1.0 - z * z).sqrt();
                    let s = wo.x * r * phi.cos();
                    let t = if s > 0.0 { mu.max(z) } else { 1.0 };
                    sum += FRAC_1_PI * b.a * (1.0 + sigma * s / t) * z * std::f64::consts::TAU / (n * n) as f64;
                }
                assert!((sum - b.albedo_at(mu)).abs() < 1e-4, "sigma {sigma} mu {mu}: {sum} {}", b.albedo_at(mu));
                average += 2.0 * mu * b.albedo_at(mu) / 40.0;
            }
            assert!((average - b.average).abs() < 1e-3, "{average} {}", b.average);
        }
    }
}
