//! Rays, shapes, and where the two meet, in f64.
//!
//! Triangles by signed volumes (Pluecker coordinates; Davidovic, Hachisuka and Slusallek 2012): the edge functions of two
//! triangles that share an edge are exactly opposite in IEEE arithmetic, so rays do not slip between them. Spheres by the
//! quadratic whose discriminant is taken from the distance of the centre to the ray (Haines et al., Ray Tracing Gems 2019,
//! ch. 7), discs by the plane and the distance from the centre. A plane cannot be hit again from itself; a sphere can be hit only on
//! its far side, and only when the ray goes inside.

use glam::{DVec2, DVec3};

use super::build::Bounds;
use crate::prepare::records::NONE;

/// Half-line. Primitives are named by number.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    pub origin: DVec3,
    /// Unit length.
    pub direction: DVec3,
    /// The primitive `origin` lies on, or NONE.
    pub leaves: u32,
    /// A primitive the ray passes through unseen (the light that a shadow ray aims at), or NONE.
    pub ignores: u32,
    /// Diameter of its cone at the origin, m, and growth a metre.
    pub cone: DVec2,
}

impl Ray {
    pub fn at(&self, t: f64) -> DVec3 {
        self.origin + t * self.direction
    }
}

/// Where a ray meets a primitive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    pub t: f64,
    pub primitive: u32,
    /// Triangle: weights of vertices 1 and 2. Sphere, disc: 0.
    pub barycentric: [f64; 2],
    /// The ray leaves a sphere here.
    pub is_far: bool,
}

#[derive(Clone, Copy, Debug)]
pub enum Shape {
    Triangle([DVec3; 3]),
    Sphere {
        center: DVec3,
        radius: f64,
    },
    /// `normal` is unit.
    Disc {
        center: DVec3,
        normal: DVec3,
        radius: f64,
    },
}

/// Ray from the origin of nothing in particular: no primitive left, none ignored.
pub fn free_ray(origin: DVec3, direction: DVec3) -> Ray {
    Ray { origin, direction, leaves: NONE, ignores: NONE, cone: DVec2::ZERO }
}

impl Shape {
    pub(in crate::reference) fn bounds(&self) -> Bounds {
        match self {
            Self::Triangle(v) => Bounds { min: v[0].min(v[1]).min(v[2]), max: v[0].max(v[1]).max(v[2]) },
            Self::Sphere { center, radius } => Bounds { min: center - *radius, max: center + *radius },
            Self::Disc { center, normal, radius } => {
                // 1e-12 of the radius covers the rounding of 1 - n^2 near 0.
                let half = *radius * ((DVec3::ONE - normal * normal).max(DVec3::ZERO).map(f64::sqrt) + 1e-12);
                Bounds { min: center - half, max: center + half }
            }
        }
    }
}

/// A shape as the leaves hold it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stored {
    pub number: u32,
    shape: Shape,
    /// Of a triangle, not unit: from edges, because the signed volumes lose digits for small far triangles.
    normal: DVec3,
}

impl Stored {
    pub fn new(number: u32, shape: Shape) -> Self {
        let normal = match shape {
            Shape::Triangle(v) => (v[1] - v[0]).cross(v[2] - v[0]),
            Shape::Sphere { .. } | Shape::Disc { .. } => DVec3::ZERO,
        };
        Self { number, shape, normal }
    }

    /// Calls `found` with each hit in 0 < t <= t_max.
    #[inline(always)]
    pub fn intersect(&self, ray: &Ray, t_max: f64, mut found: impl FnMut(Hit)) {
        let leaves = self.number == ray.leaves;
        match &self.shape {
            Shape::Triangle(v) => {
                // The plane first: most candidates fail there.
                let t = self.normal.dot(v[0] - ray.origin) / self.normal.dot(ray.direction);
                if t > 0.0
                    && t <= t_max
                    && !leaves
                    && let Some(barycentric) = triangle(v, ray)
                {
                    found(Hit { t, primitive: self.number, barycentric, is_far: false });
                }
            }
            Shape::Sphere { center, radius } => {
                let [near, far] = sphere(*center, *radius, ray, leaves);
                for (t, is_far) in [(near, false), (far, true)] {
                    if t > 0.0 && t <= t_max {
                        found(Hit { t, primitive: self.number, barycentric: [0.0; 2], is_far });
                    }
                }
            }
            Shape::Disc { center, normal, radius } => {
                let t = (*center - ray.origin).dot(*normal) / ray.direction.dot(*normal);
                if t > 0.0 && t <= t_max && !leaves && ray.at(t).distance_squared(*center) <= radius * radius {
                    found(Hit { t, primitive: self.number, barycentric: [0.0; 2], is_far: false });
                }
            }
        }
    }
}

/// Weights of vertices 1 and 2 where the line of the ray passes inside.
#[inline(always)]
fn triangle(v: &[DVec3; 3], ray: &Ray) -> Option<[f64; 2]> {
    let [a, b, c] = [v[0] - ray.origin, v[1] - ray.origin, v[2] - ray.origin];
    let d = ray.direction;
    let weight_a = d.dot(c.cross(b));
    let weight_b = d.dot(a.cross(c));
    let weight_c = d.dot(b.cross(a));
    let is_inside = (weight_a >= 0.0 && weight_b >= 0.0 && weight_c >= 0.0)
        || (weight_a <= 0.0 && weight_b <= 0.0 && weight_c <= 0.0);
    let sum = weight_a + weight_b + weight_c;
    (is_inside && sum != 0.0).then(|| [weight_b / sum, weight_c / sum])
}

/// Both distances, NaN for what is not there.
fn sphere(center: DVec3, radius: f64, ray: &Ray, leaves: bool) -> [f64; 2] {
    let to_center = center - ray.origin;
    let along = to_center.dot(ray.direction);
    if leaves {
        // The other root of a ray that starts on the sphere; going outward it is negative.
        return [f64::NAN, 2.0 * along];
    }
    let across = to_center - along * ray.direction;
    // NaN for a ray that passes by.
    let half = (radius * radius - across.length_squared()).sqrt();
    [along - half, along + half]
}
