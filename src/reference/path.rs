//! The oracle's path loop in f64, shared by its two modes.
//!
//! Unidirectional path tracing (Kajiya 1986) with next-event estimation and multiple importance sampling (Veach 1997,
//! chapter 9), roulette (10.4.1), homogeneous absorption along edges (Beer-Lambert), and stochastic alpha. Vertex 0 is the
//! camera; random numbers at the surface vertex v use (v, purpose). The captions number the steps as the kernel does.

use glam::{DVec2, DVec3};

use super::nested::{EdgeEnd, Inside, Overflows, follow};
use super::receiver::receive;
use super::tree::{Hit, Ray};
pub use super::world::{LightSample, Random, RayKind, World};
use crate::bsdf::{SAMPLE_DELTA, SAMPLE_TRANSMISSION};
use crate::film::aov::GROUP_LIMIT;
use crate::integrator::path::{ALPHA_LAYERS, power_heuristic, survival_probability};
use crate::integrator::{Estimator, Settings};
use crate::prepare::records::NONE;
use crate::sampler;
use crate::texture::CONE_SHARE;

/// One surface vertex of a path, for replays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VertexTrace {
    pub primitive: u32,
    pub point: DVec3,
    /// Shading normal.
    pub normal: DVec3,
    /// Throughput of radiance arriving at this vertex, before it scatters.
    pub throughput: DVec3,
    /// Radiance gathered by next-event estimation here, throughput included.
    pub light: DVec3,
    /// World direction sampled for the next edge; zero where the path ended.
    pub wi: DVec3,
    /// Of the sampled direction, 1/sr or a probability for a delta lobe.
    pub pdf: f64,
}

/// First surface seen, for the AOVs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FirstHit {
    pub albedo: DVec3,
    /// Shading normal.
    pub normal: DVec3,
    /// On the viewer's side where nothing is transmitted.
    pub geometric_normal: DVec3,
    /// In the world's own coordinates, those of its records or of its scene.
    pub position: DVec3,
    pub uv: DVec2,
    pub depth: f64,
    /// Numbers in the scene's lists of instances and materials.
    pub object: u32,
    pub material: u32,
}

/// What one sample brings.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sample {
    pub radiance: DVec3,
    /// The part of it that came by paths of at most two edges: emission seen, and light scattered once.
    pub direct: DVec3,
    /// The parts of it by light groups; those beyond the limit are not kept.
    pub groups: [DVec3; GROUP_LIMIT],
    /// None where nothing is seen but the sky.
    pub first: Option<FirstHit>,
    /// Rays traced, shadow rays included.
    pub rays: u32,
    /// Directions dropped, or normals replaced, because shading and geometric sides disagree.
    pub disagreements: u32,
    pub overflows: Overflows,
    /// The path was cut by `max_depth` at a surface that scatters.
    pub is_cut: bool,
    /// Luminance of the throughput that was cut.
    pub lost: f64,
}

impl Sample {
    /// Adds light of a group that came by a path of `edges` edges.
    fn gather(&mut self, light: DVec3, edges: u32, group: u32) {
        self.radiance += light;
        if let Some(sum) = self.groups.get_mut(group as usize) {
            *sum += light;
        }
        if edges <= 2 {
            self.direct += light;
        }
    }
}

/// Relative luminance of linear Rec.709 (ITU-R BT.709-6, 3.3).
pub fn luminance(rgb: DVec3) -> f64 {
    rgb.dot(DVec3::new(0.2126, 0.7152, 0.0722))
}

/// Fraction of light left after `distance` metres. A channel without absorption stays 1 on infinite edges too.
pub(super) fn transmittance(absorption: DVec3, distance: f64) -> DVec3 {
    let channel = |a: f64| if a > 0.0 { (-a * distance).exp() } else { 1.0 };
    DVec3::new(channel(absorption.x), channel(absorption.y), channel(absorption.z))
}

/// Traces one sample of `pixel`; `observe` sees every surface vertex in order.
pub fn trace<W: World>(
    world: &W,
    settings: &Settings,
    pixel: [u32; 2],
    sample_index: u64,
    mut observe: impl FnMut(VertexTrace),
) -> Sample {
    let random = &world.stream(settings.seed, pixel, sample_index);
    let center = DVec2::new(f64::from(pixel[0]), f64::from(pixel[1])) + 0.5;
    let offset = [sampler::PIXEL_X, sampler::PIXEL_Y].map(|purpose| world.filter_offset(random.unit(0, purpose)));
    let start = world.camera_start(center + DVec2::from(offset), random);
    let mut ray = Ray {
        origin: start.origin,
        direction: start.direction,
        leaves: NONE,
        ignores: NONE,
        cone: world.camera_cone(),
    };
    let mut inside = world.camera_inside();
    // What touches the surface that an edge leaves is behind it: hits up to here do not count, m.
    let mut past = 0.0;
    let mut throughput = DVec3::splat(start.weight);
    let mut eta_scale = 1.0;
    let mut sample = Sample::default();
    let mut vertex = 0;
    // Density of the last scattering; None where light sampling had no chance (camera, delta lobe).
    let mut scatter_pdf: Option<f64> = None;
    // Where light was last sampled from: densities of emitters run into are for this very point.
    let mut from = start.origin;
    // A meter that collects from a hemisphere is served like a surface.
    if let Some(normal) = start.receiver {
        let (light, group, rays) = receive(world, settings, random, &start, normal, &mut sample.overflows);
        sample.gather(throughput * light, 1, group);
        sample.rays += rays;
        scatter_pdf = Some(start.direction.dot(normal) / std::f64::consts::PI);
    }
    for edge in 1..=settings.edges() {
        // 1. Where the edge ends.
        sample.rays += 1;
        let end = edge_end(world, random, (&ray, past), vertex, inside, &mut sample.overflows);
        let hit = end.hit;
        let weight = |light_density: f64| match (scatter_pdf, settings.estimator) {
            (None, _) | (_, Estimator::Bsdf) => 1.0,
            // What light sampling cannot find counts whole.
            (Some(_), Estimator::Light) => f64::from(u8::from(light_density == 0.0)),
            (Some(pdf), Estimator::Mis) => power_heuristic(pdf, light_density),
        };
        // 2. Absorption on the way.
        throughput *= end.through;
        inside = end.inside;
        // 3. What is infinitely far away ends the path.
        let Some(hit) = hit else {
            world.background(ray.direction, &mut |radiance, density, group| {
                sample.gather(throughput * radiance * weight(density), edge, group);
            });
            break;
        };
        // 4. Emission towards the viewer.
        let mut surface = world.surface(&ray, &hit, end.outside);
        surface.orient(-ray.direction);
        if surface.emission != DVec3::ZERO {
            let w = weight(world.emitter_density(&Ray { origin: from, ..ray }, &hit));
            sample.gather(throughput * surface.emission * w, edge, surface.group);
        }
        let wo_world = -ray.direction;
        let shading = surface.shading(wo_world);
        let bsdf = &surface.params;
        if edge == 1 {
            sample.first = Some(FirstHit {
                albedo: bsdf.albedo(),
                normal: shading.frame.z,
                geometric_normal: shading.geometric_normal,
                position: surface.point,
                uv: surface.uv,
                depth: hit.t,
                object: surface.object,
                material: surface.material,
            });
        }
        sample.disagreements += u32::from(shading.disagrees);
        let mut trace = VertexTrace {
            primitive: hit.primitive,
            point: surface.point,
            normal: shading.frame.z,
            throughput,
            light: DVec3::ZERO,
            wi: DVec3::ZERO,
            pdf: 0.0,
        };
        // 5. The last edge; what scattering would have carried on is counted.
        if edge == settings.edges() {
            if bsdf.albedo() != DVec3::ZERO {
                sample.is_cut = true;
                sample.lost = luminance(throughput);
            }
            observe(trace);
            break;
        }
        vertex += 1;
        let wo = shading.frame.to_local(wo_world);
        // The media an edge towards `wi` runs through.
        let beyond = |wi: DVec3| {
            let front = surface.geometric_normal;
            let crosses = (wi.dot(front) < 0.0) != (wo_world.dot(front) < 0.0);
            match surface.boundary {
                _ if crosses && world.nests() => end.beyond,
                Some(interior) if crosses && wi.dot(front) < 0.0 => Inside::only(interior),
                Some(_) if crosses => Inside::default(),
                _ => inside,
            }
        };
        // 6. Next-event estimation. From beside the surface, on the viewer's side: a sphere that lights itself is then seen from
        // inside or outside, not as rounding has it.
        let side = if wo_world.dot(surface.geometric_normal) > 0.0 { 1.0 } else { -1.0 };
        from = surface.point + surface.geometric_normal * (side * 1e-12 * (surface.point.abs().max_element() + hit.t));
        if settings.estimator != Estimator::Bsdf
            && !bsdf.is_delta()
            && let Some(light) = world.sample_light(from, random, vertex, settings.estimator)
        {
            let wi = shading.frame.to_local(light.direction);
            let f = if shading.sides_agree(light.direction, wi) { bsdf.eval(wo, wi) } else { DVec3::ZERO };
            // A surface does not light itself through itself.
            let crosses = side * light.direction.dot(surface.geometric_normal) < 0.0;
            let f = if light.primitive == hit.primitive && crosses { DVec3::ZERO } else { f };
            if light.density > 0.0 && f != DVec3::ZERO && light.radiance != DVec3::ZERO {
                let shadow = Ray {
                    origin: surface.point,
                    direction: light.direction,
                    leaves: hit.primitive,
                    ignores: light.primitive,
                    cone: DVec2::ZERO,
                };
                sample.rays += 1;
                let within = beyond(light.direction);
                let way = (&shadow, end.touching, light.distance);
                if let Some(through) = unblocked(world, random, way, vertex, within, &mut sample.overflows) {
                    let w = match settings.estimator {
                        Estimator::Mis if !light.is_delta => power_heuristic(light.density, bsdf.pdf(wo, wi)),
                        _ => 1.0,
                    };
                    trace.light = throughput * f * light.radiance * through * (w / light.density);
                    sample.gather(trace.light, edge + 1, light.group);
                }
            }
        }
        // 7. Scatter.
        let u = [random.unit(vertex, sampler::BSDF_U), random.unit(vertex, sampler::BSDF_V)];
        let Some(scattered) =
            bsdf.sample(wo, random.bits(vertex, sampler::BSDF_MIX), random.bits(vertex, sampler::BSDF_LOBE), u)
        else {
            observe(trace);
            break;
        };
        let wi = shading.frame.to_world(scattered.wi);
        (trace.wi, trace.pdf) = (wi, scattered.pdf);
        observe(trace);
        if !shading.sides_agree(wi, scattered.wi) {
            sample.disagreements += 1;
            break;
        }
        throughput *= scattered.weight;
        if throughput == DVec3::ZERO {
            break;
        }
        eta_scale *= scattered.eta_scale;
        scatter_pdf = (scattered.flags & SAMPLE_DELTA == 0).then_some(scattered.pdf);
        if scattered.flags & SAMPLE_TRANSMISSION != 0 {
            inside = beyond(wi);
        }
        // A smooth surface keeps the growth of the cone, a rough one widens it.
        let share = f64::from(CONE_SHARE) / scattered.pdf.sqrt();
        let growth = if scatter_pdf.is_some() { ray.cone.y.max(share) } else { ray.cone.y };
        let cone = DVec2::new(ray.cone.x + ray.cone.y * hit.t, growth);
        ray = Ray { origin: surface.point, direction: wi, leaves: hit.primitive, ignores: NONE, cone };
        past = end.touching;
        // 8. Roulette.
        if edge >= settings.first_roulette_edge() {
            let q = survival_probability(throughput, eta_scale);
            if !random.accepts(vertex, sampler::ROULETTE, q) {
                break;
            }
            throughput /= q;
        }
    }
    sample
}

/// Where the edge along `ray` ends; hits up to `past` do not count.
fn edge_end<W: World>(
    world: &W,
    random: &W::Stream,
    (ray, past): (&Ray, f64),
    vertex: u32,
    inside: Inside,
    overflows: &mut Overflows,
) -> EdgeEnd {
    if world.nests() {
        return follow(world, random, (ray, past, f64::INFINITY), (vertex, RayKind::Closest), inside, overflows);
    }
    let hit = closest_present(world, random, ray, vertex, &mut overflows.alpha);
    let through = inside.transmittance(world, hit.map_or(f64::INFINITY, |h| h.t));
    EdgeEnd { hit, through, inside, beyond: inside, outside: 1.0, touching: 0.0 }
}

/// What absorption leaves of light that comes from `distance`; None where something is in its way.
pub(super) fn unblocked<W: World>(
    world: &W,
    random: &W::Stream,
    (ray, past, distance): (&Ray, f64, f64),
    vertex: u32,
    inside: Inside,
    overflows: &mut Overflows,
) -> Option<DVec3> {
    if world.nests() {
        let end = follow(world, random, (ray, past, distance), (vertex, RayKind::Shadow), inside, overflows);
        return end.hit.is_none().then_some(end.through);
    }
    let is_blocked = is_blocked(world, random, ray, distance, vertex, &mut overflows.alpha);
    (!is_blocked).then(|| inside.transmittance(world, distance))
}

/// First hit that is there. Candidates come in the order (t, primitive), each decided by its own hash; the one after
/// ALPHA_LAYERS absent ones stands for what is no longer followed.
fn closest_present<W: World>(
    world: &W,
    random: &W::Stream,
    ray: &Ray,
    vertex: u32,
    overflows: &mut u32,
) -> Option<Hit> {
    let mut hit = world.tree().closest(ray, None, f64::INFINITY)?;
    if world.has_alpha() {
        let mut absent = 0;
        while absent < ALPHA_LAYERS && !is_present(world, random, ray, &hit, vertex, RayKind::Closest) {
            absent += 1;
            hit = world.tree().closest(ray, Some(&hit), f64::INFINITY)?;
        }
        *overflows += u32::from(absent == ALPHA_LAYERS);
    }
    Some(hit)
}

/// Hits come in no order: one that is there blocks, and so do more than ALPHA_LAYERS that are not.
fn is_blocked<W: World>(
    world: &W,
    random: &W::Stream,
    ray: &Ray,
    distance: f64,
    vertex: u32,
    overflows: &mut u32,
) -> bool {
    let mut absent = 0;
    let is_blocked = world.tree().any(ray, distance, |hit| {
        if !world.has_alpha() || is_present(world, random, ray, hit, vertex, RayKind::Shadow) {
            return true;
        }
        absent += 1;
        false
    });
    *overflows += u32::from(!is_blocked && absent > ALPHA_LAYERS);
    is_blocked || absent > ALPHA_LAYERS
}

pub(super) fn is_present<W: World>(
    world: &W,
    random: &W::Stream,
    ray: &Ray,
    hit: &Hit,
    vertex: u32,
    kind: RayKind,
) -> bool {
    let presence = world.presence(ray, hit);
    presence >= 1.0 || random.is_present(vertex, kind, hit, presence)
}
