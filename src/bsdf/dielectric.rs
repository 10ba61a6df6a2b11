//! Dielectric boundary, smooth or rough: reflection and refraction by GGX facets (Walter et al. 2007, eqs. 20 and 21).
//! Local z points to the outside: `wo.z < 0` is inside. Radiance mode: refraction scales by 1/eta^2 (Veach 1997, 5.2),
//! said in `eta_scale`; importance mode would leave that factor out. Absorption inside is the medium's, not here.
//! Without multiple scattering between facets: rough glass loses energy, never gains it (gate 4, src/conform/bsdf.rs).

use glam::DVec3;

use super::fresnel;
use super::ggx::{Ggx, half_cosine, half_vector, reflect};
use super::{Bsdf, BsdfSample, Input, InputKind, Model, SAMPLE_DELTA, SAMPLE_TRANSMISSION, is_chosen, shared};

pub const MODEL: Model = Model {
    keyword: "dielectric",
    glsl_type: "Dielectric",
    inputs: &[
        Input {
            name: "eta",
            kind: InputKind::Scalar,
            default: [1.5; 3],
            range: (0.1, 10.0),
            doc: "index of refraction, interior over exterior; within 1e-4 of 1 the surface is not there",
        },
        Input {
            name: "roughness",
            kind: InputKind::Scalar,
            default: [0.0; 3],
            range: (0.0, 1.0),
            doc: "0 smooth, 1 rough; GGX alpha = roughness^2",
        },
        Input {
            name: "roughness_y",
            kind: InputKind::Scalar,
            default: [-1.0; 3],
            range: (-1.0, 1.0),
            doc: "roughness along the bitangent; -1: the same as roughness",
        },
    ],
    transmits: true,
    transmission_input: None,
    tables: &[],
    macros: &[],
    shared: &[shared("bsdf/fresnel.glsl"), shared("bsdf/ggx.glsl")],
    doc: "glass, water: a boundary that reflects and refracts",
};

/// |eta - 1| below this is no boundary: the refracted half vector is 0/0.
pub const INDEX_MATCHED: f64 = 1e-4;

#[derive(Clone, Copy, Debug)]
pub struct Dielectric {
    pub eta: f64,
    pub ggx: Ggx,
    /// eta = 1: light passes straight on.
    pub is_absent: bool,
}

impl Dielectric {
    pub fn from_inputs(inputs: &[DVec3]) -> Self {
        let eta = inputs[0].x;
        Self {
            eta,
            ggx: Ggx::from_roughness(inputs[1].x, inputs[2].x),
            is_absent: (eta - 1.0).abs() < INDEX_MATCHED,
        }
    }

    /// Both directions with wo above, and the relative index eta_t/eta_o as seen from wo's side.
    fn seen_from_above(&self, wo: DVec3, wi: DVec3) -> (DVec3, DVec3, f64) {
        let side = wo.z.signum();
        let flip = DVec3::new(1.0, 1.0, side);
        (wo * flip, wi * flip, if side > 0.0 { self.eta } else { 1.0 / self.eta })
    }

    /// (eval, pdf), both without delta lobes.
    fn eval_pdf(&self, wo: DVec3, wi: DVec3) -> (f64, f64) {
        if self.is_delta() || wo.z == 0.0 || wi.z == 0.0 {
            return (0.0, 0.0);
        }
        let (o, i, eta) = self.seen_from_above(wo, wi);
        if i.z > 0.0 {
            let Some(h) = half_vector(o, i) else { return (0.0, 0.0) };
            let (f, _) = fresnel::dielectric(half_cosine(o, i), eta);
            let value = f * self.ggx.d(h) * self.ggx.g2(o, i) / (4.0 * o.z);
            (value, f * self.ggx.reflection_pdf(o, h))
        } else {
            refraction(&self.ggx, o, i, eta)
        }
    }
}

/// (f |cos wi|, pdf) of refraction through a rough boundary, `o.z > 0 > i.z`, radiance mode. The pdf holds the factor 1-F.
pub fn refraction(ggx: &Ggx, o: DVec3, i: DVec3, eta: f64) -> (f64, f64) {
    let Some(h) = half_vector(o, i * eta) else { return (0.0, 0.0) };
    let (oh, ih) = (o.dot(h), i.dot(h));
    // Facets seen from behind do not refract.
    if oh <= 0.0 || ih >= 0.0 {
        return (0.0, 0.0);
    }
    let t = fresnel::dielectric_transmittance(oh, eta);
    let jacobian = -ih / (ih + oh / eta).powi(2);
    let value = t * ggx.d(h) * ggx.g2(o, i) * oh * jacobian / (o.z * eta * eta);
    (value, t * ggx.visible_pdf(o, h) * jacobian)
}

impl Bsdf for Dielectric {
    fn eval(&self, wo: DVec3, wi: DVec3) -> DVec3 {
        DVec3::splat(self.eval_pdf(wo, wi).0)
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        self.eval_pdf(wo, wi).1
    }

    fn sample(&self, wo: DVec3, choice: u32, u: [f64; 2]) -> Option<BsdfSample> {
        if wo.z == 0.0 {
            return None;
        }
        if self.is_absent {
            let flags = SAMPLE_DELTA | SAMPLE_TRANSMISSION;
            return Some(BsdfSample { wi: -wo, weight: DVec3::ONE, pdf: 1.0, flags, eta_scale: 1.0 });
        }
        let (o, _, eta) = self.seen_from_above(wo, wo);
        let flip = DVec3::new(1.0, 1.0, wo.z.signum());
        let h = if self.ggx.is_smooth { DVec3::Z } else { self.ggx.sample_visible(o, u) };
        let cos = o.dot(h);
        let (f, cos_t) = fresnel::dielectric(cos, eta);
        let share = |is_reflected: bool| if is_reflected { f } else { fresnel::dielectric_transmittance(cos, eta) };
        let is_reflected = is_chosen(choice, f);
        let i = if is_reflected { reflect(o, h) } else { -o / eta + h * (cos / eta - cos_t) };
        if (i.z > 0.0) != is_reflected || i.z == 0.0 || (!is_reflected && f >= 1.0) {
            return None;
        }
        let (flags, eta_scale) = if is_reflected { (0, 1.0) } else { (SAMPLE_TRANSMISSION, 1.0 / (eta * eta)) };
        if self.ggx.is_smooth {
            let pdf = share(is_reflected);
            let weight = DVec3::splat(eta_scale);
            return Some(BsdfSample { wi: i * flip, weight, pdf, flags: flags | SAMPLE_DELTA, eta_scale });
        }
        let jacobian = if is_reflected { 1.0 / (4.0 * cos) } else { cos_t / (cos / eta - cos_t).powi(2) };
        let pdf = share(is_reflected) * self.ggx.visible_pdf(o, h) * jacobian;
        let weight = DVec3::splat(eta_scale * self.ggx.g2(o, i) / self.ggx.g1(o));
        (pdf > 0.0).then_some(BsdfSample { wi: i * flip, weight, pdf, flags, eta_scale })
    }

    fn albedo(&self) -> DVec3 {
        DVec3::ONE
    }

    fn is_delta(&self) -> bool {
        self.is_absent || self.ggx.is_smooth
    }
}
