//! Known answers for direct light: irradiance on a small patch with normal `n` at `p`, W/m2 a unit of radiance.
//!
//! Polygon: Lambert 1760, as in Baum et al. 1989, eq. 8 (edge integrals), cut at the horizon. Sphere above the horizon:
//! E = pi (R/d)^2 cos. Sky: quadrature over the sphere, written for any radiance function.

use std::f64::consts::PI;

use glam::DVec3;

/// Irradiance a unit radiance of a convex or simple planar polygon, both sides counted alike; cut at the plane of `n`.
pub fn polygon_irradiance(p: DVec3, n: DVec3, polygon: &[DVec3]) -> f64 {
    let above = clip_to_horizon(p, n, polygon);
    let directions: Vec<DVec3> = above.iter().filter_map(|v| (v - p).try_normalize()).collect();
    let mut sum = DVec3::ZERO;
    for (i, &a) in directions.iter().enumerate() {
        let b = directions[(i + 1) % directions.len()];
        let normal = a.cross(b);
        let sin = normal.length();
        let factor = if sin > 0.0 { sin.atan2(a.dot(b)) / sin } else { 0.0 };
        sum += normal * factor;
    }
    0.5 * sum.dot(n).abs()
}

/// Sutherland and Hodgman 1974 against one plane.
fn clip_to_horizon(p: DVec3, n: DVec3, polygon: &[DVec3]) -> Vec<DVec3> {
    let mut out = Vec::new();
    for (i, &a) in polygon.iter().enumerate() {
        let b = polygon[(i + 1) % polygon.len()];
        let (ha, hb) = ((a - p).dot(n), (b - p).dot(n));
        if ha >= 0.0 {
            out.push(a);
        }
        if (ha >= 0.0) != (hb >= 0.0) {
            out.push(a + (b - a) * (ha / (ha - hb)));
        }
    }
    out
}

/// Irradiance a unit radiance of a sphere that is wholly above the horizon; None when it is not, or `p` is inside.
pub fn sphere_irradiance(p: DVec3, n: DVec3, center: DVec3, radius: f64) -> Option<f64> {
    let to_center = center - p;
    let d = to_center.length();
    (d > radius && to_center.dot(n) >= radius).then(|| PI * (radius / d).powi(2) * to_center.dot(n) / d)
}

/// Irradiance under a sky: midpoint rule on `rows` x 2 `rows` cells of equal solid angle per row about the y axis.
pub fn sky_irradiance(n: DVec3, rows: usize, radiance: impl Fn(DVec3) -> DVec3) -> DVec3 {
    sphere_quadrature(rows, |d| radiance(d) * d.dot(n).max(0.0))
}

/// Integral of `f` over the sphere.
pub fn sphere_quadrature(rows: usize, f: impl Fn(DVec3) -> DVec3) -> DVec3 {
    let columns = 2 * rows;
    let mut sum = DVec3::ZERO;
    for j in 0..rows {
        let theta = PI * (j as f64 + 0.5) / rows as f64;
        let (sin_theta, cos_theta) = theta.sin_cos();
        let mut line = DVec3::ZERO;
        for i in 0..columns {
            let (sin_phi, cos_phi) = (2.0 * PI * (i as f64 + 0.5) / columns as f64).sin_cos();
            line += f(DVec3::new(sin_theta * sin_phi, cos_theta, -sin_theta * cos_phi));
        }
        // The row's exact solid angle over its cells.
        sum += line * (4.0 * PI / columns as f64 * sin_theta * (0.5 * PI / rows as f64).sin());
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_huge_floor_fills_the_hemisphere() {
        let s = 1e6;
        let square = [DVec3::new(-s, -s, 1.0), DVec3::new(s, -s, 1.0), DVec3::new(s, s, 1.0), DVec3::new(-s, s, 1.0)];
        assert!((polygon_irradiance(DVec3::ZERO, DVec3::Z, &square) / PI - 1.0).abs() < 1e-9);
        // Standing on its edge plane, half of it counts.
        assert!((polygon_irradiance(DVec3::ZERO, DVec3::X, &square) / (0.5 * PI) - 1.0).abs() < 1e-5);
    }

    #[test]
    fn a_parallel_rectangle_has_its_form_factor() {
        // Unit square over a patch below its corner, distance 1 (Hottel): E = pi F = x/sqrt(1+x^2) atan(x/sqrt(1+x^2)), x = 1.
        let square = [
            DVec3::new(0.0, 0.0, 1.0),
            DVec3::new(1.0, 0.0, 1.0),
            DVec3::new(1.0, 1.0, 1.0),
            DVec3::new(0.0, 1.0, 1.0),
        ];
        let exact = 0.5f64.sqrt() * 0.5f64.sqrt().atan();
        assert!((polygon_irradiance(DVec3::ZERO, DVec3::Z, &square) - exact).abs() < 1e-12);
    }

    #[test]
    fn a_uniform_sky_gives_pi() {
        let e = sky_irradiance(DVec3::new(0.6, 0.0, 0.8), 512, |_| DVec3::ONE);
        assert!((e.x / PI - 1.0).abs() < 1e-5, "{e}");
    }
}
