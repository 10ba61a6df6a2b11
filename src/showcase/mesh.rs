//! Meshes: surfaces of revolution, a torus knot, a flat rectangle. Front = outside, counter-clockwise.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use super::profile::Profile;

/// Vertex arrays with 16-bit indices.
#[derive(Default)]
pub struct Mesh {
    pub positions: Vec<[f32; 3]>,
    pub normals: Vec<[f32; 3]>,
    pub uvs: Vec<[f32; 2]>,
    pub triangles: Vec<[u16; 3]>,
    /// False: nothing looks the surface's texture coordinates up, so they are not stored.
    pub keeps_uvs: bool,
}

/// Rounded to 2^-16: the last bits of sine and cosine differ between platforms.
fn fixed(v: f64) -> f32 {
    ((v * 65536.0).round() / 65536.0) as f32
}

impl Mesh {
    fn push(&mut self, position: DVec3, normal: DVec3, uv: DVec2) {
        self.positions.push(position.to_array().map(fixed));
        self.normals.push(normal.normalize_or(DVec3::Y).to_array().map(fixed));
        self.uvs.push(uv.to_array().map(fixed));
    }

    /// Joins `rows` x `columns` vertices that begin at `first`; triangles without area are left out.
    fn join_grid(&mut self, first: usize, rows: usize, columns: usize) {
        for row in 0..rows - 1 {
            for column in 0..columns - 1 {
                let corner = |r: usize, c: usize| (first + (row + r) * columns + column + c) as u16;
                for triangle in [[corner(0, 0), corner(0, 1), corner(1, 1)], [corner(0, 0), corner(1, 1), corner(1, 0)]]
                {
                    let [a, b, c] = triangle.map(|i| self.positions[i as usize]);
                    if a != b && b != c && c != a {
                        self.triangles.push(triangle);
                    }
                }
            }
        }
    }

    pub fn with_uvs(mut self) -> Self {
        self.keeps_uvs = true;
        self
    }

    pub fn bounds(&self) -> ([f32; 3], [f32; 3]) {
        let fold = |from: f32, pick: fn(f32, f32) -> f32| {
            self.positions.iter().fold([from; 3], |b, p| std::array::from_fn(|k| pick(b[k], p[k])))
        };
        (fold(f32::INFINITY, f32::min), fold(f32::NEG_INFINITY, f32::max))
    }
}

/// `profile` turned about +y. u runs once around times `u_repeats`, v along the profile from its start to its end.
pub fn revolve(profile: &Profile, segments: usize, u_repeats: f64) -> Mesh {
    let mut mesh = Mesh::default();
    for piece in profile.pieces() {
        let first = mesh.positions.len();
        for point in &piece {
            for segment in 0..=segments {
                // The seam's two columns stand at the same place: the angle 0 itself, not 2 pi.
                let angle = TAU * (segment % segments) as f64 / segments as f64;
                let (sin, cos) = angle.sin_cos();
                let around = |radial: f64, y: f64| DVec3::new(radial * sin, y, radial * cos);
                let u = u_repeats * segment as f64 / segments as f64;
                mesh.push(
                    around(point.position.x, point.position.y),
                    around(point.normal.x, point.normal.y),
                    DVec2::new(u, point.v),
                );
            }
        }
        mesh.join_grid(first, piece.len(), segments + 1);
    }
    mesh
}

/// The (2, 3) torus knot about +y with a round tube; its frame by parallel transport, closed by an even twist.
pub fn torus_knot(scale: f64, tube: f64, steps: usize, sides: usize) -> Mesh {
    let center = |k: usize| {
        let t = TAU * (k % steps) as f64 / steps as f64;
        let ring = 2.0 + (3.0 * t).cos();
        DVec3::new(ring * (2.0 * t).cos(), (3.0 * t).sin() * 1.15, ring * (2.0 * t).sin()) * (scale / 3.0)
    };
    let tangent = |k: usize| (center(k + 1) - center(k + steps - 1)).normalize();
    let mut sides_of = vec![tangent(0).any_orthonormal_vector()];
    for k in 1..=steps {
        let previous = sides_of[k - 1];
        sides_of.push((previous - tangent(k) * previous.dot(tangent(k))).normalize());
    }
    // What transport around the whole loop is short of, taken back evenly.
    let (start, end) = (sides_of[0], sides_of[steps]);
    let twist = end.cross(start).dot(tangent(0)).atan2(end.dot(start));
    let mut mesh = Mesh::default();
    for (k, side) in sides_of.iter().enumerate() {
        let other = tangent(k).cross(*side);
        for j in 0..=sides {
            let angle = TAU * (j % sides) as f64 / sides as f64 + twist * k as f64 / steps as f64;
            let normal = *side * angle.cos() + other * angle.sin();
            mesh.push(center(k) + normal * tube, normal, DVec2::new(k as f64 / steps as f64, j as f64 / sides as f64));
        }
    }
    mesh.join_grid(0, steps + 1, sides + 1);
    mesh
}

/// A square in the plane y = 0 that looks up, `half` to each side, with `repeats` of the texture across.
pub fn floor(half: f64, repeats: f64) -> Mesh {
    let mut mesh = Mesh::default();
    for (x, z) in [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)] {
        let uv = DVec2::new(x + 1.0, z + 1.0) * (0.5 * repeats);
        mesh.push(DVec3::new(x * half, 0.0, z * half), DVec3::Y, uv);
    }
    mesh.triangles = vec![[0, 2, 3], [0, 3, 1]];
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every triangle's winding agrees with its vertex normals, and a closed surface holds a positive volume.
    #[test]
    fn fronts_look_outwards() {
        let s = std::f64::consts::FRAC_1_SQRT_2;
        let ball = Profile::new().curve(&[(0.0, -1.0), (s, -s), (1.0, 0.0), (s, s), (0.0, 1.0)], 9);
        for (name, mesh) in
            [("ball", revolve(&ball, 16, 1.0)), ("knot", torus_knot(1.0, 0.1, 64, 8)), ("floor", floor(2.0, 1.0))]
        {
            let at = |i: u16| DVec3::from(mesh.positions[i as usize].map(f64::from));
            let mut volume = 0.0;
            for &[a, b, c] in &mesh.triangles {
                let area = (at(b) - at(a)).cross(at(c) - at(a));
                let normal: DVec3 =
                    [a, b, c].iter().map(|&i| DVec3::from(mesh.normals[i as usize].map(f64::from))).sum();
                assert!(area.dot(normal) > 0.0, "{name}: {a} {b} {c}");
                volume += at(a).dot(at(b).cross(at(c))) / 6.0;
            }
            assert!(name == "floor" || volume > 0.1, "{name}: {volume}");
        }
    }
}
