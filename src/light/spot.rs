//! A spot light: a point light whose intensity falls off from its axis, in one of three ways.
//!
//! - hard: I0 inside the cone, that is where w . d > cos(cone) for w from the light, 0 outside;
//! - cosine: I0 (w . d)^n on the front hemisphere, n = 1 being Lambert's;
//! - smooth: I0 t^2, t = (cos - cos outer)/(cos inner - cos outer) held to [0, 1] (KHR_lights_punctual, inner and outer cone angles).
//!
//! The flux is I0 times 2 pi (1 - cos cone), 2 pi/(n + 1), and 2 pi ((1 - cos inner) + (cos inner - cos outer)/3). Angles are
//! held as h = 1 - cos, which keeps its digits for narrow cones. GLSL (shaders/light/spot.glsl) has the three as one formula.

use std::f64::consts::TAU;

use glam::{DAffine3, DVec3};

use super::lamp::LampModel;
use super::point::connect_point;
use super::{Connection, Reach, vector};
use crate::prepare::records::LightRecord;

pub const REACH: Reach = Reach::Nowhere;
pub const SHARED: &[&str] = &["light/inverse_square"];

/// Share of the intensity on the axis; h = 1 - cos of an angle from it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Falloff {
    Hard { cone_h: f64 },
    Cosine { exponent: f64 },
    Smooth { inner_h: f64, outer_h: f64 },
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spot {
    pub position: DVec3,
    /// Unit, the way the light goes.
    pub axis: DVec3,
    /// On the axis, W/sr.
    pub intensity: DVec3,
    pub falloff: Falloff,
}

/// 1 - cos.
pub fn one_minus_cos(angle_rad: f64) -> f64 {
    2.0 * (0.5 * angle_rad).sin().powi(2)
}

impl Falloff {
    pub fn share(&self, cos: f64) -> f64 {
        match *self {
            Self::Hard { cone_h } => f64::from(u8::from(cos > 1.0 - cone_h)),
            Self::Cosine { .. } if cos <= 0.0 => 0.0,
            Self::Cosine { exponent } => cos.powf(exponent),
            Self::Smooth { inner_h, outer_h } => {
                let (cos_inner, cos_outer) = (1.0 - inner_h, 1.0 - outer_h);
                ((cos - cos_outer) / (cos_inner - cos_outer)).clamp(0.0, 1.0).powi(2)
            }
        }
    }

    /// Integral of the share over all directions: power over the intensity on the axis, sr.
    pub fn solid_angle(&self) -> f64 {
        TAU * match *self {
            Self::Hard { cone_h } => cone_h,
            Self::Cosine { exponent } => 1.0 / (exponent + 1.0),
            Self::Smooth { inner_h, outer_h } => inner_h + (outer_h - inner_h) / 3.0,
        }
    }
}

impl LampModel for Spot {
    fn power(&self, _scene_radius: f64) -> DVec3 {
        self.falloff.solid_angle() * self.intensity
    }

    fn is_distant(&self) -> bool {
        false
    }

    /// x = offset - scale h; dark where x <= 0, else min(x, 1)^exponent.
    fn record(&self, origin: DVec3) -> LightRecord {
        let falloff = match self.falloff {
            Falloff::Hard { cone_h } => [1.0 / cone_h, 1.0, 0.0],
            Falloff::Cosine { exponent } => [1.0, 1.0, exponent],
            Falloff::Smooth { inner_h, outer_h } => [1.0 / (outer_h - inner_h), outer_h / (outer_h - inner_h), 2.0],
        };
        LightRecord {
            a: (self.position - origin).as_vec3().to_array(),
            b: self.axis.as_vec3().to_array(),
            c: self.intensity.as_vec3().to_array(),
            falloff: falloff.map(|x| x as f32),
            ..LightRecord::default()
        }
    }

    fn from_record(light: &LightRecord) -> Self {
        let [scale, offset, exponent] = light.falloff.map(f64::from);
        let falloff = match (scale, offset, exponent) {
            (_, _, 0.0) => Falloff::Hard { cone_h: 1.0 / scale },
            (1.0, 1.0, _) => Falloff::Cosine { exponent },
            _ => Falloff::Smooth { inner_h: (offset - 1.0) / scale, outer_h: offset / scale },
        };
        let axis = vector(light.b).normalize_or(DVec3::Z);
        Self { position: vector(light.a), axis, intensity: vector(light.c), falloff }
    }

    fn place(&mut self, to_world: &DAffine3) {
        self.position = to_world.transform_point3(self.position);
        self.axis = to_world.transform_vector3(self.axis).normalize_or(self.axis);
    }

    fn brighten(&mut self, factor: f64) {
        self.intensity *= factor;
    }

    fn connect(&self, p: DVec3, _u: [f64; 2]) -> Connection {
        connect_point(self.position, p, |w| self.falloff.share(self.axis.dot(w)) * self.intensity)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FALLOFFS: [Falloff; 7] = [
        Falloff::Hard { cone_h: 0.2 },
        Falloff::Hard { cone_h: 1.7 },
        Falloff::Cosine { exponent: 1.0 },
        Falloff::Cosine { exponent: 0.0 },
        Falloff::Cosine { exponent: 17.5 },
        Falloff::Smooth { inner_h: 0.05, outer_h: 0.3 },
        Falloff::Smooth { inner_h: 0.0, outer_h: 1.0 },
    ];

    /// The closed form of the flux by quadrature over cos, midpoints: 2 pi times the mean share over [-1, 1], times 2.
    #[test]
    fn the_flux_is_the_integral_of_the_intensity() {
        for falloff in FALLOFFS {
            let n = 1_000_000;
            let cos = |i: i32| (2.0 * f64::from(i) + 1.0) / f64::from(n) - 1.0;
            let sum: f64 = (0..n).map(|i| falloff.share(cos(i))).sum();
            let integral = TAU * 2.0 * sum / f64::from(n);
            // A step is found to half a cell: 1e-6 of the range in cos.
            assert!((integral / falloff.solid_angle() - 1.0).abs() < 1e-5, "{falloff:?} {integral}");
        }
    }

    /// Inside the cone is w . d > cos(cone): the comparison of a common slide is the other way round.
    #[test]
    fn the_axis_is_lit_and_outside_the_cone_is_dark() {
        for falloff in FALLOFFS {
            let light = Spot { position: DVec3::Y * 2.0, axis: DVec3::NEG_Y, intensity: DVec3::splat(3.0), falloff };
            let on_axis = light.connect(DVec3::ZERO, [0.0; 2]);
            assert!((on_axis.radiance - DVec3::splat(3.0 / 4.0)).length() < 1e-15, "{falloff:?}");
            assert_eq!((on_axis.wi, on_axis.distance), (DVec3::Y, 2.0));
            assert_eq!(light.connect(DVec3::Y * 5.0, [0.0; 2]).radiance, DVec3::ZERO, "{falloff:?} behind");
        }
        let narrow = Falloff::Hard { cone_h: one_minus_cos(10f64.to_radians()) };
        assert_eq!([9.99, 10.01].map(|a: f64| narrow.share(a.to_radians().cos())), [1.0, 0.0]);
    }

    #[test]
    fn records_decode_to_what_they_were_made_from() {
        for falloff in FALLOFFS {
            let light = Spot { position: DVec3::ONE, axis: DVec3::NEG_Z, intensity: DVec3::ONE, falloff };
            let back = Spot::from_record(&light.record(DVec3::ZERO));
            for i in 0..=100 {
                let cos = 0.02 * f64::from(i) - 1.0;
                assert!((back.falloff.share(cos) - falloff.share(cos)).abs() < 1e-5, "{falloff:?} {cos}");
            }
        }
    }
}
