//! Dielectric boundary, smooth or rough: reflection and refraction by GGX facets (Walter et al. 2007, eqs. 20 and 21).
//! Local z points to the outside: `wo.z < 0` is inside. Radiance mode: refraction scales by 1/eta^2 (Veach 1997, 5.2),
//! said in `eta_scale`; importance mode would leave that factor out. Absorption inside is the medium's, not here.
//! What single scattering loses comes back, if `compensation`, in a lobe after Kulla and Conty 2017 (Revisiting physically based
//! shading): from side a, d_a(o) d_b(i) cos / (pi D_b) into side b, d the deficit and D its average (src/bsdf/dielectric_albedo.rs).
//! Its share t_a = T_a min(1, D_b/D_a) is transmitted, T_a the average transmittance, for which n_a^2 T_a = n_b^2 T_b: so light may
//! travel either way, whatever the two averages are. Isotropic surfaces only: with the deficit of the isotropic surface as
//! wide along each direction, two widths made up to 7 % of light at grazing incidence from inside.

use std::f64::consts::FRAC_1_PI;

use glam::DVec3;

use super::dielectric_albedo::{self, Deficits};
use super::fresnel;
use super::ggx::{Ggx, half_cosine, half_vector, reflect};
use super::{Bsdf, BsdfSample, Input, Model, SAMPLE_DELTA, SAMPLE_TRANSMISSION, When, is_chosen, shared};

pub const MODEL: Model = Model {
    keyword: "dielectric",
    glsl_type: "Dielectric",
    inputs: &[
        Input::scalar(
            "eta",
            1.5,
            (0.1, 10.0),
            "index of refraction of the interior, air being 1; within 1e-4 of that in front the surface is not there",
        )
        .index(),
        Input::scalar("roughness", 0.0, (0.0, 1.0), "0 smooth, 1 rough; GGX alpha = roughness^2"),
        Input::scalar("roughness_y", -1.0, (-1.0, 1.0), "roughness along the bitangent; -1: the same as roughness"),
        Input::scalar(
            "compensation",
            1.0,
            (0.0, 1.0),
            "1: give back what facets of one roughness scatter more than once; 0: single scattering only",
        ),
    ],
    transmits: true,
    transmission_input: None,
    tables: &["dielectric_deficit"],
    macros: &[("DIELECTRIC_COMPENSATION", When::NotZero(&["roughness", "compensation"]))],
    shared: &[shared("bsdf/fresnel.glsl"), shared("bsdf/ggx.glsl"), dielectric_albedo::SHARED],
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
    multiple: Option<Multiple>,
}

/// What the lobe of multiple scattering needs; pairs are of the side of the lower index, and of the higher.
#[derive(Clone, Copy, Debug)]
struct Multiple {
    /// Place in the table.
    index: f64,
    average: Deficits,
    /// Share that is transmitted.
    transmitted: [f64; 2],
}

impl Dielectric {
    pub fn from_inputs(inputs: &[DVec3]) -> Self {
        let eta = inputs[0].x;
        let ggx = Ggx::from_roughness(inputs[1].x, inputs[2].x);
        let is_absent = (eta - 1.0).abs() < INDEX_MATCHED;
        let is_compensated = inputs[3].x >= 0.5 && ggx.alpha_x == ggx.alpha_y && !ggx.is_smooth && !is_absent;
        let multiple = is_compensated.then(|| {
            let index = dielectric_albedo::index_place(eta);
            let average = dielectric_albedo::table().average(ggx.alpha_x, index);
            let n = eta.max(1.0 / eta);
            let t = 1.0 - fresnel::dielectric_average(n);
            let ratio = average[1] / average[0];
            Multiple { index, average, transmitted: [t * ratio.min(1.0), t / (n * n) * (1.0 / ratio).min(1.0)] }
        });
        Self { eta, ggx, is_absent, multiple }
    }

    /// Deficits at a direction, here and on the other side, as seen from where the index beyond over that here is `eta`.
    fn deficits(&self, m: &Multiple, w: DVec3, eta: f64) -> [f64; 2] {
        let d = dielectric_albedo::table().at(w.z.abs(), self.ggx.alpha_x, m.index);
        if eta > 1.0 { d } else { [d[1], d[0]] }
    }

    /// Probability of multiple scattering, o above: what is lost towards o.
    fn lost(&self, o: DVec3, eta: f64) -> f64 {
        self.multiple.as_ref().map_or(0.0, |m| self.deficits(m, o, eta)[0])
    }

    /// (f |cos wi|, pdf given that the lobe is chosen) of multiple scattering, o above.
    fn multiple_lobe(&self, m: &Multiple, o: DVec3, i: DVec3, eta: f64) -> (f64, f64) {
        let (here, there) = if eta > 1.0 { (0, 1) } else { (1, 0) };
        let (lost_o, lost_i) = (self.deficits(m, o, eta)[0], self.deficits(m, i, eta));
        let t = m.transmitted[here];
        if i.z > 0.0 {
            let value = (1.0 - t) * lost_o * lost_i[0] * i.z * FRAC_1_PI / m.average[here];
            (value, (1.0 - t) * i.z * FRAC_1_PI)
        } else {
            let value = t * lost_o * lost_i[1] * -i.z * FRAC_1_PI / (m.average[there] * eta * eta);
            (value, t * -i.z * FRAC_1_PI)
        }
    }

    /// (eval, pdf) with `o` above.
    fn value(&self, o: DVec3, i: DVec3, eta: f64) -> (f64, f64) {
        let (mut value, mut pdf) = self.single(o, i, eta);
        if let Some(m) = &self.multiple {
            let (more, density) = self.multiple_lobe(m, o, i, eta);
            let p = self.lost(o, eta);
            value += more;
            pdf = (1.0 - p) * pdf + p * density;
        }
        (value, pdf)
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
        self.value(o, i, eta)
    }

    fn single(&self, o: DVec3, i: DVec3, eta: f64) -> (f64, f64) {
        if i.z > 0.0 {
            let Some(h) = half_vector(o, i) else { return (0.0, 0.0) };
            let (f, _) = fresnel::dielectric(half_cosine(o, i), eta);
            let value = f * self.ggx.d(h) * self.ggx.g2(o, i) / (4.0 * o.z);
            (value, f * self.ggx.reflection_pdf(o, h))
        } else {
            refraction(&self.ggx, o, i, eta)
        }
    }

    /// A direction that leaves after more than one facet; the choice is below `lost`.
    fn sample_multiple(&self, m: &Multiple, o: DVec3, eta: f64, choice: u32, u: [f64; 2]) -> (DVec3, bool) {
        let t = m.transmitted[if eta > 1.0 { 0 } else { 1 }];
        let is_reflected = is_chosen(choice, self.lost(o, eta) * (1.0 - t));
        let i = crate::math::warp::cosine_hemisphere(u);
        (if is_reflected { i } else { -i }, is_reflected)
    }
}

/// Flags and scale of radiance of a direction that stays on wo's side, or does not.
fn side_of(is_reflected: bool, eta: f64) -> (u32, f64) {
    if is_reflected { (0, 1.0) } else { (SAMPLE_TRANSMISSION, 1.0 / (eta * eta)) }
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
        let lost = self.lost(o, eta);
        if let Some(m) = self.multiple.as_ref().filter(|_| is_chosen(choice, lost)) {
            let (i, is_reflected) = self.sample_multiple(m, o, eta, choice, u);
            let (value, pdf) = self.value(o, i, eta);
            let (flags, eta_scale) = side_of(is_reflected, eta);
            let weight = DVec3::splat(value / pdf);
            return (pdf > 0.0 && i.z != 0.0).then_some(BsdfSample { wi: i * flip, weight, pdf, flags, eta_scale });
        }
        let is_reflected = is_chosen(choice, lost + (1.0 - lost) * f);
        let i = if is_reflected { reflect(o, h) } else { -o / eta + h * (cos / eta - cos_t) };
        if (i.z > 0.0) != is_reflected || i.z == 0.0 || (!is_reflected && f >= 1.0) {
            return None;
        }
        let (flags, eta_scale) = side_of(is_reflected, eta);
        if self.ggx.is_smooth {
            let pdf = share(is_reflected);
            let weight = DVec3::splat(eta_scale);
            return Some(BsdfSample { wi: i * flip, weight, pdf, flags: flags | SAMPLE_DELTA, eta_scale });
        }
        if self.multiple.is_some() {
            let (value, pdf) = self.value(o, i, eta);
            let weight = DVec3::splat(value / pdf);
            return (pdf > 0.0).then_some(BsdfSample { wi: i * flip, weight, pdf, flags, eta_scale });
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
