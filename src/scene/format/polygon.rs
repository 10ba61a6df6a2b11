//! Faces of any number of corners as triangles: a fan where the face is convex, else ears are cut off one by one.
//!
//! The face is looked at along its Newell normal (Sutherland, Sproull and Schumacker 1974), so that it need not be flat. Ears
//! after Meisters 1975; a corner is an ear when it turns the face's way and no reflex corner lies in its triangle. A face
//! that crosses itself has no answer: it is cut up all the same, and holds each corner.

use glam::{DVec2, DVec3};

/// Corners of the largest face that is read; ears of one so large take a second.
pub const MAX_CORNERS: usize = 4096;

/// Triangles as places in `corners` (3 or more), in the winding of the face.
pub fn triangulate(corners: &[[f32; 3]]) -> Vec<[usize; 3]> {
    let n = corners.len();
    let fan = || (1..n - 1).map(|k| [0, k, k + 1]).collect();
    if n <= 3 {
        return fan();
    }
    let p: Vec<DVec2> = seen_along_normal(corners);
    let turn = |a: usize, b: usize, c: usize| (p[b] - p[a]).perp_dot(p[c] - p[b]);
    if (0..n).all(|k| turn(k, (k + 1) % n, (k + 2) % n) >= 0.0) {
        return fan();
    }
    let mut left: Vec<usize> = (0..n).collect();
    let mut triangles = Vec::with_capacity(n - 2);
    let mut at = 0;
    let mut tried = 0;
    while left.len() > 3 {
        let m = left.len();
        let [a, b, c] = [left[at % m], left[(at + 1) % m], left[(at + 2) % m]];
        let is_inside = |q: DVec2| {
            [(a, b), (b, c), (c, a)].iter().all(|&(s, e)| (p[e] - p[s]).perp_dot(q - p[s]) >= 0.0)
                && q != p[a]
                && q != p[b]
                && q != p[c]
        };
        let is_ear = turn(a, b, c) > 0.0 && !left.iter().any(|&k| k != a && k != b && k != c && is_inside(p[k]));
        // After a whole round without an ear any corner will do: the face crosses itself, or is a line.
        if is_ear || tried >= m {
            triangles.push([a, b, c]);
            left.remove((at + 1) % m);
            tried = 0;
            // The next ear is sought beside the last, which would otherwise fan out from one corner.
            at = if (at + 1) % m == 0 { at % m } else { (at + 1) % left.len() };
        } else {
            tried += 1;
            at = (at + 1) % m;
        }
    }
    triangles.push([left[0], left[1], left[2]]);
    triangles
}

/// The corners in a plane across the Newell normal, counter-clockwise; the normal's smallest component is dropped no more than
/// needed: two axes orthogonal to it span the plane.
fn seen_along_normal(corners: &[[f32; 3]]) -> Vec<DVec2> {
    let at = |k: usize| DVec3::from(corners[k % corners.len()].map(f64::from)) - DVec3::from(corners[0].map(f64::from));
    let normal: DVec3 = (0..corners.len()).map(|k| at(k).cross(at(k + 1))).sum();
    let normal = normal.try_normalize().unwrap_or(DVec3::Z);
    let x = normal.any_orthonormal_vector();
    let y = normal.cross(x);
    (0..corners.len()).map(|k| DVec2::new(at(k).dot(x), at(k).dot(y))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(corners: &[[f32; 3]], triangles: &[[usize; 3]]) -> f64 {
        let at = |k: usize| DVec3::from(corners[k].map(f64::from));
        triangles.iter().map(|t| 0.5 * (at(t[1]) - at(t[0])).cross(at(t[2]) - at(t[0])).z).sum()
    }

    #[test]
    fn areas_add_up_and_no_triangle_is_turned_over() {
        let square: Vec<[f32; 3]> = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        let arrow = vec![[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.5, 0.5, 0.0], [0.0, 2.0, 0.0]];
        // A comb of 40 teeth, and a star whose every second corner is reflex.
        let mut comb: Vec<[f32; 3]> = vec![[40.0, 5.0, 0.0], [0.0, 5.0, 0.0]];
        comb.extend((0..40).flat_map(|k| [[k as f32, 0.0, 0.0], [k as f32 + 0.5, 4.0, 0.0]]));
        let star: Vec<[f32; 3]> = (0..100)
            .map(|k| {
                let (sin, cos) = (std::f32::consts::TAU * k as f32 / 100.0).sin_cos();
                let r = if k % 2 == 0 { 1.0 } else { 0.3 };
                [r * cos, r * sin, 0.0]
            })
            .collect();
        for face in [square, arrow, comb, star] {
            let triangles = triangulate(&face);
            assert_eq!(triangles.len(), face.len() - 2);
            let fan: Vec<[usize; 3]> = (1..face.len() - 1).map(|k| [0, k, k + 1]).collect();
            let (found, wanted) = (area(&face, &triangles), area(&face, &fan));
            assert!((found - wanted).abs() < 1e-5 * wanted, "{found} {wanted}");
            assert!(triangles.iter().all(|t| area(&face, &[*t]) > -1e-9), "{} corners", face.len());
        }
    }

    #[test]
    fn nothing_that_is_no_face_hangs() {
        let mut random = 1u32;
        let mut unit = || {
            random = random.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
            (random >> 8) as f32 / 16_777_216.0
        };
        for n in [4, 5, 17, 300] {
            let crossing: Vec<[f32; 3]> = (0..n).map(|_| [unit(), unit(), unit()]).collect();
            let line: Vec<[f32; 3]> = (0..n).map(|k| [(k * 7 % 5) as f32, 0.0, 0.0]).collect();
            for face in [crossing, line, vec![[1.0; 3]; n], vec![[f32::NAN; 3]; n]] {
                let triangles = triangulate(&face);
                assert_eq!(triangles.len(), n - 2);
                assert!(triangles.iter().flatten().all(|&k| k < n));
            }
        }
    }
}
