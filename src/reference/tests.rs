//! The oracle against closed forms, with every estimator: what it is trusted for.

use glam::DVec3;

use super::independent::{Independent, Stream};
use super::known;
use super::path::trace;
use crate::integrator::{Estimator, Settings};

/// Mean and standard error per channel over all pixels and `spp` samples.
fn mean(scene: &crate::scene::Scene, settings: &Settings, spp: u64) -> (DVec3, DVec3) {
    let world = Independent::new(scene);
    let [width, height] = world.size();
    let (mut sum, mut squares, mut count) = (DVec3::ZERO, DVec3::ZERO, 0.0);
    for y in 0..height {
        for x in 0..width {
            for sample in 0..spp {
                let random = Stream::new(u64::from(settings.seed), [x, y], sample);
                let r = trace(&world, settings, &random, [x, y], |_| ()).radiance;
                (sum, squares, count) = (sum + r, squares + r * r, count + 1.0);
            }
        }
    }
    let mean: DVec3 = sum / count;
    let variance = (squares / count - mean * mean).max(DVec3::ZERO);
    (mean, (variance / count).map(f64::sqrt))
}

#[test]
fn closed_forms_hold_with_every_estimator() {
    for known in known::all() {
        for estimator in [Estimator::Bsdf, Estimator::Light, Estimator::Mis] {
            let settings = Settings { estimator, ..Settings::default() };
            let (mean, error) = mean(&known.scene, &settings, 512);
            // 4.5 standard errors: two-sided 7e-6 a channel; 2e-6 of the value for the width of the view.
            let bound = 4.5 * error + 1e-5 * known.radiance;
            let off = (mean - known.radiance).abs();
            assert!(
                off.cmple(bound).all() && mean.is_finite(),
                "{} ({}) with {estimator:?}: {mean}, expected {}, standard error {error}",
                known.name,
                known.about,
                known.radiance
            );
        }
    }
}
