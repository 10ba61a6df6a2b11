//! glTF 2.0 metallic-roughness surface with KHR_materials_ior, _specular, _anisotropy, _clearcoat, _transmission and (as a
//! boundary) _volume.
//!
//! A linear mix, by metallic m and transmission t, of three surfaces that share one GGX distribution, alpha = roughness^2:
//! - metal, m: Schlick facets with f0 = base_color, and their multiple scattering (Kulla and Conty 2017) if `compensation`;
//! - opaque dielectric, (1-m)(1-t): Schlick facets with f0 = ((ior-1)/(ior+1))^2 over a Lambertian base that gets exactly what
//!   the facets leave, reciprocally: base/pi (1-E(o))(1-E(i))/(1-E_avg), E the facets' directional albedo (Kelemen 2001);
//! - transmitting dielectric, (1-m)t: exact Fresnel; what is not reflected passes with the factor base_color, mirrored through
//!   the wall if `thin`, else refracted into the volume (Walter 2007, radiance mode).
//!
//! None creates energy. `khronos_mix` instead takes the formulas of the specification's appendix B: base/pi (1-F(h)) under
//! F(h) and separable Smith masking, no compensation; it can reflect more than arrives, and is exempt from the furnace.
//! Specular scales both ends of the dielectric's Schlick term, and colours the lower. Anisotropy widens alpha along a direction of
//! the tangent frame to mix(alpha, 1, strength^2); the albedo is then that of the isotropic surface as wide along each direction.
//! Clearcoat is src/bsdf/coat.rs (f0 = 0.04) on both sides: what lies below is seen through it twice, (1-E_c(o)) (1-E_c(i)),
//! reciprocally, and what the cosine lobe sends back at it from below comes out again on average. The coat follows the base's normal.
//! Two-sided throughout; only the refracted part knows inside (`wo.z < 0`) from outside.

mod inputs;

use std::f64::consts::FRAC_1_PI;

use glam::{DVec2, DVec3};

use super::coat::Coat;
use super::dielectric::{INDEX_MATCHED, refraction};
use super::ggx::{Ggx, SMOOTH_ALPHA, half_cosine, half_vector, reflect};
use super::ggx_albedo::{self, Albedo, multiple_scattering, multiple_scattering_color};
use super::{Bsdf, BsdfSample, SAMPLE_DELTA, SAMPLE_TRANSMISSION, fresnel, is_chosen};
pub use inputs::MODEL;

/// Indices below are taken as this: finite on both sides, and all but a total mirror.
const MIN_IOR: f64 = 1e-3;
/// Of an index of 1.5, as the extension has it.
const COAT_F0: f64 = 0.04;
/// 2 int B^2 mu dmu - B_avg^2 of a smooth surface: passages through coat and dielectric facets vary together, and their mean is
/// larger than the product of their means by no more than this.
const COVARIANCE: f64 = 1.0 / 66.0 - 1.0 / 441.0;

#[derive(Clone, Copy, Debug)]
pub struct Gltf {
    pub base_color: DVec3,
    pub metallic: f64,
    pub transmission: f64,
    pub ior: f64,
    pub ggx: Ggx,
    pub is_thin: bool,
    pub is_khronos: bool,
    pub is_compensated: bool,
    /// Schlick's two ends of the opaque dielectric: f90 (the same for all channels) and f0 / f90.
    specular: f64,
    f0: DVec3,
    /// Factor on the exact reflectance of the transmitting dielectric.
    tint: DVec3,
    /// Direction of the wider alpha in the local frame.
    along: DVec2,
    coat: Coat,
    average: Albedo,
    multiple_color: DVec3,
}

/// What depends on `wo` alone.
struct Outgoing {
    /// 1 above, -1 below: both directions are mirrored to see the surface from above.
    flip: DVec3,
    o: DVec3,
    /// Index beyond / index here, for the volume boundary.
    eta: f64,
    albedo: Albedo,
    /// Probabilities of the cosine lobe and of the coat; the facets have the rest.
    p_cosine: f64,
    p_coat: f64,
}

/// What depends on the facet: reflectance, transmittance, and the share of its light that is sampled as transmitted.
struct Facet {
    reflected: DVec3,
    transmitted: DVec3,
    cos_t: f64,
    p_transmission: f64,
}

impl Gltf {
    pub fn from_inputs(inputs: &[DVec3]) -> Self {
        let base_color = inputs[0].clamp(DVec3::ZERO, DVec3::ONE);
        let mut ggx = Ggx::from_roughness(inputs[2].x, -1.0);
        let strength = (inputs[10].x * inputs[12].z).clamp(0.0, 1.0).powi(2);
        ggx.alpha_x += (1.0 - ggx.alpha_x) * strength;
        ggx.is_smooth = ggx.alpha_x < SMOOTH_ALPHA;
        let (ior, is_khronos) = (inputs[3].x.max(MIN_IOR), inputs[6].x >= 0.5);
        let average = if ggx.is_smooth {
            Albedo { deficit: 0.0, schlick: 1.0 / 21.0 }
        } else {
            ggx_albedo::table().average(ggx.alpha_average())
        };
        let f0 = ((ior - 1.0) / (ior + 1.0)).powi(2);
        let specular = inputs[8].x.clamp(0.0, 1.0);
        let fresnel_average = base_color + (DVec3::ONE - base_color) / 21.0;
        Self {
            base_color,
            metallic: inputs[1].x.clamp(0.0, 1.0),
            transmission: inputs[4].x.clamp(0.0, 1.0),
            ior,
            ggx,
            is_thin: inputs[5].x >= 0.5,
            is_khronos,
            is_compensated: inputs[7].x >= 0.5 && !is_khronos,
            specular,
            f0: (inputs[9].max(DVec3::ZERO) * f0).min(DVec3::ONE),
            tint: inputs[9].clamp(DVec3::ZERO, DVec3::ONE) * specular,
            along: direction(inputs[12], inputs[11].x),
            coat: Coat::new(inputs[14].x, COAT_F0, inputs[13].x.clamp(0.0, 1.0)),
            average,
            multiple_color: multiple_scattering_color(fresnel_average, average),
        }
    }

    fn weights(&self) -> (f64, f64, f64) {
        let (m, t) = (self.metallic, self.transmission);
        (m, (1.0 - m) * (1.0 - t), (1.0 - m) * t)
    }

    /// `w` in the frame whose x is the wider alpha.
    fn turned(&self, w: DVec3) -> DVec3 {
        let (c, s) = (self.along.x, self.along.y);
        DVec3::new(c * w.x + s * w.y, c * w.y - s * w.x, w.z)
    }

    fn turned_back(&self, w: DVec3) -> DVec3 {
        let (c, s) = (self.along.x, self.along.y);
        DVec3::new(c * w.x - s * w.y, c * w.y + s * w.x, w.z)
    }

    /// For a frame whose y points against the bitangent.
    pub fn mirror(&mut self) {
        self.along.y = -self.along.y;
    }

    fn albedo_at(&self, w: DVec3) -> Albedo {
        if self.ggx.is_smooth {
            Albedo { deficit: 0.0, schlick: (1.0 - w.z.abs()).powi(5) }
        } else {
            ggx_albedo::table().at(w.z.abs(), self.ggx.alpha_towards(w))
        }
    }

    /// What the facets of the opaque dielectric leave to its base: 1 - E, of the channel that reflects most.
    fn left(&self, a: Albedo) -> f64 {
        let f0 = self.f0.max_element();
        1.0 - self.specular + self.specular * ((1.0 - f0) * (1.0 - a.schlick) + f0 * a.deficit)
    }

    fn outgoing(&self, wo: DVec3) -> Outgoing {
        let side = wo.z.signum();
        let flip = DVec3::new(1.0, 1.0, side);
        let o = self.turned(wo * flip);
        let albedo = self.albedo_at(o);
        let eta = if side > 0.0 { self.ior } else { 1.0 / self.ior };
        // Shares of light by lobe, as seen from o: facets of each part, and the cosine lobe.
        let (metal, opaque, transmitting) = self.weights();
        let facets = metal * mean(albedo.with_f0(self.base_color))
            + opaque * self.specular * mean(albedo.with_f0(self.f0))
            + transmitting;
        let multiple = if self.is_compensated { albedo.deficit * mean(self.multiple_color) } else { 0.0 };
        let cosine = metal * multiple + opaque * mean(self.base_color) * self.left(albedo);
        let below = self.coat.through(o.z) * (cosine + facets);
        let p_coat = if below > 0.0 { self.coat.reflected(o.z) / (self.coat.reflected(o.z) + below) } else { 0.0 };
        let p_cosine = if cosine > 0.0 { (1.0 - p_coat) * cosine / (cosine + facets) } else { 0.0 };
        Outgoing { flip, o, eta, albedo, p_cosine, p_coat }
    }

    fn facet(&self, cos: f64, eta: f64) -> Facet {
        let (metal, opaque, transmitting) = self.weights();
        let cos = cos.clamp(0.0, 1.0);
        let eta = if self.is_thin { self.ior } else { eta };
        let (f, cos_t) = fresnel::dielectric(cos, eta);
        let reflected = fresnel::schlick(cos, self.base_color) * metal
            + fresnel::schlick(cos, self.f0) * (self.specular * opaque)
            + self.tint * (f * transmitting);
        let transmitted = self.base_color * (self.passes(cos, eta) * transmitting);
        let p = mean(transmitted) / (mean(transmitted) + mean(reflected)).max(f64::MIN_POSITIVE);
        Facet { reflected, transmitted, cos_t, p_transmission: p }
    }

    /// Transmittance of a facet: what the dimmed reflection of the channel that reflects most leaves, and nothing under total reflection.
    fn passes(&self, cos: f64, eta: f64) -> f64 {
        let t = fresnel::dielectric_transmittance(cos, eta);
        let spared = (1.0 - self.tint.max_element()) * fresnel::dielectric(cos, eta).0;
        if t > 0.0 { t + spared } else { 0.0 }
    }

    /// Passage of light from below through the coat, averaged over how often it tries.
    fn coat_average(&self) -> f64 {
        self.coat.through_average() + self.coat.weight * COVARIANCE * 21.0 / 20.0
    }

    /// The Lambertian base and the metal's multiple scattering; `f_h`: Fresnel term at the half vector, for khronos_mix.
    fn cosine_lobe(&self, out: &Outgoing, i: DVec3, cos_h: f64) -> DVec3 {
        let (metal, opaque, _) = self.weights();
        let a_i = self.albedo_at(i);
        let cos_i = i.z;
        let base = if self.is_khronos {
            1.0 - self.specular * fresnel::schlick(cos_h, self.f0).max_element()
        } else {
            let average = self.left(self.average);
            if average > 0.0 { self.left(out.albedo) * self.left(a_i) / average } else { 0.0 }
        };
        let mut value = self.base_color * (opaque * base * FRAC_1_PI * cos_i);
        if self.is_compensated {
            value += self.multiple_color * (metal * multiple_scattering(out.albedo, a_i, self.average, cos_i));
        }
        value / self.coat_average()
    }

    fn g2(&self, o: DVec3, i: DVec3) -> f64 {
        if self.is_khronos { self.ggx.g1(o) * self.ggx.g1(i) } else { self.ggx.g2(o, i) }
    }

    fn is_index_matched(&self) -> bool {
        !self.is_thin && (self.ior - 1.0).abs() < INDEX_MATCHED
    }

    fn eval_pdf(&self, wo: DVec3, wi: DVec3) -> (DVec3, f64) {
        if wo.z == 0.0 || wi.z == 0.0 {
            return (DVec3::ZERO, 0.0);
        }
        let out = self.outgoing(wo);
        let (o, i) = (out.o, self.turned(wi * out.flip));
        let (mut value, mut pdf) = self.below_coat(&out, o, i);
        value *= self.coat.through(o.z) * self.coat.through(i.z.abs());
        if let Some(h) = half_vector(o, i).filter(|_| i.z > 0.0 && !self.coat.ggx.is_smooth) {
            let coat = self.coat.ggx;
            value += self.coat.fresnel(half_cosine(o, i)) * coat.d(h) * coat.g2(o, i) / (4.0 * o.z);
            pdf += out.p_coat * coat.reflection_pdf(o, h);
        }
        (value, pdf)
    }

    /// Value and density of all but the coat, in the turned frame, o above.
    fn below_coat(&self, out: &Outgoing, o: DVec3, i: DVec3) -> (DVec3, f64) {
        let p_facet = 1.0 - out.p_cosine - out.p_coat;
        if i.z > 0.0 {
            let h = half_vector(o, i).unwrap_or(DVec3::X);
            let cos = half_cosine(o, i);
            let mut value = self.cosine_lobe(out, i, cos);
            let mut pdf = out.p_cosine * FRAC_1_PI * i.z;
            if !self.ggx.is_smooth && cos > 0.0 {
                let facet = self.facet(cos, out.eta);
                value += facet.reflected * (self.ggx.d(h) * self.g2(o, i) / (4.0 * o.z));
                pdf += p_facet * (1.0 - facet.p_transmission) * self.ggx.reflection_pdf(o, h);
            }
            return (value, pdf);
        }
        if self.ggx.is_smooth || self.weights().2 == 0.0 || self.is_index_matched() {
            return (DVec3::ZERO, 0.0);
        }
        if self.is_thin {
            let mirrored = DVec3::new(i.x, i.y, -i.z);
            let Some(h) = half_vector(o, mirrored) else { return (DVec3::ZERO, 0.0) };
            let facet = self.facet(half_cosine(o, mirrored), out.eta);
            let value = facet.transmitted * (self.ggx.d(h) * self.g2(o, mirrored) / (4.0 * o.z));
            return (value, p_facet * facet.p_transmission * self.ggx.reflection_pdf(o, h));
        }
        let (value, pdf) = refraction(&self.ggx, o, i, out.eta);
        if pdf <= 0.0 {
            return (DVec3::ZERO, 0.0);
        }
        // `refraction` holds the transmittance in both; the facet's own probability replaces it in the pdf.
        let cos = half_vector(o, i * out.eta).map_or(0.0, |h| o.dot(h));
        let t = fresnel::dielectric_transmittance(cos, out.eta);
        let p = p_facet * self.facet(cos, out.eta).p_transmission / t;
        let masking = self.g2(o, i) / self.ggx.g2(o, i) * self.passes(cos, out.eta) / t;
        (self.base_color * (self.weights().2 * value * masking), p * pdf)
    }
}

impl Bsdf for Gltf {
    fn eval(&self, wo: DVec3, wi: DVec3) -> DVec3 {
        self.eval_pdf(wo, wi).0
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        self.eval_pdf(wo, wi).1
    }

    fn sample(&self, wo: DVec3, choice: u32, u: [f64; 2]) -> Option<BsdfSample> {
        if wo.z == 0.0 {
            return None;
        }
        let out = self.outgoing(wo);
        let o = out.o;
        let is_cosine = is_chosen(choice, out.p_cosine);
        let is_coat = !is_cosine && !is_chosen(choice, 1.0 - out.p_coat);
        let ggx = if is_coat { self.coat.ggx } else { self.ggx };
        let h = if ggx.is_smooth { DVec3::Z } else { ggx.sample_visible(o, u) };
        let facet = self.facet(o.dot(h), out.eta);
        let p_facet = 1.0 - out.p_cosine - out.p_coat;
        let p_transmission = p_facet * facet.p_transmission;
        let is_all_transmitted = facet.p_transmission >= 1.0;
        let is_transmitted =
            !is_cosine && !is_coat && (is_all_transmitted || is_chosen(choice, out.p_cosine + p_transmission));
        let mut eta_scale = 1.0;
        let i = if is_cosine {
            crate::math::warp::cosine_hemisphere(u)
        } else if !is_transmitted {
            reflect(o, h)
        } else if self.is_thin {
            reflect(o, h) * DVec3::new(1.0, 1.0, -1.0)
        } else if self.is_index_matched() {
            -o
        } else {
            eta_scale = 1.0 / (out.eta * out.eta);
            -o / out.eta + h * (o.dot(h) / out.eta - facet.cos_t)
        };
        if i.z == 0.0 || (i.z < 0.0) != is_transmitted {
            return None;
        }
        let wi = self.turned_back(i) * out.flip;
        let mut flags = if is_transmitted { SAMPLE_TRANSMISSION } else { 0 };
        if !is_cosine && (ggx.is_smooth || (is_transmitted && self.is_index_matched())) {
            flags |= SAMPLE_DELTA;
            let through = self.coat.through(o.z) * self.coat.through(i.z.abs());
            let (value, p) = if is_coat {
                (DVec3::splat(self.coat.fresnel(o.z)), out.p_coat)
            } else if is_transmitted {
                (facet.transmitted * (eta_scale * through), p_transmission)
            } else {
                (facet.reflected * through, p_facet - p_transmission)
            };
            return (p > 0.0).then(|| BsdfSample { wi, weight: value / p, pdf: p, flags, eta_scale });
        }
        let (value, pdf) = self.eval_pdf(wo, wi);
        (pdf > 0.0).then(|| BsdfSample { wi, weight: value / pdf, pdf, flags, eta_scale })
    }

    fn albedo(&self) -> DVec3 {
        self.base_color
    }

    fn is_delta(&self) -> bool {
        let (_, opaque, transmitting) = self.weights();
        let is_delta = (self.ggx.is_smooth && opaque == 0.0) || (self.is_index_matched() && transmitting == 1.0);
        is_delta && (self.coat.weight == 0.0 || self.coat.ggx.is_smooth)
    }
}

/// Unit direction of the wider alpha: of the texture, turned by `angle_rad`; x where the texture has none.
fn direction(texture: DVec3, angle_rad: f64) -> DVec2 {
    let d = DVec2::new(2.0 * texture.x - 1.0, 2.0 * texture.y - 1.0);
    let d = if d.length() > 1e-3 { d.normalize() } else { DVec2::X };
    DVec2::from_angle(angle_rad).rotate(d)
}

fn mean(c: DVec3) -> f64 {
    (c.x + c.y + c.z) / 3.0
}
