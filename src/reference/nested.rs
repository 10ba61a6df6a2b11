//! Nested dielectrics in the oracle: which boundaries are there, and between which media.
//!
//! Schmidt and Budge 2002, "Simple nested dielectrics in ray traced images": bodies may overlap; the one of the highest priority
//! fills the space, of equals the one entered last. A boundary is there where the medium that fills the space changes. Boundaries
//! that touch (nearer than the rounding of the f32 they were made from) are crossed together.

use glam::DVec3;

use super::path::{RayKind, World, is_present, transmittance};
use super::tree::{Hit, Ray};
use crate::integrator::path::ALPHA_LAYERS;
use crate::prepare::records::NONE;

/// What a path has entered, the newest last. With a single medium, at most one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Inside {
    media: [u32; 4],
    count: usize,
}

/// What the oracle knows of a medium.
#[derive(Clone, Copy, Debug)]
pub struct Medium {
    pub absorption: DVec3,
    /// Of refraction.
    pub index: f64,
    pub priority: u32,
}

const AIR: Medium = Medium { absorption: DVec3::ZERO, index: 1.0, priority: 0 };

impl Inside {
    /// One medium, or none for NONE.
    pub fn only(medium: u32) -> Self {
        let mut inside = Self::default();
        if medium != NONE {
            inside.enter(medium);
        }
        inside
    }

    /// False when there is no room: then nothing changes.
    pub fn enter(&mut self, medium: u32) -> bool {
        if self.count == self.media.len() {
            return false;
        }
        self.media[self.count] = medium;
        self.count += 1;
        true
    }

    /// Forgets the newest of this medium; where there is none, the one that fills the space.
    fn leave<W: World>(&mut self, world: &W, medium: u32) {
        let entered = &self.media[..self.count];
        let held = entered.iter().rposition(|&m| m == medium);
        let Some(place) = held.or_else(|| entered.iter().rposition(|&m| m == self.filling(world))) else { return };
        self.media.copy_within(place + 1..self.count, place);
        self.count -= 1;
    }

    /// Of an edge of this length.
    pub fn transmittance<W: World>(&self, world: &W, distance: f64) -> DVec3 {
        transmittance(of(world, self.filling(world)).absorption, distance)
    }

    /// The medium that fills the space, or NONE.
    pub fn filling<W: World>(&self, world: &W) -> u32 {
        let priority = |m: &&u32| world.medium(**m).priority;
        // Of equals the last.
        self.media[..self.count].iter().max_by_key(priority).copied().unwrap_or(NONE)
    }
}

fn of<W: World>(world: &W, medium: u32) -> Medium {
    if medium == NONE { AIR } else { world.medium(medium) }
}

/// Where an edge ends.
#[derive(Clone, Copy, Debug)]
pub struct EdgeEnd {
    pub hit: Option<Hit>,
    /// Of the whole edge.
    pub through: DVec3,
    /// On its last stretch.
    pub inside: Inside,
    /// Behind the surface that ends it.
    pub beyond: Inside,
    /// Index of refraction in front of that surface; where it bounds nothing, where the path is.
    pub outside: f64,
    /// The next edge starts past what touches this place, m.
    pub touching: f64,
}

/// Counts of what did not fit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Overflows {
    /// Rays that passed more surfaces that are not there than are followed.
    pub alpha: u32,
    /// Entries into a fifth medium.
    pub media: u32,
}

/// Boundaries met at one place.
struct Place {
    t: f64,
    reach: f64,
    /// More than one boundary.
    is_shared: bool,
    beyond: Inside,
    /// The surface of the highest priority, that priority, and whether it is entered.
    surface: (Hit, u32, bool),
}

/// Follows a ray to the first surface that is there, up to `distance`, from `start` on.
pub fn follow<W: World>(
    world: &W,
    random: &W::Stream,
    (ray, start, distance): (&Ray, f64, f64),
    (vertex, kind): (u32, RayKind),
    mut inside: Inside,
    overflows: &mut Overflows,
) -> EdgeEnd {
    let mut through = DVec3::ONE;
    let mut absorbed = 0.0;
    let mut place: Option<Place> = None;
    let mut passed = 0;
    let origin = Hit { t: start, primitive: u32::MAX, barycentric: [0.0; 2], is_far: false };
    let mut next = world.tree().closest(ray, (start > 0.0).then_some(&origin), distance);
    loop {
        let is_absent =
            next.is_some_and(|hit| world.has_alpha() && !is_present(world, random, ray, &hit, vertex, kind));
        let boundary = next.filter(|_| !is_absent).and_then(|hit| world.boundary_medium(hit.primitive));
        let joins = boundary.is_some() && place.as_ref().is_some_and(|p| next.is_some_and(|h| h.t - p.t <= p.reach));
        // A place is complete when something comes that does not belong to it.
        if !is_absent
            && !joins
            && let Some(p) = place.take()
        {
            let (before, after) = (inside.filling(world), p.beyond.filling(world));
            through *= transmittance(of(world, before).absorption, p.t - absorbed);
            absorbed = p.t;
            if before != after {
                let (hit, _, is_entered) = p.surface;
                let outside = of(world, if is_entered { before } else { after }).index;
                let touching = if p.is_shared { 2.0 * p.reach } else { 0.0 };
                return EdgeEnd { hit: Some(hit), through, inside, beyond: p.beyond, outside, touching };
            }
            inside = p.beyond;
        }
        let is_far = passed == ALPHA_LAYERS && next.is_some();
        if !is_absent && boundary.is_none() || is_far {
            overflows.alpha += u32::from(is_far);
            let medium = of(world, inside.filling(world));
            through *= transmittance(medium.absorption, next.map_or(distance, |h| h.t) - absorbed);
            return EdgeEnd { hit: next, through, inside, beyond: inside, outside: medium.index, touching: 0.0 };
        }
        passed += 1;
        if let (Some(hit), Some(medium)) = (next, boundary) {
            let surface = world.surface(ray, &hit, 1.0);
            let along = ray.direction.dot(surface.geometric_normal);
            let is_front = along < 0.0;
            let opens = place.is_none();
            if opens {
                // An open surface met from behind: the path has been inside all along.
                let beyond = inside;
                if !is_front && inside.count == 0 {
                    inside.enter(medium);
                }
                let reach = 2e-6 * (surface.point.abs().max_element() + hit.t) / along.abs().max(0.02);
                let surface = (hit, of(world, medium).priority, is_front);
                place = Some(Place { t: hit.t, reach, is_shared: false, beyond, surface });
            }
            if let Some(p) = &mut place {
                p.is_shared = !opens;
                if is_front {
                    overflows.media += u32::from(!p.beyond.enter(medium));
                } else {
                    p.beyond.leave(world, medium);
                }
                let priority = of(world, medium).priority;
                if priority > p.surface.1 {
                    p.surface = (hit, priority, is_front);
                }
            }
        }
        next = next.and_then(|hit| world.tree().closest(ray, Some(&hit), distance));
    }
}
