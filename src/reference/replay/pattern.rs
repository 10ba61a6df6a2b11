//! Patterns evaluated over `material_data` in f64, and textures over the packed texels.

use glam::DVec2;

use super::Replay;
use crate::prepare::pattern::Node;
use crate::prepare::records::*;
use crate::texture;

/// What a pattern can read at a surface point.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    pub uvs: [DVec2; 2],
    pub color: [f64; 4],
    /// Of the ray's footprint in units of each uv squared; 0: at a point.
    pub areas: [f64; 2],
}

impl Default for Point {
    fn default() -> Self {
        Self { uvs: [DVec2::ZERO; 2], color: [1.0; 4], areas: [0.0; 2] }
    }
}

impl Replay {
    /// RGBA of output `output` of structure `pattern`, whose constants start at row `data`.
    pub(super) fn evaluate(&self, pattern: u32, data: u32, point: &Point, output: usize) -> [f64; 4] {
        self.node(&self.prepared.structures[pattern as usize].outputs[output], data, point)
    }

    /// Probability that the surface is there.
    pub(super) fn alpha(&self, material: &MaterialRecord, point: &Point) -> f64 {
        if material.flags & (MATERIAL_MASK | MATERIAL_BLEND) == 0 {
            return 1.0;
        }
        let alpha = self.evaluate(material.alpha_pattern, material.alpha_data, point, 0)[0];
        if material.flags & MATERIAL_MASK == 0 {
            return alpha;
        }
        f64::from(u8::from(alpha >= f64::from(material.alpha_cutoff)))
    }

    fn row(&self, at: u32) -> [f64; 4] {
        self.prepared.material_data[at as usize].map(|word| f64::from(f32::from_bits(word)))
    }

    fn uv(&self, at: u32, uv_set: u8, is_transformed: bool, point: &Point) -> DVec2 {
        let uv = point.uvs[usize::from(uv_set)];
        if !is_transformed {
            return uv;
        }
        let (shift, m) = (self.row(at), self.row(at + 1));
        DVec2::new(m[0] * uv.x + m[1] * uv.y + shift[1], m[2] * uv.x + m[3] * uv.y + shift[2])
    }

    fn node(&self, node: &Node, data: u32, point: &Point) -> [f64; 4] {
        match node {
            Node::Constant { row } => self.row(data + row),
            Node::VertexColor => point.color,
            Node::Multiply(a, b) => {
                let (a, b) = (self.node(a, data, point), self.node(b, data, point));
                [0, 1, 2, 3].map(|c| a[c] * b[c])
            }
            Node::Share(a) => [self.node(a, data, point)[0].clamp(0.0, 1.0); 4],
            Node::Rest(a) => [1.0 - self.node(a, data, point)[0].clamp(0.0, 1.0); 4],
            Node::Channel(a, channel) => [self.node(a, data, point)[usize::from(*channel)]; 4],
            Node::Checker { row, texture_row, uv_set, is_transformed } => {
                let uv = self.uv(data + texture_row, *uv_set, *is_transformed, point);
                let scale = self.row(data + row + 2);
                let square = (uv.x * scale[0]).floor() + (uv.y * scale[1]).floor();
                self.row(data + row + u32::from(square.rem_euclid(2.0) != 0.0))
            }
            Node::Image { row, uv_set, is_transformed } => {
                let uv = self.uv(data + row, *uv_set, *is_transformed, point);
                let id = self.prepared.material_data[(data + row) as usize][0];
                let m = self.row(data + row + u32::from(*is_transformed));
                let scale = if *is_transformed { (m[0] * m[3] - m[1] * m[2]).abs() } else { 1.0 };
                let area = point.areas[usize::from(*uv_set)] * scale;
                let record = &self.prepared.textures[id as usize];
                texture::mip::lookup_footprint(record, &self.prepared.texels, uv, area).to_array()
            }
        }
    }
}
