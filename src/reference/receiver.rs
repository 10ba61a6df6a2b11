//! Light sampling at a meter that collects from a hemisphere (`camera::Start::receiver`): the first vertex of its paths.

use glam::{DVec2, DVec3};

use super::nested::Overflows;
use super::path::{World, unblocked};
use super::tree::Ray;
use crate::camera::Start;
use crate::integrator::path::power_heuristic;
use crate::integrator::{Estimator, Settings};
use crate::prepare::records::NONE;

/// What one light sample adds to the estimate of L cos/pi over the hemisphere, its light group, and the rays that it took.
pub(super) fn receive<W: World>(
    world: &W,
    settings: &Settings,
    random: &W::Stream,
    start: &Start,
    normal: DVec3,
    overflows: &mut Overflows,
) -> (DVec3, u32, u32) {
    let none = (DVec3::ZERO, 0, 0);
    if settings.estimator == Estimator::Bsdf {
        return none;
    }
    let Some(light) = world.sample_light(start.origin, random, 0, settings.estimator) else { return none };
    // Of the directions that the meter chooses by itself.
    let density = light.direction.dot(normal) / std::f64::consts::PI;
    if light.density.is_nan() || light.density <= 0.0 || density <= 0.0 || light.radiance == DVec3::ZERO {
        return none;
    }
    let shadow = Ray {
        origin: start.origin,
        direction: light.direction,
        leaves: NONE,
        ignores: light.primitive,
        cone: DVec2::ZERO,
    };
    let way = (&shadow, 0.0, light.distance);
    let Some(through) = unblocked(world, random, way, 0, world.camera_inside(), overflows) else {
        return (DVec3::ZERO, 0, 1);
    };
    let weight = match settings.estimator {
        Estimator::Mis if !light.is_delta => power_heuristic(light.density, density),
        _ => 1.0,
    };
    (light.radiance * through * (weight * density / light.density), light.group, 1)
}
