//! Media of the author's scene: which surfaces bound one, whether bodies overlap, and what is around a point.

use glam::DVec3;

use super::{Independent, may_be_positive};
use crate::bsdf::MODELS;
use crate::prepare::records::NONE;
use crate::reference::nested::{Inside, Medium};
use crate::reference::path::World;
use crate::reference::tree::{Bounds, Ray, free_ray};
use crate::scene::{self, Material, Value};

impl Independent<'_> {
    /// The medium around a point: that of the first surface with an interior whose back is seen along an arbitrary line.
    pub(super) fn medium_at(&self, point: DVec3) -> u32 {
        if self.scene.materials.iter().all(|m| m.interior.is_none()) {
            return NONE;
        }
        // A direction that no scene is likely to align with.
        let mut ray = free_ray(point, DVec3::new(0.3713, 0.8127, 0.4491).normalize());
        while let Some(hit) = self.tree.closest(&ray, None, f64::INFINITY) {
            let surface = self.surface(&ray, &hit, 1.0);
            if let Some(interior) = surface.boundary {
                let is_back = ray.direction.dot(surface.geometric_normal) > 0.0;
                return if is_back { interior } else { NONE };
            }
            ray = Ray { origin: ray.at(hit.t), leaves: hit.primitive, ..ray };
        }
        NONE
    }

    /// The surface parts two media, one of which may be inside another.
    pub(super) fn bounds_medium(&self, material: &Material) -> bool {
        transmits(material) && !is_thin(material) && !material.emits()
    }

    /// Whether the boxes of two instances that bound media share a volume or touch.
    pub(super) fn bodies_overlap(&self) -> bool {
        let mut boxes: std::collections::BTreeMap<u32, (DVec3, DVec3)> = Default::default();
        for (number, instance) in self.scene.instances.iter().enumerate() {
            if !self.bounds_medium(&self.scene.materials[instance.material]) {
                continue;
            }
            for p in self.primitives.of_instance(number).map(|n| self.primitives.get(n)) {
                let Bounds { min: low, max: high } = p.shape.bounds();
                let entry = boxes.entry(p.instance).or_insert((low, high));
                *entry = (entry.0.min(low), entry.1.max(high));
            }
        }
        let boxes: Vec<_> = boxes.into_values().collect();
        let touch = 1e-6 * boxes.iter().fold(0.0, |s: f64, b| s.max(b.0.abs().max(b.1.abs()).max_element()));
        (0..boxes.len()).any(|i| {
            (0..i).any(|j| (0..3).all(|a| boxes[i].0[a].max(boxes[j].0[a]) <= boxes[i].1[a].min(boxes[j].1[a]) + touch))
        })
    }

    /// All media around a point: those that a line from it leaves without having entered them, outermost first.
    pub(super) fn media_at(&self, point: DVec3) -> Inside {
        let ray = free_ray(point, DVec3::new(0.3713, 0.8127, 0.4491).normalize());
        let (mut entered, mut around): (Vec<u32>, Vec<u32>) = Default::default();
        let mut last = None;
        while let Some(hit) = self.tree.closest(&ray, last.as_ref(), f64::INFINITY) {
            last = Some(hit);
            let Some(medium) = self.boundary_medium(hit.primitive) else { continue };
            if ray.direction.dot(self.surface(&ray, &hit, 1.0).geometric_normal) < 0.0 {
                entered.push(medium);
            } else if let Some(place) = entered.iter().position(|m| *m == medium) {
                entered.remove(place);
            } else {
                around.push(medium);
            }
        }
        let mut inside = Inside::default();
        for medium in around.into_iter().take(4).rev() {
            inside.enter(medium);
        }
        inside
    }
}

/// Light can get through: models with a `transmission` input when that may be positive, else as the model says.
fn lets_through(surface: &scene::Surface) -> bool {
    surface.input("transmission").map_or(MODELS[surface.bsdf].transmits, may_be_positive)
}

pub fn transmits(material: &Material) -> bool {
    material.surfaces().iter().any(lets_through)
}

/// Both sides are in the same medium.
pub fn is_thin(material: &Material) -> bool {
    let is_wall =
        |s: &scene::Surface| MODELS[s.bsdf].keyword.starts_with("thin") || s.input("thin").is_some_and(may_be_positive);
    material.surfaces().iter().filter(|s| lets_through(s)).all(is_wall)
}

/// The medium behind a material's surfaces.
pub fn medium_of(material: &Material) -> Medium {
    // Of the first surface that refracts; textured, it is that of the model's default.
    let index = material.surfaces().iter().filter(|s| lets_through(s)).find_map(|s| {
        let input = MODELS[s.bsdf].inputs.iter().find(|i| ["ior", "eta"].contains(&i.name))?;
        match s.input(input.name) {
            Some(Value::Constant([x, ..])) if *x > 0.0 => Some(*x),
            _ => Some(input.default[0]),
        }
    });
    Medium {
        absorption: material.interior.map_or(DVec3::ZERO, |m| m.absorption),
        index: index.unwrap_or(1.0),
        priority: material.priority,
    }
}
