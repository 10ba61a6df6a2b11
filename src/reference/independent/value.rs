//! Attributes and value expressions at a surface point, from the scene's own arrays.
//!
//! Normals go through the inverse transpose, tangents through the matrix (Turkowski 1990, "Transformations of surface
//! normal vectors"). Images: texel centres at (i + 0.5)/size, row 0 at v = 0, decoded (IEC 61966-2-1) before they are
//! filtered; alpha is never encoded.

use glam::{DAffine3, DMat3, DVec2, DVec3};

use super::Independent;
use crate::scene::{Encoding, Image, Mesh, Pixels, Texture, Value, Wrap};

/// A place on a surface, and what values can read there.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    pub position: DVec3,
    pub geometric_normal: DVec3,
    pub normal: DVec3,
    pub tangent: Option<(DVec3, f64)>,
    pub uvs: [DVec2; 2],
    pub color: [f64; 4],
    /// Of the ray's footprint in units of each uv squared; 0: at a point.
    pub areas: [f64; 2],
}

impl Point {
    /// Flat, without texture coordinates or tangent.
    pub fn on(position: DVec3, normal: DVec3) -> Self {
        Self {
            position,
            geometric_normal: normal,
            normal,
            tangent: None,
            uvs: [DVec2::ZERO; 2],
            color: [1.0; 4],
            areas: [0.0; 2],
        }
    }
}

/// Writes into `point` what the vertices of triangle `part` carry.
pub fn interpolate(mesh: &Mesh, part: usize, weights: [f64; 3], to_world: &DAffine3, point: &mut Point) {
    let corners = mesh.triangles[part].map(|i| i as usize);
    let matrix = to_world.matrix3;
    if let Some(normals) = &mesh.normals {
        // Each vertex normal is unit in the world before it is interpolated, as a baked mesh would have it.
        let to_normal = cofactor(matrix);
        let normal: DVec3 = (0..3)
            .map(|k| weights[k] * (to_normal * DVec3::from(normals[corners[k]].map(f64::from))).normalize_or_zero())
            .sum();
        point.normal = normal.try_normalize().unwrap_or(point.geometric_normal);
    }
    if let Some(tangents) = &mesh.tangents {
        let tangent: DVec3 = (0..3)
            .map(|k| {
                let t = tangents[corners[k]].map(f64::from);
                weights[k] * (matrix * DVec3::new(t[0], t[1], t[2])).normalize_or_zero()
            })
            .sum();
        let mirror = if matrix.determinant() < 0.0 { -1.0 } else { 1.0 };
        point.tangent = Some((tangent, mirror * f64::from(tangents[corners[0]][3])));
    }
    for (uv, stored) in point.uvs.iter_mut().zip(&mesh.uvs) {
        if let Some(stored) = stored {
            *uv = (0..3).map(|k| weights[k] * DVec2::from(stored[corners[k]].map(f64::from))).sum();
        }
    }
    if let Some(colors) = &mesh.colors {
        point.color = [0, 1, 2, 3].map(|c| (0..3).map(|k| weights[k] * f64::from(colors[corners[k]][c])).sum());
    }
}

/// Inverse transpose times |determinant|: it exists for singular matrices, and keeps the front of mirrored ones in front.
fn cofactor(m: DMat3) -> DMat3 {
    let c = DMat3::from_cols(m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis));
    if m.determinant() < 0.0 { -c } else { c }
}

impl Independent<'_> {
    /// RGBA of an expression at a point.
    pub(super) fn evaluate(&self, value: &Value, point: &Point) -> [f64; 4] {
        match value {
            Value::Constant(c) => *c,
            // Curves are resolved by the model that reads them; a curve elsewhere shows its mean.
            Value::Curve(curve) => [curve.value.iter().sum::<f64>() / curve.value.len().max(1) as f64; 4],
            Value::Texture { texture, uv_set, uv_transform } => {
                let set = usize::from(*uv_set).min(1);
                let uv = uv_transform.transform_point2(point.uvs[set]);
                match &self.scene.textures[*texture] {
                    Texture::Constant(c) => *c,
                    Texture::Checker { a, b, scale } => {
                        let square = (uv.x * scale[0]).floor() + (uv.y * scale[1]).floor();
                        if square.rem_euclid(2.0) == 0.0 { *a } else { *b }
                    }
                    Texture::Image { .. } => {
                        let area = point.areas[set] * uv_transform.matrix2.determinant().abs();
                        self.footprint(*texture, uv, area)
                    }
                }
            }
            Value::VertexColor => point.color,
            Value::Multiply(a, b) => {
                let (a, b) = (self.evaluate(a, point), self.evaluate(b, point));
                [0, 1, 2, 3].map(|c| a[c] * b[c])
            }
            Value::Share(a) => [self.evaluate(a, point)[0].clamp(0.0, 1.0); 4],
            Value::Rest(a) => [1.0 - self.evaluate(a, point)[0].clamp(0.0, 1.0); 4],
            Value::Channel(a, channel) => [self.evaluate(a, point)[usize::from(*channel).min(3)]; 4],
        }
    }
}

/// Weighted mean of the four texels around (x, y), in texels with centres at half-integers.
pub fn bilinear(x: f64, y: f64, fetch: impl Fn(f64, f64) -> [f64; 4]) -> [f64; 4] {
    let (i, j) = ((x - 0.5).floor(), (y - 0.5).floor());
    let (fx, fy) = (x - 0.5 - i, y - 0.5 - j);
    let corners = [fetch(i, j), fetch(i + 1.0, j), fetch(i, j + 1.0), fetch(i + 1.0, j + 1.0)];
    let weights = [(1.0 - fx) * (1.0 - fy), fx * (1.0 - fy), (1.0 - fx) * fy, fx * fy];
    [0, 1, 2, 3].map(|c| (0..4).map(|k| weights[k] * corners[k][c]).sum())
}

/// Texel number inside the image.
pub(super) fn wrapped(wrap: Wrap, i: f64, size: u32) -> u32 {
    let n = f64::from(size);
    let i = match wrap {
        Wrap::Repeat => i.rem_euclid(n),
        Wrap::Clamp => i.clamp(0.0, n - 1.0),
        Wrap::Mirror => {
            let folded = i.rem_euclid(2.0 * n);
            if folded < n { folded } else { 2.0 * n - 1.0 - folded }
        }
    };
    (i as u32).min(size - 1)
}

pub(super) fn texel(image: &Image, encoding: Encoding, x: u32, y: u32) -> [f64; 4] {
    let at = y as usize * image.width as usize + x as usize;
    let linear = |c: [f64; 4]| match encoding {
        Encoding::Linear => c,
        Encoding::Srgb => [decoded(c[0]), decoded(c[1]), decoded(c[2]), c[3]],
    };
    match &image.pixels {
        Pixels::RgbF32(p) => [f64::from(p[3 * at]), f64::from(p[3 * at + 1]), f64::from(p[3 * at + 2]), 1.0],
        Pixels::Rgba8(p) => linear([0, 1, 2, 3].map(|k| f64::from(p[4 * at + k]) / 255.0)),
        Pixels::Rgba16(p) => linear([0, 1, 2, 3].map(|k| f64::from(p[4 * at + k]) / 65535.0)),
    }
}

/// Linear value of an sRGB-encoded one (IEC 61966-2-1).
fn decoded(c: f64) -> f64 {
    if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
}
