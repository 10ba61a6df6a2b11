//! Nested media with known answers: overlapping and touching slabs, nested balls in a white furnace.

use glam::{DAffine3, DQuat, DVec3};

use super::known::{Known, material, narrow, place, sphere_at};
use crate::scene::*;

fn dielectric(name: &str, index: f64, absorption: DVec3, priority: u32) -> Material {
    let inputs = [("eta", Value::scalar(index)), ("roughness", Value::scalar(0.0))];
    let interior = Some(Medium { absorption });
    Material { name: name.to_owned(), interior, priority, ..material("dielectric", &inputs) }
}

fn white_sky(scene: &mut Scene) {
    scene.sky = Some(Sky { radiance: SkyRadiance::Uniform(DVec3::ONE), rotation_rad: 0.0, scale: 1.0 });
}

/// A closed slab between two heights, one mesh with its front outside.
fn slab(scene: &mut Scene, name: &str, [low, high]: [f64; 2], material: Material) {
    let corner = |k: u32| [0, 1, 2].map(|axis| if k >> axis & 1 == 1 { 1.0f32 } else { -1.0 });
    let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    scene.meshes.push(Mesh {
        name: name.to_owned(),
        positions: (0..8).map(corner).collect(),
        triangles: quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).collect(),
        ..Mesh::default()
    });
    let scale = DVec3::new(50.0, 0.5 * (high - low), 50.0);
    let to_world = DAffine3::from_scale_rotation_translation(scale, DQuat::IDENTITY, DVec3::Y * (0.5 * (low + high)));
    let mesh = scene.meshes.len() - 1;
    place(scene, name, Shape::Mesh(mesh), to_world, material);
}

/// Air over glass over water over air. `overlap`: how far the water reaches into the glass; 0 where they touch.
fn glass_on_water(name: &'static str, about: &'static str, overlap: f64) -> Known {
    let (glass, water) = (1.5, 1.33);
    let (in_glass, in_water) = (DVec3::new(0.1, 0.5, 2.0), DVec3::new(1.0, 0.3, 0.0));
    let mut scene = narrow("glass-on-water", DVec3::new(0.1, 2.0, 0.2), DVec3::new(0.1, 0.0, 0.2));
    slab(&mut scene, "water", [-0.9, -0.4 + overlap], dielectric("water", water, in_water, 1));
    slab(&mut scene, "glass", [-0.4, 0.0], dielectric("glass", glass, in_glass, 2));
    white_sky(&mut scene);
    // White from both sides.
    let radiance = |c: usize| {
        let (reflected, transmitted) = pile(&[1.0, glass, water, 1.0], &[0.0, 0.4 * in_glass[c], 0.5 * in_water[c]]);
        reflected + transmitted
    };
    Known { name, about, scene, radiance: DVec3::new(radiance(0), radiance(1), radiance(2)) }
}

/// The water reaches into the glass, whose priority hides its boundary there.
pub fn overlapping_plates() -> Known {
    glass_on_water("overlapping plates", "glass on water, overlapping: the interface has eta = n_water/n_glass", 0.1)
}

/// The two share a boundary, face on face.
pub fn touching_plates() -> Known {
    glass_on_water("touching plates", "glass on water, face on face: no air between them", 0.0)
}

/// Clear balls inside each other and across each other, in a uniform field: they cannot be seen.
pub fn invisible_balls() -> Known {
    let mut scene = narrow("invisible-balls", DVec3::new(0.0, 0.3, 5.0), DVec3::ZERO);
    scene.camera = super::known::camera(DVec3::new(0.0, 0.3, 5.0), DVec3::ZERO, 0.35);
    let clear = |name, index, priority| dielectric(name, index, DVec3::ZERO, priority);
    place(&mut scene, "ball", Shape::Sphere, sphere_at(DVec3::ZERO, 1.0), clear("water", 1.33, 1));
    place(&mut scene, "core", Shape::Sphere, sphere_at(DVec3::new(0.2, 0.1, 0.0), 0.6), clear("glass", 1.6, 1));
    place(&mut scene, "bubble", Shape::Sphere, sphere_at(DVec3::new(0.3, 0.1, 0.1), 0.2), clear("air", 1.0, 3));
    place(&mut scene, "across", Shape::Sphere, sphere_at(DVec3::new(-0.9, 0.0, 0.2), 0.5), clear("flint", 1.8, 2));
    white_sky(&mut scene);
    Known {
        name: "invisible balls",
        about: "nested and overlapping clear balls in a uniform field: L = 1 everywhere",
        scene,
        radiance: DVec3::ONE,
    }
}

/// The camera stands in water inside a glass ball, and looks along a radius: what comes from the white sky has crossed both.
pub fn inside_nested_balls() -> Known {
    let absorption = DVec3::new(0.2, 0.5, 1.0);
    let mut scene = narrow("inside-nested-balls", DVec3::ZERO, DVec3::X);
    place(
        &mut scene,
        "glass",
        Shape::Sphere,
        sphere_at(DVec3::ZERO, 1.5),
        dielectric("glass", 1.5, 2.0 * absorption, 1),
    );
    place(&mut scene, "water", Shape::Sphere, sphere_at(DVec3::ZERO, 1.0), dielectric("water", 1.33, absorption, 2));
    white_sky(&mut scene);
    // From the centre every ray meets every boundary head-on and comes back to the centre: a pile that is folded at the viewer.
    let radiance = |c: usize| {
        let (reflected, transmitted) = pile(&[1.33, 1.5, 1.0], &[absorption[c], 2.0 * absorption[c] * 0.5]);
        // Radiance in water is that in air times 1.33^2, and of what goes outward a share comes back through the centre.
        1.33f64.powi(2) * transmitted / (1.0 - reflected)
    };
    Known {
        name: "inside nested balls",
        about: "from the centre of water in a glass ball: n^2 T/(1 - R)",
        scene,
        radiance: DVec3::new(radiance(0), radiance(1), radiance(2)),
    }
}

/// Reflectance and transmittance of a pile of plates along their normal, as seen from the first medium: `optical_depths` are those of the
/// media before each interface. Two piles join as R = R1 + T1^2 R2/(1 - R1' R2), T = T1 T2/(1 - R1' R2) (Stokes 1862), with
/// R towards the viewer and R' back from below.
fn pile(indices: &[f64], optical_depths: &[f64]) -> (f64, f64) {
    let (mut above, mut through, mut below) = (0.0, 1.0, 0.0);
    for (pair, depth) in indices.windows(2).zip(optical_depths) {
        let a = (-depth).exp();
        (through, below) = (through * a, below * a * a);
        let r = ((pair[0] - pair[1]) / (pair[0] + pair[1])).powi(2);
        let t = 1.0 - r;
        let series = 1.0 / (1.0 - below * r);
        (above, through, below) =
            (above + through * through * r * series, through * t * series, r + t * t * below * series);
    }
    (above, through)
}

/// All of them.
pub fn all() -> Vec<Known> {
    vec![overlapping_plates(), touching_plates(), invisible_balls(), inside_nested_balls()]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::integrator::Settings;
    use crate::prepare::prepare;

    #[test]
    fn a_pile_of_one_plate_is_the_plate() {
        // Without absorption nothing is lost: R + T = 1.
        let sum = |(reflected, transmitted): (f64, f64)| reflected + transmitted;
        assert!((sum(pile(&[1.0, 1.5, 1.33, 1.0], &[0.0; 3])) - 1.0).abs() < 1e-12);
        let known = super::super::known::absorbing_slab();
        assert!((sum(pile(&[1.0, 1.5, 1.0], &[0.0, 0.7 * 0.2])) - known.radiance.x).abs() < 1e-12);
    }

    #[test]
    fn only_overlapping_bodies_nest() {
        let nests = |scene: &Scene| prepare(scene, &Settings::default()).unwrap().nests;
        assert!(all().iter().all(|k| nests(&k.scene)));
        assert!(!nests(&super::super::known::absorbing_slab().scene));
        let mut apart = narrow("apart", DVec3::Z * 9.0, DVec3::ZERO);
        place(&mut apart, "a", Shape::Sphere, sphere_at(DVec3::ZERO, 1.0), dielectric("a", 1.5, DVec3::ZERO, 0));
        place(&mut apart, "b", Shape::Sphere, sphere_at(DVec3::X * 2.5, 1.0), dielectric("b", 1.4, DVec3::ZERO, 0));
        assert!(!nests(&apart));
        let mut floor = dielectric("c", 1.5, DVec3::ZERO, 0);
        floor.emission = Some(Value::scalar(1.0));
        place(&mut apart, "shines", Shape::Sphere, sphere_at(DVec3::ZERO, 0.5), floor);
        assert!(!nests(&apart), "what shines bounds no nested medium");
    }
}
