//! Maps from [0,1)^2 to discs, directions and triangles, each with its density and its inverse.
//! GLSL: shaders/core/warp.glsl; gate 3 compares the two.

use std::f64::consts::{FRAC_1_PI, FRAC_PI_2, FRAC_PI_4, TAU};

use glam::{DVec2, DVec3};

/// Concentric map of the unit square to the unit disk (Shirley and Chiu 1997), the two-case form of Cline. Density 1/pi.
pub fn concentric_disk(u: [f64; 2]) -> DVec2 {
    let a = 2.0 * u[0] - 1.0;
    let b = 2.0 * u[1] - 1.0;
    if a == 0.0 && b == 0.0 {
        return DVec2::ZERO;
    }
    let (r, phi) = if a.abs() > b.abs() { (a, FRAC_PI_4 * (b / a)) } else { (b, FRAC_PI_2 - FRAC_PI_4 * (a / b)) };
    DVec2::new(r * phi.cos(), r * phi.sin())
}

pub fn concentric_disk_inverse(d: DVec2) -> [f64; 2] {
    let is_wide = d.x.abs() > d.y.abs();
    let (major, minor) = if is_wide { (d.x, d.y) } else { (d.y, d.x) };
    // The angle from the nearest half axis, in [-pi/4, pi/4], is linear in the square's other coordinate.
    let a = d.length().copysign(major);
    let b = if major == 0.0 { 0.0 } else { a * (minor / major).atan() / FRAC_PI_4 };
    if is_wide { [0.5 + 0.5 * a, 0.5 + 0.5 * b] } else { [0.5 + 0.5 * b, 0.5 + 0.5 * a] }
}

/// Direction about +z with density cos(theta)/pi (Malley's method).
pub fn cosine_hemisphere(u: [f64; 2]) -> DVec3 {
    let d = concentric_disk(u);
    DVec3::new(d.x, d.y, (1.0 - d.length_squared()).max(0.0).sqrt())
}

pub fn cosine_hemisphere_pdf(cos_theta: f64) -> f64 {
    cos_theta.max(0.0) * FRAC_1_PI
}

pub fn cosine_hemisphere_inverse(d: DVec3) -> [f64; 2] {
    concentric_disk_inverse(d.truncate())
}

/// Direction of height z whose angle about +z is `turn` of a full turn.
fn direction(z: f64, turn: f64) -> DVec3 {
    let radius = ((1.0 - z) * (1.0 + z)).max(0.0).sqrt();
    let (sin, cos) = (TAU * turn).sin_cos();
    DVec3::new(radius * cos, radius * sin, z)
}

/// Angle about +z as a fraction of a turn, in [0,1).
fn turn_of(d: DVec3) -> f64 {
    (d.y.atan2(d.x) / TAU).rem_euclid(1.0)
}

/// z = 1 - u[0], never 0 for u < 1.
pub fn uniform_hemisphere(u: [f64; 2]) -> DVec3 {
    direction(1.0 - u[0], u[1])
}

pub fn uniform_hemisphere_pdf(cos_theta: f64) -> f64 {
    if cos_theta > 0.0 { 1.0 / TAU } else { 0.0 }
}

pub fn uniform_hemisphere_inverse(d: DVec3) -> [f64; 2] {
    [1.0 - d.z, turn_of(d)]
}

pub fn uniform_sphere(u: [f64; 2]) -> DVec3 {
    direction(1.0 - 2.0 * u[0], u[1])
}

pub fn uniform_sphere_pdf() -> f64 {
    0.5 / TAU
}

pub fn uniform_sphere_inverse(d: DVec3) -> [f64; 2] {
    [0.5 - 0.5 * d.z, turn_of(d)]
}

/// Directions within a cone about +z; `one_minus_cos` is that of its half angle.
pub fn uniform_cone(u: [f64; 2], one_minus_cos: f64) -> DVec3 {
    let h = u[0] * one_minus_cos;
    // sin^2 = h (2 - h): from z alone a cone of the Sun's size would lose half of the digits.
    let radius = (h * (2.0 - h)).max(0.0).sqrt();
    let (sin, cos) = (TAU * u[1]).sin_cos();
    DVec3::new(radius * cos, radius * sin, 1.0 - h)
}

pub fn uniform_cone_pdf(one_minus_cos: f64) -> f64 {
    1.0 / (TAU * one_minus_cos)
}

pub fn uniform_cone_inverse(d: DVec3, one_minus_cos: f64) -> [f64; 2] {
    let h = if d.z > 0.0 { d.truncate().length_squared() / (1.0 + d.z) } else { 1.0 - d.z };
    [h / one_minus_cos, turn_of(d)]
}

/// Barycentric weights of vertices 1 and 2, uniform over the triangle (Heitz 2019, "A Low-Distortion Map Between Triangle and
/// Square"). Density 1/area.
pub fn uniform_triangle(u: [f64; 2]) -> [f64; 2] {
    if u[1] > u[0] { [0.5 * u[0], u[1] - 0.5 * u[0]] } else { [u[0] - 0.5 * u[1], 0.5 * u[1]] }
}

pub fn uniform_triangle_inverse(b: [f64; 2]) -> [f64; 2] {
    if b[1] > b[0] { [2.0 * b[0], b[1] + b[0]] } else { [b[0] + b[1], 2.0 * b[1]] }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CONE: f64 = 1e-5;

    fn grid(n: u32) -> impl Iterator<Item = [f64; 2]> {
        let at = move |i: u32| (f64::from(i) + 0.5) / f64::from(n);
        (0..n).flat_map(move |i| (0..n).map(move |j| [at(i), at(j)]))
    }

    #[test]
    fn inverses_return_the_numbers() {
        type There = fn([f64; 2]) -> [f64; 2];
        let rows: [(&str, There); 6] = [
            ("disk", |u| concentric_disk_inverse(concentric_disk(u))),
            ("cosine hemisphere", |u| cosine_hemisphere_inverse(cosine_hemisphere(u))),
            ("uniform hemisphere", |u| uniform_hemisphere_inverse(uniform_hemisphere(u))),
            ("uniform sphere", |u| uniform_sphere_inverse(uniform_sphere(u))),
            ("uniform cone", |u| uniform_cone_inverse(uniform_cone(u, CONE), CONE)),
            ("triangle", |u| uniform_triangle_inverse(uniform_triangle(u))),
        ];
        for (name, there_and_back) in rows {
            for u in grid(64) {
                let v = there_and_back(u);
                assert!((v[0] - u[0]).abs() < 1e-9 && (v[1] - u[1]).abs() < 1e-9, "{name}: {u:?} came back as {v:?}");
            }
        }
    }

    /// The area a small square of u covers is its area / pdf: the density is the warp's, not only normalised.
    #[test]
    fn densities_are_those_of_the_maps() {
        type Warp = fn([f64; 2]) -> DVec3;
        type Pdf = fn(DVec3) -> f64;
        let rows: [(&str, Warp, Pdf); 4] = [
            ("cosine hemisphere", cosine_hemisphere, |d| cosine_hemisphere_pdf(d.z)),
            ("uniform hemisphere", uniform_hemisphere, |d| uniform_hemisphere_pdf(d.z)),
            ("uniform sphere", uniform_sphere, |_| uniform_sphere_pdf()),
            ("uniform cone", |u| uniform_cone(u, 0.3), |_| uniform_cone_pdf(0.3)),
        ];
        let h = 1e-5;
        for (name, warp, pdf) in rows {
            for u in grid(33) {
                // The concentric map has creases on its diagonals.
                if name == "cosine hemisphere" && (u[0] - u[1]).abs().min((u[0] + u[1] - 1.0).abs()) < 1e-3 {
                    continue;
                }
                let dx = (warp([u[0] + h, u[1]]) - warp([u[0] - h, u[1]])) / (2.0 * h);
                let dy = (warp([u[0], u[1] + h]) - warp([u[0], u[1] - h])) / (2.0 * h);
                let measured = 1.0 / dx.cross(dy).length();
                let stated = pdf(warp(u));
                assert!((measured / stated - 1.0).abs() < 1e-4, "{name} at {u:?}: {measured} against {stated}");
            }
        }
    }

    #[test]
    fn densities_integrate_to_one() {
        let n = 2000;
        let over_z = |z0: f64, pdf: &dyn Fn(f64) -> f64| -> f64 {
            (0..n).map(|i| z0 + (1.0 - z0) * (f64::from(i) + 0.5) / f64::from(n)).map(|z| TAU * pdf(z)).sum::<f64>()
                * (1.0 - z0)
                / f64::from(n)
        };
        assert!((over_z(-1.0, &cosine_hemisphere_pdf) - 1.0).abs() < 1e-6);
        assert!((over_z(-1.0, &uniform_hemisphere_pdf) - 1.0).abs() < 1e-6);
        assert!((over_z(-1.0, &|_| uniform_sphere_pdf()) - 1.0).abs() < 1e-9);
        assert!((over_z(1.0 - CONE, &|_| uniform_cone_pdf(CONE)) - 1.0).abs() < 1e-9);
    }

    #[test]
    fn triangles_are_covered_evenly() {
        // Mean of both weights is 1/3, and of their product 1/12.
        let n = 256;
        let mean = |f: fn([f64; 2]) -> f64| grid(n).map(|u| f(uniform_triangle(u))).sum::<f64>() / f64::from(n * n);
        assert!((mean(|b| b[0]) - 1.0 / 3.0).abs() < 1e-4);
        assert!((mean(|b| b[1]) - 1.0 / 3.0).abs() < 1e-4);
        assert!((mean(|b| b[0] * b[1]) - 1.0 / 12.0).abs() < 1e-4);
        assert!(grid(n).map(uniform_triangle).all(|b| b[0] >= 0.0 && b[1] >= 0.0 && b[0] + b[1] <= 1.0));
    }
}
