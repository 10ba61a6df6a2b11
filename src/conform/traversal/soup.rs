//! Geometry that is hard on a traversal, and rays to match. All generated, with fixed seeds.

use std::f32::consts::TAU;

use glam::{DVec3, Vec3};

use crate::bvh::traverse::{Geometry, Ray};
use crate::bvh::{self, Bvh, Disc};
use crate::prepare::records::{DiscRecord, SphereRecord, TriangleRecord};

type Triangles = Vec<[[f32; 3]; 3]>;
type Spheres = Vec<([f32; 3], f32)>;
type Discs = Vec<Disc>;

/// Unordered primitives of each kind.
#[derive(Default)]
pub struct Soup {
    triangles: Triangles,
    spheres: Spheres,
    discs: Discs,
}

/// Primitives in leaf order with their tree.
pub struct Mesh {
    bvh: Bvh,
    triangles: Vec<TriangleRecord>,
    spheres: Vec<SphereRecord>,
    discs: Vec<DiscRecord>,
}

impl Mesh {
    /// Face numbers count the triangles, spheres go on from there, and discs after them.
    pub fn of(Soup { triangles, spheres, discs }: Soup) -> Mesh {
        let primitives =
            bvh::Primitives { triangles: &triangles, spheres: &spheres, discs: &discs, ..Default::default() };
        let (bvh, _) = bvh::build(&primitives).expect("a gate's mesh is small");
        let triangle = |&i: &u32| {
            let [v0, v1, v2] = triangles[i as usize];
            TriangleRecord { v0, v1, v2, face: i, ..Default::default() }
        };
        let sphere = |&i: &u32| {
            let (center, radius) = spheres[i as usize];
            SphereRecord { center, radius, primitive: triangles.len() as u32 + i, ..Default::default() }
        };
        let disc = |&i: &u32| {
            let Disc { center, normal, radius } = discs[i as usize];
            let primitive = (triangles.len() + spheres.len()) as u32 + i;
            DiscRecord { center, radius, normal, primitive, handedness: 1.0, ..Default::default() }
        };
        Mesh {
            triangles: bvh.triangle_order.iter().map(triangle).collect(),
            spheres: bvh.sphere_order.iter().map(sphere).collect(),
            discs: bvh.disc_order.iter().map(disc).collect(),
            bvh,
        }
    }

    pub fn geometry(&self) -> Geometry<'_> {
        Geometry {
            bvh: &self.bvh,
            triangles: &self.triangles,
            spheres: &self.spheres,
            discs: &self.discs,
            instances: &[],
        }
    }
}

/// SplitMix64 (Steele, Lea, Flood 2014): small, and independent of the renderer's samplers.
pub struct Random(pub u64);

impl Random {
    fn word(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ z >> 31
    }

    pub fn unit(&mut self) -> f32 {
        (self.word() >> 40) as f32 / 16_777_216.0
    }

    fn below(&mut self, count: usize) -> usize {
        (self.word() % count as u64) as usize
    }

    /// In [-1, 1]^3.
    pub fn cube(&mut self) -> Vec3 {
        Vec3::new(self.unit(), self.unit(), self.unit()) * 2.0 - 1.0
    }

    fn direction(&mut self) -> Vec3 {
        loop {
            let v = self.cube();
            if v.length_squared() > 0.01 && v.length_squared() < 1.0 {
                return v.normalize();
            }
        }
    }
}

fn random_triangles(count: usize, size: f32, scale: f32, offset: f32) -> Triangles {
    let mut random = Random(count as u64);
    (0..count)
        .map(|_| {
            let center = random.cube();
            [0; 3].map(|_| ((center + size * random.cube()) * scale + Vec3::splat(offset)).to_array())
        })
        .collect()
}

fn random_spheres(count: usize, size: f32, scale: f32, offset: f32) -> Spheres {
    let mut random = Random(count as u64 + 7);
    let mut sphere =
        || ((random.cube() * scale + Vec3::splat(offset)).to_array(), (0.1 + random.unit()) * size * scale);
    (0..count).map(|_| sphere()).collect()
}

/// Half of them in a plane across an axis, so that their boxes are flat.
fn random_discs(count: usize, size: f32, scale: f32, offset: f32) -> Discs {
    let mut random = Random(count as u64 + 13);
    let mut disc = |i: usize| {
        let axes = [Vec3::X, Vec3::NEG_Y, Vec3::Z];
        let normal = if i.is_multiple_of(2) { random.direction() } else { axes[random.below(3)] };
        let center = (random.cube() * scale + Vec3::splat(offset)).to_array();
        Disc { center, normal: normal.to_array(), radius: (0.1 + random.unit()) * size * scale }
    };
    (0..count).map(&mut disc).collect()
}

/// Slivers, copies, axis-parallel and unusable triangles among ordinary ones.
fn degenerate() -> Soup {
    let mut random = Random(99);
    let mut t = random_triangles(200, 0.2, 1.0, 0.0);
    for _ in 0..100 {
        let (a, d) = (random.cube(), random.direction());
        t.push([a, a + d, a + d * 0.5 + random.cube() * 1e-5].map(|v| v.to_array()));
        t.push([a, a + d, a + d * 2.0].map(|v| v.to_array()));
        t.push([a; 3].map(|v| v.to_array()));
        let axis = random.below(3);
        let flat = [random.cube(), random.cube(), random.cube()].map(|mut v| {
            v[axis] = 0.25;
            v.to_array()
        });
        t.extend([flat, flat]);
    }
    t.push([[f32::NAN, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    t.push([[1e30, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    t.push([[f32::INFINITY, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    let spheres = vec![([0.0; 3], f32::NAN), ([0.1; 3], 0.0), ([0.2; 3], 0.2)];
    // Two discs in one place, one that reaches into the other's plane only, and one without a radius.
    let disc = |normal: [f32; 3], radius: f32| Disc { center: [0.3; 3], normal, radius };
    let up = [0.0, 1.0, 0.0];
    let discs = vec![disc(up, 0.4), disc(up, 0.4), disc([1.0, 0.0, 0.0], 0.3), disc(up, 0.0), disc([0.0; 3], 1.0)];
    Soup { triangles: t, spheres, discs }
}

/// `counts` of triangles, spheres and discs, within `scale` of `offset`.
fn mixed(counts: [usize; 3], scale: f32, offset: f32) -> Soup {
    Soup {
        triangles: random_triangles(counts[0], 0.2, scale, offset),
        spheres: random_spheres(counts[1], 0.1, scale, offset),
        discs: random_discs(counts[2], 0.2, scale, offset),
    }
}

pub const SOUPS: &[(&str, fn() -> Soup)] = &[
    ("random", || mixed([700, 0, 0], 1.0, 0.0)),
    ("long triangles", || only(random_triangles(300, 1.5, 1.0, 0.0))),
    ("degenerate", degenerate),
    ("tiny 1e-6", || mixed([700, 50, 50], 1e-6, 0.0)),
    ("huge 1e6", || mixed([700, 50, 50], 1e6, 0.0)),
    ("far off 1e6", || mixed([700, 50, 50], 10.0, 1e6)),
    ("spheres", || mixed([0, 600, 0], 1.0, 0.0)),
    ("discs", || mixed([0, 0, 600], 1.0, 0.0)),
    ("all kinds", || mixed([400, 400, 200], 1.0, 0.0)),
];

fn only(triangles: Triangles) -> Soup {
    Soup { triangles, ..Soup::default() }
}

/// Scale and offset of the closed meshes.
pub const PLACES: &[(&str, f32, f32)] =
    &[("of size 1", 1.0, 0.0), ("of 1e-6", 1e-6, 0.0), ("of 1e6", 1e6, 0.0), ("at 1e4", 1.0, 1e4)];

/// Triangles from 2^-100 to 2^20 in size around one point: SAH peels them off one by one, and the depth bound must hold.
pub fn geometric() -> Mesh {
    let mut random = Random(41);
    let triangle = |i: usize| [0; 3].map(|_| (random.cube() * 1.5f32.powi(i as i32 % 200 - 170)).to_array());
    Mesh::of(only((0..1000).map(triangle).collect()))
}

pub fn quad() -> Mesh {
    let [a, b, c, d] = [[-5.0, -5.0, 0.0], [5.0, -5.0, 0.0], [5.0, 5.0, 0.0], [-5.0, 5.0, 0.0]];
    Mesh::of(only(vec![[a, b, c], [a, c, d]]))
}

/// 60 triangles, each there three times.
pub fn stack_of_copies() -> Mesh {
    let mut t = random_triangles(60, 0.7, 1.0, 0.0);
    t.extend_from_within(..);
    t.extend_from_within(..60);
    Mesh::of(only(t))
}

pub fn spawn_scene(scale: f32, offset: f32) -> Mesh {
    Mesh::of(Soup {
        triangles: random_triangles(150, 1.0, scale, offset),
        spheres: random_spheres(60, 0.15, scale, offset),
        discs: random_discs(80, 0.4, scale, offset),
    })
}

/// Octahedron divided `levels` times, with a radius that varies, so that no edge function is 0 by symmetry alone.
pub fn closed_sphere(levels: u32, scale: f32, offset: f32) -> Mesh {
    let mut faces: Vec<[Vec3; 3]> = (0..8)
        .map(|k: u32| {
            let sign = |bit: u32| if k >> bit & 1 == 0 { 1.0 } else { -1.0 };
            [Vec3::X * sign(0), Vec3::Y * sign(1), Vec3::Z * sign(2)]
        })
        .collect();
    for _ in 0..levels {
        faces = faces
            .iter()
            .flat_map(|&[a, b, c]| {
                let [ab, bc, ca] = [a + b, b + c, c + a].map(|v| v.normalize());
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
    }
    let place = |v: Vec3| (v * (1.0 + 0.2 * (7.0 * v.x).sin() * (5.0 * v.y).cos()) * scale + offset).to_array();
    Mesh::of(only(faces.iter().map(|f| f.map(place)).collect()))
}

/// Torus of n by m quads, each cut in two.
pub fn closed_torus(n: usize, m: usize, scale: f32, offset: f32) -> Mesh {
    let vertex = |i: usize, j: usize| {
        let (u, v) = ((i % n) as f32 / n as f32 * TAU, (j % m) as f32 / m as f32 * TAU);
        let r = 1.0 + 0.4 * v.cos();
        (Vec3::new(r * u.cos(), 0.4 * v.sin(), r * u.sin()) * scale + offset).to_array()
    };
    let quad = |k: usize| {
        let (i, j) = (k / m, k % m);
        let [a, b, c, d] = [vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)];
        [[a, b, c], [a, c, d]]
    };
    Mesh::of(only((0..n * m).flat_map(quad).collect()))
}

fn bounds(g: &Geometry) -> (Vec3, Vec3) {
    let (mut lo, mut hi) = (Vec3::MAX, Vec3::MIN);
    let mut grow = |p: Vec3| (lo, hi) = (lo.min(p), hi.max(p));
    g.triangles.iter().flat_map(|t| [t.v0, t.v1, t.v2]).for_each(|v| grow(Vec3::from(v)));
    for s in g.spheres {
        grow(Vec3::from(s.center) - s.radius);
        grow(Vec3::from(s.center) + s.radius);
    }
    for d in g.discs {
        grow(Vec3::from(d.center) - d.radius);
        grow(Vec3::from(d.center) + d.radius);
    }
    if lo.x > hi.x { (Vec3::splat(-1.0), Vec3::ONE) } else { (lo, hi) }
}

fn ray(o: Vec3, d: Vec3) -> Ray {
    Ray { o: o.to_array(), d: d.to_array(), t_max: f32::INFINITY }
}

/// From around, inside and far away; along axes; from points of the primitives' own planes; a quarter of them short.
pub fn rays(mesh: &Mesh, count: usize, random: &mut Random) -> Vec<Ray> {
    let g = mesh.geometry();
    let corners: Vec<Vec3> = g.triangles.iter().flat_map(|t| [t.v0, t.v1, t.v2].map(Vec3::from)).collect();
    rays_about(bounds(&g), &corners, count, random)
}

/// The same about vertices in the world.
pub fn around(vertices: &[DVec3], count: usize, random: &mut Random) -> Vec<Ray> {
    let corners: Vec<Vec3> = vertices.iter().map(|v| v.as_vec3()).collect();
    let bounds = corners.iter().fold((Vec3::MAX, Vec3::MIN), |(lo, hi), &v| (lo.min(v), hi.max(v)));
    rays_about(bounds, &corners, count, random)
}

fn rays_about((lo, hi): (Vec3, Vec3), corners: &[Vec3], count: usize, random: &mut Random) -> Vec<Ray> {
    let (center, half) = ((lo + hi) * 0.5, (hi - lo) * 0.5);
    let corner = |random: &mut Random| match corners.len() {
        0 => center + half * random.cube(),
        n => corners[random.below(n)],
    };
    (0..count)
        .map(|i| {
            let inside = center + half * random.cube();
            let mut r = match i % 8 {
                0 | 1 => ray(inside, random.direction()),
                2 => {
                    let o = center + 3.0 * half.max_element() * random.direction();
                    ray(o, (inside - o).normalize_or(Vec3::X))
                }
                3 => {
                    let o = center + 50.0 * half.max_element() * random.direction();
                    ray(o, (inside - o).normalize_or(Vec3::X))
                }
                4 => {
                    let mut d = Vec3::ZERO;
                    d[random.below(3)] = if random.unit() < 0.5 { -1.0 } else { 1.0 };
                    ray(inside, d)
                }
                5 => {
                    // Starts level with a vertex, so that it runs along the faces of boxes.
                    let (axis, mut o) = (random.below(3), inside);
                    let mut d = random.direction();
                    o[axis] = corner(random)[axis];
                    d[axis] = if random.unit() < 0.5 { 0.0 } else { -0.0 };
                    ray(o, d.normalize_or(Vec3::X))
                }
                _ => {
                    let o = center + 2.0 * half * random.cube();
                    ray(o, (corner(random) - o).normalize_or(Vec3::X))
                }
            };
            if i % 4 == 3 {
                r.t_max = half.max_element() * 2.0 * random.unit();
            }
            r
        })
        .collect()
}

/// Rays from inside a closed mesh (from a point of a torus's circle, or a sphere's middle) at each vertex and at three points of
/// each edge, and beside each by an ulp of the direction.
pub fn aimed_rays(mesh: &Mesh, random: &mut Random) -> Vec<Ray> {
    let g = mesh.geometry();
    let (lo, hi) = bounds(&g);
    let center = (lo + hi) * 0.5;
    // Flat in y: a torus, whose inside is around its circle of radius 1/1.4 of the half width.
    let is_torus = (hi.y - lo.y) < 0.5 * (hi.x - lo.x);
    let mut rays = Vec::new();
    for t in g.triangles {
        let v = [t.v0, t.v1, t.v2].map(|v| Vec3::from(v).as_dvec3());
        let mut origin = center + (hi - lo) * 0.02 * random.cube();
        if is_torus {
            let u = random.unit() * TAU;
            origin = center + Vec3::new(u.cos(), 0.01 * random.unit(), u.sin()) * (hi.x - lo.x) * (0.5 / 1.4);
        }
        rays.extend(aimed_at(origin, v, random));
    }
    rays
}

/// From `origin` at the corners of a triangle and at three points of each edge, and beside each.
pub fn aimed_at(origin: Vec3, v: [DVec3; 3], random: &mut Random) -> Vec<Ray> {
    let mut rays = Vec::new();
    for k in 0..3 {
        let (a, b) = (v[k], v[(k + 1) % 3]);
        for s in [0.0, 0.5, f64::from(random.unit()), f64::from(random.unit()) * 1e-6] {
            let aim = a + (b - a) * s - origin.as_dvec3();
            let d = aim.normalize().as_vec3();
            rays.push(ray(origin, d));
            let nudge = Vec3::new(1.0, -1.0, 1.0) * f32::EPSILON * d * random.cube();
            rays.push(ray(origin, d + nudge));
        }
    }
    rays
}
