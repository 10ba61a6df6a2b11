//! The surfaces that share a point: one, or several with shares that add to 1. A mixture's f and density are the weighted sums;
//! it is sampled by choosing one of them by its share. Energy, reciprocity and mass then follow from those of its parts.
//! A part that does not transmit is seen from both sides, as it would be alone.

use glam::DVec3;

use super::{Bsdf, BsdfSample, Params, SAMPLE_DELTA, is_chosen};

// One is what nearly every hit has: a box would cost an allocation a vertex.
#[allow(clippy::large_enum_variant)]
#[derive(Clone, Debug)]
pub enum Mixture {
    One(Params),
    Many(Vec<Part>),
}

#[derive(Clone, Copy, Debug)]
pub struct Part {
    pub share: f64,
    pub params: Params,
    /// The model knows no inside: directions below are mirrored.
    pub is_one_sided: bool,
}

impl Part {
    fn mirror(&self, wo: DVec3) -> DVec3 {
        DVec3::new(1.0, 1.0, if self.is_one_sided && wo.z < 0.0 { -1.0 } else { 1.0 })
    }

    fn bsdf(&self) -> &dyn Bsdf {
        self.params.bsdf()
    }
}

impl Mixture {
    pub fn eval(&self, wo: DVec3, wi: DVec3) -> DVec3 {
        match self {
            Self::One(params) => params.bsdf().eval(wo, wi),
            Self::Many(parts) => {
                parts.iter().map(|p| p.share * p.bsdf().eval(wo * p.mirror(wo), wi * p.mirror(wo))).sum()
            }
        }
    }

    pub fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        match self {
            Self::One(params) => params.bsdf().pdf(wo, wi),
            Self::Many(parts) => {
                parts.iter().map(|p| p.share * p.bsdf().pdf(wo * p.mirror(wo), wi * p.mirror(wo))).sum()
            }
        }
    }

    /// `pick` chooses the part, the others are for it.
    pub fn sample(&self, wo: DVec3, pick: u32, choice: u32, u: [f64; 2]) -> Option<BsdfSample> {
        let parts = match self {
            Self::One(params) => return params.bsdf().sample(wo, choice, u),
            Self::Many(parts) => parts,
        };
        let mut chosen = None;
        let mut up_to = 0.0;
        for part in parts.iter().filter(|p| p.share > 0.0) {
            up_to += part.share;
            chosen = Some(part);
            if is_chosen(pick, up_to) {
                break;
            }
        }
        let part = chosen?;
        let mut s = part.bsdf().sample(wo * part.mirror(wo), choice, u)?;
        s.wi *= part.mirror(wo);
        if s.flags & SAMPLE_DELTA != 0 {
            s.pdf *= part.share;
            return Some(s);
        }
        s.pdf = self.pdf(wo, s.wi);
        s.weight = self.eval(wo, s.wi) / s.pdf;
        (s.pdf > 0.0).then_some(s)
    }

    pub fn albedo(&self) -> DVec3 {
        match self {
            Self::One(params) => params.bsdf().albedo(),
            Self::Many(parts) => parts.iter().map(|p| p.share * p.bsdf().albedo()).sum(),
        }
    }

    /// Light sampling cannot contribute.
    pub fn is_delta(&self) -> bool {
        match self {
            Self::One(params) => params.bsdf().is_delta(),
            Self::Many(parts) => parts.iter().all(|p| p.share == 0.0 || p.bsdf().is_delta()),
        }
    }

    /// For a frame whose y points against the bitangent.
    pub fn mirror(&mut self) {
        match self {
            Self::One(params) => params.mirror(),
            Self::Many(parts) => parts.iter_mut().for_each(|p| p.params.mirror()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::MODELS;
    use super::*;

    fn part(share: f64, keyword: &str, inputs: &[f64]) -> Part {
        let model = MODELS.iter().position(|m| m.keyword == keyword).unwrap();
        let inputs: Vec<DVec3> = inputs.iter().map(|x| DVec3::splat(*x)).collect();
        Part { share, params: Params::from_inputs(model, &inputs), is_one_sided: !MODELS[model].transmits }
    }

    /// White lambert, plastic and rough glass in any shares: what leaves is what arrives, and the choice follows the shares.
    #[test]
    fn a_mixture_of_white_surfaces_is_white() {
        let mixture = Mixture::Many(vec![
            part(0.3, "lambert", &[1.0]),
            part(0.5, "plastic", &[1.0, 0.4, 1.5]),
            part(0.2, "conductor", &[0.0, 1.0, 0.0, -1.0, 1.0]),
        ]);
        for wo in [DVec3::new(0.6, 0.0, 0.8), DVec3::new(0.6, 0.0, -0.8)] {
            let (mut energy, mut deltas) = (0.0, 0);
            let n = 1u32 << 16;
            for k in 0..n {
                let pick = k.reverse_bits();
                let u = [f64::from(k) / f64::from(n), (f64::from(k) * 0.618_033_988_749_895).fract()];
                let choice = k.wrapping_mul(2_654_435_769).rotate_left(7);
                let Some(s) = mixture.sample(wo, pick, choice, u) else { continue };
                assert!(s.wi.z * wo.z > 0.0);
                energy += s.weight.x / f64::from(n);
                deltas += u32::from(s.flags & SAMPLE_DELTA != 0);
            }
            assert!((energy - 1.0).abs() < 0.01, "{energy}");
            assert!((f64::from(deltas) / f64::from(n) - 0.2).abs() < 0.01, "{deltas}");
        }
    }
}
