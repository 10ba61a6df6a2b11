//! Gate 7, the cosine law: irradiance of a receiver turned away from a distant lamp, as a ratio to that of the receiver facing it.

use glam::DVec3;

use super::images::{ROUNDING, image_mean, settings};
use super::probe::EPS;
use super::report::{Gate, GateRow};
use super::subject::Subject;
use crate::error::Error;
use crate::film::slot::BLOCK_SAMPLES;
use crate::integrator::Estimator;
use crate::metric::stats::{normal_quantile, sidak};
use crate::reference::known::{TILTS_DEG, tilted_receiver};

/// False alarms of the row, at most.
const LEVEL: f64 = 1e-4;

pub const NAME: &str = "closed form cosine law";

/// One row for all angles: E(theta)/E(0) against cos(theta), 0 to 89.9 degrees.
pub fn row(subject: &Subject, spp: u32) -> Result<GateRow, Error> {
    let z = normal_quantile(1.0 - 0.5 * sidak(LEVEL, 3 * TILTS_DEG.len()));
    let mut facing = None;
    let (mut worst, mut evidence) = (0.0f64, Vec::new());
    for tilt in TILTS_DEG {
        let known = tilted_receiver(tilt);
        let film = subject.film(&known.scene, &settings(Estimator::Mis), u64::from(spp.div_ceil(BLOCK_SAMPLES)))?;
        let (mean, error) = image_mean(&film);
        let (mean0, error0) = *facing.get_or_insert((mean, error));
        let (ratio, cos) = (mean / mean0, tilt.to_radians().cos());
        let relative = (error / mean).powf(2.0) + (error0 / mean0).powf(2.0);
        // Two directions rounded to f32 stand at an angle that is off by an eps each: its cosine by tan(theta) of that.
        let rounding = ROUNDING + 2.0 * EPS * tilt.to_radians().tan();
        let bound = cos * (z * relative.map(f64::sqrt) + rounding);
        let off = (ratio - cos).abs();
        // A NaN is out of bounds.
        let share = if (off / bound).is_nan() { f64::INFINITY } else { (off / bound).max_element() };
        worst = worst.max(share);
        let percent = |v: DVec3| 100.0 * (v / cos).max_element();
        evidence.push(format!("{tilt} deg {:.6} off by {:.4} of {:.4} %", ratio.y, percent(off), percent(bound)));
    }
    Ok(GateRow::new(
        Gate::Images,
        NAME,
        worst <= 1.0,
        format!("{spp} spp: {}", evidence.join(", ")),
        "E(theta)/E(0) = cos(theta) within the second figure: standard errors (Sidak over angles and channels) and rounding",
    ))
}
