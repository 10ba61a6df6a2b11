//! The oracle's tree against brute force, on shared edges, and leaving a sphere.

use super::*;

/// Numbers in [-1, 1) from a counter (splitmix64), enough for test geometry.
fn noise(counter: &mut u64) -> f64 {
    *counter = counter.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut z = *counter;
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}

fn vector(counter: &mut u64) -> DVec3 {
    DVec3::new(noise(counter), noise(counter), noise(counter))
}

#[test]
fn closest_and_any_agree_with_brute_force() {
    let mut c = 1;
    let shapes: Vec<(u32, Shape)> = (0..500)
        .map(|i| {
            let center = vector(&mut c);
            let shape = match i % 5 {
                0 => Shape::Sphere { center, radius: 0.05 + 0.05 * noise(&mut c).abs() },
                1 => Shape::Disc { center, normal: vector(&mut c).normalize(), radius: 0.2 * noise(&mut c).abs() },
                _ => Shape::Triangle([0; 3].map(|_| center + 0.2 * vector(&mut c))),
            };
            (i, shape)
        })
        .collect();
    let tree = Tree::build(shapes.clone());
    for i in 0..2000 {
        let mut ray = free_ray(2.0 * vector(&mut c), vector(&mut c).normalize());
        ray.ignores = i % 500;
        let mut all: Vec<Hit> = Vec::new();
        for (number, shape) in &shapes {
            if *number != ray.ignores {
                Stored::new(*number, *shape).intersect(&ray, f64::INFINITY, |hit| all.push(hit));
            }
        }
        all.sort_by(|a, b| (a.t, a.primitive).partial_cmp(&(b.t, b.primitive)).unwrap());
        let mut last = None;
        for expected in &all {
            let found = tree.closest(&ray, last.as_ref(), f64::INFINITY);
            assert_eq!(found, Some(*expected), "ray {i}");
            last = found;
        }
        assert_eq!(tree.closest(&ray, last.as_ref(), f64::INFINITY), None, "ray {i}");
        let t = all.first().map_or(1.0, |h| h.t);
        assert!(!tree.any(&ray, t, |_| true));
        assert_eq!(tree.any(&ray, f64::INFINITY, |_| true), !all.is_empty());
    }
}

#[test]
fn rays_through_shared_edges_are_caught() {
    // A fan around the origin of the plane; rays aim exactly at points of the shared edges.
    let rim = |i: u32| {
        let (s, c) = (std::f64::consts::TAU * f64::from(i) / 7.0).sin_cos();
        DVec3::new(c, s, 0.1 * c)
    };
    let fan = (0..7).map(|i| (i, Shape::Triangle([DVec3::ZERO, rim(i), rim((i + 1) % 7)]))).collect();
    let tree = Tree::build(fan);
    let mut c = 5;
    for i in 0..70_000u32 {
        let origin = vector(&mut c) + DVec3::Z * 3.0;
        let target = rim(i % 7) * (0.999 * noise(&mut c).abs());
        let ray = free_ray(origin, (target - origin).normalize());
        assert!(tree.closest(&ray, None, f64::INFINITY).is_some(), "ray {i} from {origin} to {target}");
    }
}

#[test]
fn a_ray_leaving_a_sphere_meets_its_far_side_only() {
    let tree = Tree::build(vec![(7, Shape::Sphere { center: DVec3::ZERO, radius: 1e-3 })]);
    let origin = DVec3::X * 1e-3;
    let inward = Ray { leaves: 7, ..free_ray(origin, DVec3::NEG_X) };
    assert_eq!(tree.closest(&inward, None, f64::INFINITY).map(|h| h.t), Some(2e-3));
    let outward = Ray { leaves: 7, ..free_ray(origin, DVec3::new(1e-9, 1.0, 0.0).normalize()) };
    assert_eq!(tree.closest(&outward, None, f64::INFINITY), None);
}
