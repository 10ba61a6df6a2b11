//! What the lights' own mathematics ask of the world that they are sampled in.

use glam::DVec3;

use super::{Replay, Stream};
use crate::light::{Place, Surroundings};
use crate::prepare::Prepared;
use crate::reference::path::Random;
use crate::sampler::Purpose;

/// Where a light is sampled from.
pub(super) struct Vertex<'a> {
    pub world: &'a Replay,
    pub random: &'a Stream,
    pub vertex: u32,
}

impl Surroundings for Vertex<'_> {
    fn prepared(&self) -> &Prepared {
        &self.world.prepared
    }

    fn word(&self, purpose: Purpose) -> u32 {
        self.random.bits(self.vertex, purpose)
    }

    fn emission(&self, material: u32, place: Place, is_front: bool) -> DVec3 {
        let world = self.world;
        let material = &world.prepared.materials[material as usize];
        let point = match place {
            Place::Face(face, b) => world.face_point(face, b),
            Place::Sphere(row, normal) => world.sphere_point(&world.prepared.spheres[row as usize], normal),
            Place::Disc(row, position) => world.disc_point(&world.prepared.discs[row as usize], position),
        };
        world.emission(material, &point, is_front) * world.alpha(material, &point)
    }
}
