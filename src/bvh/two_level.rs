//! Two levels: each mesh that is placed several times has one tree in its own space, and one above holds the placements' boxes.
//!
//! A placement's box is that of its mesh's root, moved in f64, and grown by what the rounding of a ray does. The traversal takes the
//! ray into object space, o' = B o + t, d' = B d, in f32; so it tests a world ray beside the true one, by at most
//! |A| (gamma_5 (|B| |o| + |t|) + s gamma_4 |B| |d|) at the distance s, where A is the inverse of B (Higham 2002, "Accuracy and Stability
//! of Numerical Algorithms", Section 3.1; the fifth rounding is that of the matrix itself). Unlike in the test of a box, that is no
//! relative error of each coordinate, so it cannot be in the box test's slack. `reach` bounds |o|: rays begin inside the scene or at
//! the camera, which is the origin. Inside a mesh all triangles see the very same ray, so a closed mesh stays closed.
//! Tests below, and gate 5 (src/conform/traversal.rs).

use glam::{DAffine3, DMat3, DVec3};
use rayon::prelude::*;

use super::{BuildReport, Bvh, Error, LEAF_BIT, MAX_PRIMITIVES, Node4, Primitives};
use super::{LEAF_FIRST_MASK, build};

/// A mesh in the world. `to_world` is what the record holds, in f64.
#[derive(Clone, Copy, Debug)]
pub struct Placement {
    /// Row of the meshes given to `build_two_level`.
    pub mesh: u32,
    pub to_world: DAffine3,
}

type Triangle = [[f32; 3]; 3];

/// 2^-24: half an ulp of 1.
const EPS: f64 = 1.0 / 16_777_216.0;

/// The tree over `flat` and the placed meshes. Triangles are numbered through: the flat ones, then each mesh's. `flat.instances`
/// must be empty. Errors: more primitives than leaf words can number.
pub fn build_two_level(
    flat: &Primitives,
    meshes: &[&[Triangle]],
    placed: &[Placement],
) -> Result<(Bvh, BuildReport), Error> {
    let built = build_two_level_unchecked(flat, meshes, placed)?;
    #[cfg(debug_assertions)]
    {
        let all: Vec<Triangle> = flat.triangles.iter().chain(meshes.iter().copied().flatten()).copied().collect();
        let primitives = Primitives { triangles: &all, instances: &built.2, ..*flat };
        if let Err(broken) = super::validate::validate(&built.0, &primitives, &built.1) {
            panic!("the two-level tree just built is not valid: {broken}");
        }
    }
    Ok((built.0, built.1))
}

/// The tree, the report, and the placements' boxes, without the validation that debug assertions add: what the bench times.
pub fn build_two_level_unchecked(
    flat: &Primitives,
    meshes: &[&[Triangle]],
    placed: &[Placement],
) -> Result<(Bvh, BuildReport, Vec<[[f32; 3]; 2]>), Error> {
    let triangle_count = flat.triangles.len() + meshes.iter().map(|m| m.len()).sum::<usize>();
    for count in [triangle_count, placed.len() + 1] {
        if count > MAX_PRIMITIVES {
            return Err(Error::TooManyPrimitives { count });
        }
    }
    let built = meshes.par_iter().map(|&triangles| {
        let mesh = Primitives { triangles, ..Primitives::default() };
        build::build_unchecked(&mesh)
    });
    let built: Vec<(Bvh, BuildReport)> = built.collect::<Result<_, Error>>()?;
    let boxes = boxes(flat, &built.iter().map(|(bvh, _)| bvh.bounds_below(0)).collect::<Vec<_>>(), placed);
    let (mut bvh, mut report) = build::build_unchecked(&Primitives { instances: &boxes, ..*flat })?;
    let mut first_input = flat.triangles.len() as u32;
    for ((mesh, dropped), triangles) in built.into_iter().zip(meshes) {
        append(&mut bvh, mesh, first_input);
        first_input += triangles.len() as u32;
        report.zero_area += dropped.zero_area;
        report.non_finite += dropped.non_finite;
        report.out_of_range += dropped.out_of_range;
    }
    Ok((bvh, report, boxes))
}

/// Puts a mesh's tree behind the others; its triangles have the input numbers from `first_input` on.
fn append(bvh: &mut Bvh, mesh: Bvh, first_input: u32) {
    let root = bvh.nodes.len() as u32;
    let first = bvh.triangle_order.len() as u32;
    let moved = |word: u32| match word {
        0 => 0,
        leaf if leaf & LEAF_BIT != 0 => leaf & !LEAF_FIRST_MASK | ((leaf & LEAF_FIRST_MASK) + first),
        inner => inner + root,
    };
    bvh.nodes.extend(mesh.nodes.iter().map(|n| Node4 { child: n.child.map(moved), ..*n }));
    bvh.triangle_order.extend(mesh.triangle_order.iter().map(|i| i + first_input));
    bvh.roots.push(root);
    bvh.first_triangles.push(first);
    bvh.mesh_depth = bvh.mesh_depth.max(mesh.depth);
}

/// World boxes of the placements, grown by the error of a ray from anywhere in the scene.
fn boxes(flat: &Primitives, meshes: &[[DVec3; 2]], placed: &[Placement]) -> Vec<[[f32; 3]; 2]> {
    let exact: Vec<[DVec3; 2]> = placed.par_iter().map(|p| world_box(&p.to_world, meshes[p.mesh as usize])).collect();
    let reach =
        exact.iter().flatten().filter(|v| v.is_finite()).fold(flat_reach(flat), |r, v| r.max(v.abs().max_element()));
    let grow = |(p, [lo, hi]): (&Placement, &[DVec3; 2])| {
        let error = ray_error(&p.to_world, reach);
        let round = |v: DVec3, towards: fn(f32) -> f32| v.as_vec3().to_array().map(towards);
        [round(*lo - error, f32::next_down), round(*hi + error, f32::next_up)]
    };
    placed.par_iter().zip(&exact).map(grow).collect()
}

/// The box of a moved box (Arvo 1990, "Transforming axis-aligned bounding boxes", Graphics Gems).
pub fn world_box(to_world: &DAffine3, [lo, hi]: [DVec3; 2]) -> [DVec3; 2] {
    if lo.x > hi.x {
        return [DVec3::INFINITY, DVec3::NEG_INFINITY];
    }
    let center = to_world.transform_point3(0.5 * (lo + hi));
    let half = magnitudes(&to_world.matrix3) * (0.5 * (hi - lo));
    [center - half, center + half]
}

/// How far beside the true ray, by component, one from within `reach` of the origin may be tested; see the head of this page.
fn ray_error(to_world: &DAffine3, reach: f64) -> DVec3 {
    let to_object = to_world.inverse();
    // 5 of |o|, which is up to 2 reach in a view that is not from one point, and 4 of a distance of up to 2 sqrt(3) reach in a
    // direction of components up to 1: 24 in all.
    let in_object = magnitudes(&to_object.matrix3) * DVec3::splat(24.0 * reach) + 5.0 * to_object.translation.abs();
    EPS * (magnitudes(&to_world.matrix3) * in_object)
}

/// |m|, entry by entry.
pub fn magnitudes(m: &DMat3) -> DMat3 {
    DMat3::from_cols(m.x_axis.abs(), m.y_axis.abs(), m.z_axis.abs())
}

/// Largest coordinate of what is not placed.
fn flat_reach(flat: &Primitives) -> f64 {
    let usable = |v: f32| if v.is_finite() && v.abs() <= super::MAX_COORDINATE { v.abs() } else { 0.0 };
    let largest = |v: &[f32; 3], r: f32| usable(v[0]).max(usable(v[1])).max(usable(v[2])) + usable(r);
    let triangles = flat.triangles.par_iter().flatten().map(|v| largest(v, 0.0)).reduce(|| 0.0, f32::max);
    let spheres = flat.spheres.iter().map(|(c, r)| largest(c, *r)).fold(0.0, f32::max);
    let discs = flat.discs.iter().map(|d| largest(&d.center, d.radius)).fold(0.0, f32::max);
    f64::from(triangles.max(spheres).max(discs))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DQuat;

    fn tetrahedron() -> Vec<Triangle> {
        let v = [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0f32]];
        [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]].map(|t: [usize; 3]| t.map(|i| v[i])).to_vec()
    }

    fn spread(count: usize) -> Vec<Placement> {
        let at = |i: usize| {
            let x = i as f64;
            let scale = DVec3::new(0.3 + 0.1 * (x % 7.0), 0.5, if i.is_multiple_of(2) { 0.4 } else { -0.4 });
            let turn = DQuat::from_rotation_y(x) * DQuat::from_rotation_x(0.7 * x);
            let place = DVec3::new(x % 17.0, (0.37 * x).sin(), (x / 17.0).floor());
            Placement { mesh: (i % 2) as u32, to_world: DAffine3::from_scale_rotation_translation(scale, turn, place) }
        };
        (0..count).map(at).collect()
    }

    // Each build is validated by `build_two_level` itself, under debug assertions.

    #[test]
    fn both_levels_are_valid_and_boxes_hold_their_meshes() {
        let floor = [[[-9.0, -2.0, -9.0], [9.0, -2.0, -9.0], [0.0, -2.0, 9.0f32]]];
        let big: Vec<Triangle> = tetrahedron().iter().map(|t| t.map(|v| v.map(|c| 3.0 * c))).collect();
        let meshes = [tetrahedron(), big];
        let placed = spread(500);
        let flat = Primitives { triangles: &floor, ..Primitives::default() };
        let (bvh, report) = build_two_level(&flat, &[&meshes[0], &meshes[1]], &placed).unwrap();
        assert_eq!((bvh.flat_triangle_count(), bvh.first_triangles.clone()), (1, vec![1, 5]));
        assert_eq!((report.dropped(), bvh.instance_order.len(), bvh.roots.len()), (0, 500, 2));
        let roots: Vec<_> = meshes
            .iter()
            .map(|m| {
                let (mesh, _) = build::build(&Primitives { triangles: m, ..Primitives::default() }).unwrap();
                mesh.bounds_below(0)
            })
            .collect();
        for (p, [lo, hi]) in placed.iter().zip(boxes(&flat, &roots, &placed)) {
            for v in meshes[p.mesh as usize].iter().flatten() {
                let v = p.to_world.transform_point3(DVec3::from(v.map(f64::from)));
                assert!((0..3).all(|k| f64::from(lo[k]) < v[k] && v[k] < f64::from(hi[k])), "{v} in {lo:?} {hi:?}");
            }
        }
    }

    #[test]
    fn a_placed_mesh_without_a_usable_triangle_is_dropped() {
        let point: Vec<Triangle> = vec![[[1.0; 3]; 3]; 3];
        let good = tetrahedron();
        let (bvh, report) = build_two_level(&Primitives::default(), &[&point, &good], &spread(4)).unwrap();
        assert_eq!((report.zero_area, bvh.instance_order.len()), (3 + 2, 2));
    }

    #[test]
    fn as_many_at_one_place_as_one_likes() {
        let same = Placement { mesh: 0, to_world: DAffine3::IDENTITY };
        let (bvh, _) = build_two_level(&Primitives::default(), &[&tetrahedron()], &[same; 5000]).unwrap();
        assert!(bvh.depth <= 3 * 5000u32.ilog2() + 10);
        assert_eq!(bvh.stack_size(), 3 * bvh.depth + 2 + 3 * bvh.mesh_depth + 1);
    }
}
