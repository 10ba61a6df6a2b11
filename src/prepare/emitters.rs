//! What shines in a prepared scene, in the order of the table of lights: suns, triangles, spheres, discs, lamps without a surface.
//!
//! A shape that can shine has three places here: its rows, its emitters, and the row of `lights` that each of them is told.

use glam::DVec3;

use super::records::*;
use super::{Error, Prepared, lights};
use crate::light;
use crate::scene::Scene;

/// Builds the light tables and tells each emissive primitive its row. Surfaces with alpha are left to the paths that run into them.
pub fn attach(p: &mut Prepared, scene: &Scene, emission: &[DVec3], compensate: bool) -> Result<(), Error> {
    let shines = |material: u32| {
        let flags = p.materials[material as usize].flags;
        flags & MATERIAL_EMITS != 0 && flags & (MATERIAL_MASK | MATERIAL_BLEND) == 0
    };
    let is_two_sided = |material: u32| p.materials[material as usize].flags & MATERIAL_EMITS_TWO_SIDED != 0;
    // Placed meshes do not emit.
    let triangle_rows: Vec<usize> =
        (0..p.bvh.flat_triangle_count()).filter(|&i| shines(p.triangles[i].material)).collect();
    let sphere_rows: Vec<usize> = (0..p.spheres.len()).filter(|&i| shines(p.spheres[i].material)).collect();
    let triangles = triangle_rows.iter().map(|&i| {
        let TriangleRecord { v0, v1, v2, face, material, .. } = p.triangles[i];
        light::triangle::emitter([v0, v1, v2], face, material, emission[material as usize], is_two_sided(material))
    });
    let spheres = sphere_rows.iter().map(|&i| {
        let SphereRecord { center, radius, material, .. } = p.spheres[i];
        // The light reads the sphere's record by its place in the table, which is leaf order.
        let (row, radiance) = (i as u32, emission[material as usize]);
        light::sphere::emitter(center, radius, row, material, radiance, is_two_sided(material))
    });
    let disc_rows: Vec<usize> = (0..p.discs.len()).filter(|&i| shines(p.discs[i].material)).collect();
    let discs = disc_rows.iter().map(|&i| {
        let material = p.discs[i].material;
        light::disc::emitter(&p.discs[i], i as u32, emission[material as usize], is_two_sided(material))
    });
    let radius = p.bounding_radius();
    let lamps = lights::lamps(scene, p.origin, radius, &mut p.notes)?;
    // Suns first, for rays that leave the scene look through them all.
    let (suns, lamps): (Vec<_>, Vec<_>) = lamps.into_iter().partition(|e| e.record.kind == light::LIGHT_SUN);
    let first = suns.len();
    let emitters: Vec<light::Emitter> =
        suns.into_iter().chain(triangles).chain(spheres).chain(discs).chain(lamps).collect();
    let tables = lights::build(&lights::LightInput {
        emitters: &emitters,
        sky: scene.sky.as_ref().map(|s| (s, scene.images.as_slice())),
        sky_group: p.sky_group,
        scene_radius: radius,
        compensate,
    })?;
    let (triangle_lights, others) = tables.rows[first..].split_at(triangle_rows.len());
    let (sphere_lights, others) = others.split_at(sphere_rows.len());
    let disc_lights = &others[..disc_rows.len()];
    for (&row, &light) in triangle_rows.iter().zip(triangle_lights) {
        p.triangles[row].light = light;
    }
    for (&row, &light) in sphere_rows.iter().zip(sphere_lights) {
        p.spheres[row].light = light;
    }
    for (&row, &light) in disc_rows.iter().zip(disc_lights) {
        p.discs[row].light = light;
    }
    p.has_sky = tables.sky.light != NONE;
    p.lights = tables.lights;
    p.light_alias = tables.light_alias;
    p.sky = tables.sky;
    p.sky_texels = tables.sky_texels;
    p.sky_alias = tables.sky_alias;
    p.notes.extend(tables.notes);
    Ok(())
}
