//! Media that surfaces bound: whether they nest, their indices and ranks, and those the camera stands in.
//!
//! Where bodies of refracting media overlap, paths keep a stack of what they have entered (shaders/integrator/media.glsl, after
//! Schmidt and Budge 2002). Bodies overlap when the boxes of their shapes do: a test that costs a scene with apart bodies nothing.
//! A surface that shines bounds no nested medium: it could be hidden, and light sampling would not know.

use std::collections::BTreeMap;

use glam::DVec3;

use super::Prepared;
use super::records::*;
use crate::bsdf::MODELS;
use crate::scene::{Instance, Material, Scene, Shape, Surface, Value};

/// The material's surfaces part two media.
pub fn bounds_medium(m: &Material) -> bool {
    m.transmits() && !m.is_thin() && !m.emits()
}

/// Index of refraction behind the material's surfaces; a textured one is that of the model's default.
pub fn index_of(m: &Material) -> f64 {
    let of = |s: &Surface| {
        let place = MODELS[s.bsdf].inputs.iter().position(|i| i.is_index)?;
        match &s.inputs[place] {
            Value::Constant(c) if c[0] > 0.0 => Some(c[0]),
            _ => Some(MODELS[s.bsdf].inputs[place].default[0]),
        }
    };
    m.surfaces().iter().filter(|s| s.lets_through()).find_map(of).unwrap_or(1.0)
}

/// Rank of each priority among those that bound a medium.
pub fn ranks(scene: &Scene) -> BTreeMap<u32, u32> {
    let used = scene.materials.iter().zip(scene.used_materials()).filter(|(_, is_used)| *is_used).map(|(m, _)| m);
    let mut priorities: Vec<u32> = used.filter(|m| bounds_medium(m)).map(|m| m.priority).collect();
    priorities.sort_unstable();
    priorities.dedup();
    priorities.into_iter().zip(0..).collect()
}

/// Boxes of two shapes that bound media overlap or touch.
pub fn nest(scene: &Scene) -> bool {
    let bounds = |i: &&Instance| scene.materials.get(i.material).is_some_and(bounds_medium);
    let mut boxes: Vec<[DVec3; 2]> =
        scene.instances.iter().filter(bounds).filter_map(|i| world_box(scene, i)).collect();
    // Bodies that share a face touch: 1e-6 is far above the rounding of transforms.
    let touch = 1e-6 * boxes.iter().flatten().fold(0.0f64, |s, p| s.max(p.abs().max_element()));
    let overlap = |a: &[DVec3; 2], b: &[DVec3; 2]| a[0].max(b[0]).cmple(a[1].min(b[1]) + touch).all();
    // Along x, so that many bodies apart are not compared pair by pair.
    boxes.sort_by(|a, b| a[0].x.total_cmp(&b[0].x));
    let mut furthest = f64::NEG_INFINITY;
    let mut first = 0;
    boxes.iter().enumerate().any(|(k, a)| {
        // All before `first` end before anything from here on begins.
        if a[0].x > furthest + touch {
            first = k;
        }
        furthest = furthest.max(a[1].x);
        boxes[first..k].iter().any(|b| overlap(a, b))
    })
}

/// Box about the shape's own box, in the world.
fn world_box(scene: &Scene, instance: &Instance) -> Option<[DVec3; 2]> {
    let [low, high] = match instance.shape {
        Shape::Mesh(mesh) => {
            let positions = &scene.meshes.get(mesh)?.positions;
            let around = |[low, high]: [DVec3; 2], p: &[f32; 3]| {
                let p = DVec3::from(p.map(f64::from));
                [low.min(p), high.max(p)]
            };
            positions.iter().fold([DVec3::INFINITY, DVec3::NEG_INFINITY], around)
        }
        Shape::Sphere => [DVec3::NEG_ONE, DVec3::ONE],
        // Flat shapes: rectangle and disc.
        _ => [DVec3::new(-1.0, -1.0, 0.0), DVec3::new(1.0, 1.0, 0.0)],
    };
    let corner = |k: u32| {
        let pick = |axis: usize| if k >> axis & 1 == 1 { high[axis] } else { low[axis] };
        instance.to_world.transform_point3(DVec3::new(pick(0), pick(1), pick(2)))
    };
    let bounds = (0..8).map(corner).fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[a, b], p| [a.min(p), b.max(p)]);
    bounds.iter().all(|b| b.is_finite()).then_some(bounds)
}

/// A boundary met by a ray from the camera.
struct Met {
    t: f64,
    is_back: bool,
    material: u32,
}

/// The media around the camera: the row of the only one, and the entries of all. Any ray will do: what it leaves more often than it
/// enters, the camera is in; what it leaves last, the camera has entered first.
pub fn around_camera(p: &Prepared) -> (u32, [u32; 4]) {
    if p.media.is_empty() {
        return (NONE, [0; 4]);
    }
    let mut met = boundaries(p, DVec3::new(0.36, 0.48, 0.8));
    met.sort_by(|a, b| a.t.total_cmp(&b.t));
    let interior = |m: &Met| p.materials[m.material as usize].interior;
    let entry = |m: &Met| match interior(m) {
        NONE => 0,
        row => p.materials[m.material as usize].priority << 16 | (row + 1),
    };
    // Where media do not nest, the nearest boundary says it.
    if !p.nests {
        let Some(first) = met.first().filter(|m| m.is_back && interior(m) != NONE) else { return (NONE, [0; 4]) };
        return (interior(first), [entry(first), 0, 0, 0]);
    }
    let mut entered = BTreeMap::<u32, u32>::new();
    let mut around = Vec::new();
    for m in met.iter().filter(|m| entry(m) != 0) {
        let depth = entered.entry(m.material).or_default();
        match (m.is_back, *depth) {
            (false, _) => *depth += 1,
            (true, 0) => around.push(entry(m)),
            (true, _) => *depth -= 1,
        }
    }
    let mut media = [0; 4];
    // Met from inside out; the innermost four.
    let count = around.len().min(4);
    around[..count].iter().rev().zip(&mut media).for_each(|(entry, place)| *place = *entry);
    (NONE, media)
}

/// All boundaries of media along a ray from the origin.
fn boundaries(p: &Prepared, direction: DVec3) -> Vec<Met> {
    let mut met = Vec::new();
    let mut meet = |t: f64, is_back: bool, material: u32| {
        let flags = p.materials[material as usize].flags;
        if t > 0.0 && flags & MATERIAL_TRANSMITS != 0 && flags & MATERIAL_THIN == 0 {
            met.push(Met { t, is_back, material });
        }
    };
    let vec = |a: [f32; 3]| DVec3::new(a[0].into(), a[1].into(), a[2].into());
    for ([a, b, c], material) in p.triangles_towards(direction) {
        let normal = (b - a).cross(c - a);
        let along = normal.dot(direction);
        if along == 0.0 {
            continue;
        }
        let distance = normal.dot(a) / along;
        let hit = direction * distance;
        let side = |u: DVec3, v: DVec3| (v - u).cross(hit - u).dot(normal) >= 0.0;
        if side(a, b) && side(b, c) && side(c, a) {
            meet(distance, along > 0.0, material);
        }
    }
    for s in &p.spheres {
        let (center, radius) = (vec(s.center), f64::from(s.radius));
        let middle = center.dot(direction);
        let square = radius * radius - (center - direction * middle).length_squared();
        if square > 0.0 {
            let half = square.sqrt();
            meet(middle - half, false, s.material);
            meet(middle + half, true, s.material);
        }
    }
    for d in &p.discs {
        let (center, normal) = (vec(d.center), vec(d.normal));
        let along = normal.dot(direction);
        let distance = normal.dot(center) / along;
        if (direction * distance - center).length() <= f64::from(d.radius) {
            meet(distance, along > 0.0, d.material);
        }
    }
    met
}
