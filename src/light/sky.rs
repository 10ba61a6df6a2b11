//! The sky read from its records, in f64: bilinear lat-long lookup and the sampling of its cells.
//!
//! Convention: u = 0.5 + atan2(x, -z)/(2 pi), v = acos(y)/pi, texel centres at (i + 0.5)/W and (j + 0.5)/H, wrapping
//! in u and clamped in v; turned about +y by `SkyRecord::rotation`. A cell is a texel's own area; inside it a direction is
//! uniform in u and in cos(theta), so that the density is the cell's probability over its solid angle, also at the poles.
//! With s = sin^2(theta/2) = (1 - cos(theta))/2 near the upper pole, and the mirror image below, no step cancels.
//! A sky without texels (width 0) is the same everywhere and sampled over the whole sphere. Kernels: shaders/light/sky.glsl.

use std::f64::consts::{FRAC_1_PI, FRAC_PI_2, PI, TAU};

use glam::DVec3;

use super::{Arriving, Connection, Reach, Surroundings, alias};
use crate::prepare::Prepared;
use crate::prepare::records::{AliasRecord, LightRecord, NONE, SkyRecord, SkyTexelRecord};
use crate::sampler::{SKY_FRACTION, SKY_INDEX};

pub const REACH: Reach = Reach::Infinity(arriving);
pub const SHARED: &[&str] = &[];

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SkySample {
    pub wi: DVec3,
    pub radiance: DVec3,
    /// 1/sr; 0 means no sample.
    pub pdf: f64,
}

/// The three tables of the sky, borrowed from `Prepared`.
#[derive(Clone, Copy, Debug)]
pub struct SkyView<'a> {
    pub sky: &'a SkyRecord,
    pub texels: &'a [SkyTexelRecord],
    pub alias: &'a [AliasRecord],
}

pub fn connect(world: &dyn Surroundings, _light: &LightRecord, _p: DVec3, u: [f64; 2]) -> Connection {
    let s = SkyView::of(world.prepared()).sample(world.word(SKY_INDEX), world.word(SKY_FRACTION), u);
    Connection { wi: s.wi, distance: f64::INFINITY, radiance: s.radiance, pdf: s.pdf, primitive: NONE }
}

fn arriving(p: &Prepared, direction: DVec3, visit: &mut Arriving) {
    if p.has_sky {
        let view = SkyView::of(p);
        visit(view.radiance(direction), p.sky.light, view.pdf(direction));
    }
}

impl<'a> SkyView<'a> {
    pub fn of(p: &'a Prepared) -> Self {
        Self { sky: &p.sky, texels: &p.sky_texels, alias: &p.sky_alias }
    }

    /// Radiance from direction `d` (unit), W/(m2 sr).
    pub fn radiance(&self, d: DVec3) -> DVec3 {
        let scale = DVec3::from(self.sky.scale.map(f64::from));
        if self.sky.width == 0 {
            return scale;
        }
        let (width, height) = (i64::from(self.sky.width), i64::from(self.sky.height));
        let (x, y) = self.position(d);
        let (x, y) = (x - 0.5, y - 0.5);
        let (i, j) = (x.floor(), y.floor());
        let (s, t) = (x - i, y - j);
        let texel = |di: i64, dj: i64| {
            let column = (i as i64 + di).rem_euclid(width);
            let row = (j as i64 + dj).clamp(0, height - 1);
            DVec3::from(self.texels[(row * width + column) as usize].radiance.map(f64::from))
        };
        scale * texel(0, 0).lerp(texel(1, 0), s).lerp(texel(0, 1).lerp(texel(1, 1), s), t)
    }

    /// Density of `sample` in direction `d`, 1/sr.
    pub fn pdf(&self, d: DVec3) -> f64 {
        if self.sky.width == 0 {
            return 0.25 * FRAC_1_PI;
        }
        let (x, y) = self.position(d);
        let column = (x as u32).min(self.sky.width - 1);
        let row = (y as u32).min(self.sky.height - 1);
        f64::from(self.texels[(row * self.sky.width + column) as usize].cell_pdf)
    }

    pub fn sample(&self, index_word: u32, fraction_word: u32, u: [f64; 2]) -> SkySample {
        if self.sky.width == 0 {
            let (sin_phi, cos_phi) = (TAU * u[1]).sin_cos();
            let r = 2.0 * (u[0] * (1.0 - u[0])).sqrt();
            let wi = DVec3::new(r * cos_phi, r * sin_phi, 1.0 - 2.0 * u[0]);
            return SkySample { wi, radiance: self.radiance(wi), pdf: 0.25 * FRAC_1_PI };
        }
        let cell = alias::choose_record(self.alias, self.sky.width * self.sky.height, index_word, fraction_word);
        let wi = self.turned(self.direction_in_cell(cell, u));
        SkySample { wi, radiance: self.radiance(wi), pdf: f64::from(self.texels[cell as usize].cell_pdf) }
    }

    /// Direction in the sky's own frame: uniform in solid angle over the cell.
    fn direction_in_cell(&self, cell: u32, u: [f64; 2]) -> DVec3 {
        let (row, column) = (cell / self.sky.width, cell % self.sky.width);
        let height = self.sky.height;
        // A lower row is the mirror image of the upper one at the same distance from its pole.
        let is_lower = 2 * row >= height;
        let from_pole = if is_lower { height - 1 - row } else { row };
        let half_angle = FRAC_PI_2 / f64::from(height);
        let s0 = (f64::from(from_pole) * half_angle).sin().powi(2);
        let s1 = (f64::from(from_pole + 1) * half_angle).sin().powi(2);
        let s = s0 + (s1 - s0) * u[1];
        let cos_theta = if is_lower { 2.0 * s - 1.0 } else { 1.0 - 2.0 * s };
        let sin_theta = 2.0 * (s * (1.0 - s)).sqrt();
        // u = 0.5 + phi/(2 pi), phi from -z towards +x.
        let phi = TAU * ((f64::from(column) + u[0]) / f64::from(self.sky.width) - 0.5);
        DVec3::new(sin_theta * phi.sin(), cos_theta, -sin_theta * phi.cos())
    }

    /// Place in the image, in texels: x in [0, W], y in [0, H].
    pub(crate) fn position(&self, d: DVec3) -> (f64, f64) {
        let d = self.turned_back(d);
        // At a pole u is 0.5 whatever the signs of the zeros, as in the kernels.
        let azimuth = if d.x == 0.0 && d.z == 0.0 { 0.0 } else { d.x.atan2(-d.z) };
        let u = 0.5 + azimuth / TAU;
        // acos(y), in the form that keeps its digits near the poles.
        let v = d.x.hypot(d.z).atan2(d.y) / PI;
        (u * f64::from(self.sky.width), v * f64::from(self.sky.height))
    }

    /// Turns about +y by the sky's rotation.
    fn turned(&self, d: DVec3) -> DVec3 {
        let [c, s] = self.sky.rotation.map(f64::from);
        DVec3::new(c * d.x + s * d.z, d.y, c * d.z - s * d.x)
    }

    fn turned_back(&self, d: DVec3) -> DVec3 {
        let [c, s] = self.sky.rotation.map(f64::from);
        DVec3::new(c * d.x - s * d.z, d.y, c * d.z + s * d.x)
    }
}

#[cfg(test)]
#[path = "sky_tests.rs"]
mod tests;
