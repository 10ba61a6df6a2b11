//! Patterns: a material's value expressions compiled to one GLSL function per distinct structure.
//!
//! A structure is the expression with its numbers taken out; the numbers (constants, texture rows, uv transforms) are rows of
//! `material_data`, so that a thousand materials of the same shape share one function. Equal texture look-ups inside a
//! material are fetched once. `Structure` keeps the tree that `evaluate` in the replay oracle walks over the same rows.
//! Rows: constant = 4 f32; texture = (row of `textures`, f32 tx, f32 ty, -) and, when not the identity, (m00, m01, m10, m11) with
//! uv' = M uv + t; checker = a, b, (scale x, scale y, -, -).

use std::collections::HashMap;

use glam::DAffine2;

use crate::scene::{Texture, Value};

/// An expression without its numbers: `row` counts from the material's first data row.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Node {
    Constant { row: u32 },
    Image { row: u32, uv_set: u8, is_transformed: bool },
    Checker { row: u32, texture_row: u32, uv_set: u8, is_transformed: bool },
    VertexColor,
    Multiply(Box<Node>, Box<Node>),
    Channel(Box<Node>, u8),
    Share(Box<Node>),
    Rest(Box<Node>),
}

/// What a function's results are for.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Role {
    /// Inputs of the model with this number.
    Bsdf(usize),
    /// For each model of a mixture its inputs, then its share.
    Mix(Vec<usize>),
    Emission,
    Alpha,
    Normal,
}

/// One distinct shape of expressions: the trees of all outputs of the role.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Structure {
    pub role: Role,
    pub outputs: Vec<Node>,
}

/// All structures of a scene, and the rows of all materials.
#[derive(Clone, Debug, Default)]
pub struct Patterns {
    pub structures: Vec<Structure>,
    pub rows: Vec<[u32; 4]>,
    numbers: HashMap<Structure, u32>,
}

/// Resolves names of the scene while compiling.
pub struct Context<'a> {
    pub textures: &'a [Texture],
    /// Row of `textures` (the table) for each image texture of the scene.
    pub texture_rows: &'a [Option<u32>],
}

impl Patterns {
    /// Compiles `values`; returns (structure number, first data row).
    pub fn add(&mut self, role: Role, values: &[Value], context: &Context) -> (u32, u32) {
        let first = self.rows.len() as u32;
        let mut compiler = Compiler { rows: Vec::new(), seen: HashMap::new(), context };
        let outputs = values.iter().map(|v| compiler.node(v)).collect();
        self.rows.append(&mut compiler.rows);
        let structure = Structure { role, outputs };
        let next = self.structures.len() as u32;
        let number = *self.numbers.entry(structure.clone()).or_insert(next);
        if number == next {
            self.structures.push(structure);
        }
        (number, first)
    }
}

struct Compiler<'a> {
    rows: Vec<[u32; 4]>,
    /// Rows already written, so that equal look-ups and constants share them.
    seen: HashMap<Vec<[u32; 4]>, u32>,
    context: &'a Context<'a>,
}

impl Compiler<'_> {
    fn place(&mut self, rows: Vec<[u32; 4]>) -> u32 {
        let next = self.rows.len() as u32;
        let at = *self.seen.entry(rows.clone()).or_insert(next);
        if at == next {
            self.rows.extend(rows);
        }
        at
    }

    fn constant(&mut self, c: &[f64; 4]) -> Node {
        Node::Constant { row: self.place(vec![c.map(|x| (x as f32).to_bits())]) }
    }

    fn node(&mut self, value: &Value) -> Node {
        match value {
            Value::Constant(c) => self.constant(c),
            // `materials::resolve_curves` has replaced the curves of metals; elsewhere a curve shows its mean.
            Value::Curve(curve) => {
                self.constant(&[curve.value.iter().sum::<f64>() / curve.value.len().max(1) as f64; 4])
            }
            Value::VertexColor => Node::VertexColor,
            Value::Multiply(a, b) => Node::Multiply(Box::new(self.node(a)), Box::new(self.node(b))),
            Value::Channel(a, c) => Node::Channel(Box::new(self.node(a)), *c),
            Value::Share(a) => Node::Share(Box::new(self.node(a))),
            Value::Rest(a) => Node::Rest(Box::new(self.node(a))),
            Value::Texture { texture, uv_set, uv_transform } => self.texture(*texture, *uv_set, uv_transform),
        }
    }

    fn texture(&mut self, texture: usize, uv_set: u8, uv: &DAffine2) -> Node {
        let is_transformed = *uv != DAffine2::IDENTITY;
        let lookup_rows = |id: u32| {
            let t = [id, (uv.translation.x as f32).to_bits(), (uv.translation.y as f32).to_bits(), 0];
            let m = uv.matrix2;
            let matrix = [m.x_axis.x, m.y_axis.x, m.x_axis.y, m.y_axis.y].map(|x| (x as f32).to_bits());
            if is_transformed { vec![t, matrix] } else { vec![t] }
        };
        match &self.context.textures[texture] {
            Texture::Constant(c) => self.constant(c),
            Texture::Image { .. } => {
                let id = self.context.texture_rows[texture].expect("every image texture has a row");
                Node::Image { row: self.place(lookup_rows(id)), uv_set, is_transformed }
            }
            Texture::Checker { a, b, scale } => {
                let bits = |c: &[f64; 4]| c.map(|x| (x as f32).to_bits());
                let row = self.place(vec![bits(a), bits(b), bits(&[scale[0], scale[1], 0.0, 0.0])]);
                Node::Checker { row, texture_row: self.place(lookup_rows(0)), uv_set, is_transformed }
            }
        }
    }
}

impl Structure {
    /// (model, number among equal models) of each surface; empty for other roles.
    pub fn lobes(&self) -> Vec<(usize, usize)> {
        match &self.role {
            Role::Bsdf(model) => vec![(*model, 0)],
            Role::Mix(models) => {
                let before = |k: usize| models[..k].iter().filter(|m| **m == models[k]).count();
                models.iter().enumerate().map(|(k, m)| (*m, before(k))).collect()
            }
            _ => Vec::new(),
        }
    }

    /// GLSL statements (`vec4 vN = ...;`) and the name of each output's variable. `data` and `point` are in scope.
    /// With footprints, what shades reads them; emission and presence are looked up at a point (texture/mip.rs).
    pub fn glsl(&self, has_footprints: bool) -> (String, Vec<String>) {
        let has_footprints = has_footprints && matches!(self.role, Role::Bsdf(_) | Role::Mix(_) | Role::Normal);
        let mut writer = Writer { text: String::new(), names: HashMap::new(), has_footprints };
        let outputs = self.outputs.iter().map(|n| writer.name(n)).collect();
        (writer.text, outputs)
    }

    pub fn visit(&self, f: &mut impl FnMut(&Node)) {
        fn walk(n: &Node, f: &mut impl FnMut(&Node)) {
            f(n);
            match n {
                Node::Multiply(a, b) => {
                    walk(a, f);
                    walk(b, f);
                }
                Node::Channel(a, _) | Node::Share(a) | Node::Rest(a) => walk(a, f),
                _ => {}
            }
        }
        self.outputs.iter().for_each(|n| walk(n, f));
    }
}

struct Writer {
    text: String,
    names: HashMap<Node, String>,
    has_footprints: bool,
}

impl Writer {
    fn name(&mut self, node: &Node) -> String {
        if let Some(name) = self.names.get(node) {
            return name.clone();
        }
        let uv = |row: u32, set: u8, is_transformed: bool| {
            if is_transformed { format!("pattern_uv(point.uv{set}, data + {row}u)") } else { format!("point.uv{set}") }
        };
        let expression = match node {
            Node::Constant { row } => format!("pattern_constant(data + {row}u)"),
            Node::Image { row, uv_set, is_transformed } if self.has_footprints => {
                let scale = if *is_transformed { format!(" * pattern_uv_scale(data + {row}u)") } else { String::new() };
                format!(
                    "texture_image_footprint(material_data_row(data + {row}u).x, {}, point.areas.{}{scale})",
                    uv(*row, *uv_set, *is_transformed),
                    ["x", "y"][usize::from(*uv_set)]
                )
            }
            Node::Image { row, uv_set, is_transformed } => {
                format!("texture_image(material_data_row(data + {row}u).x, {})", uv(*row, *uv_set, *is_transformed))
            }
            Node::Checker { row, texture_row, uv_set, is_transformed } => format!(
                "texture_checker(pattern_constant(data + {row}u), pattern_constant(data + {}u), pattern_constant(data + {}u).xy, {})",
                row + 1,
                row + 2,
                uv(*texture_row, *uv_set, *is_transformed)
            ),
            Node::VertexColor => "point.color".to_owned(),
            Node::Multiply(a, b) => format!("{} * {}", self.name(a), self.name(b)),
            Node::Share(a) => format!("vec4(clamp({}.x, 0.0, 1.0))", self.name(a)),
            Node::Rest(a) => format!("vec4(1.0 - clamp({}.x, 0.0, 1.0))", self.name(a)),
            Node::Channel(a, c) => {
                format!("{}.{}", self.name(a), ["xxxx", "yyyy", "zzzz", "wwww"][usize::from(*c)])
            }
        };
        let name = format!("v{}", self.names.len());
        self.text += &format!("    vec4 {name} = {expression};\n");
        self.names.insert(node.clone(), name.clone());
        name
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn materials_of_one_shape_share_a_structure_and_equal_lookups_are_fetched_once() {
        let textures = [Texture::Image {
            image: 0,
            wrap: [crate::scene::Wrap::Repeat; 2],
            filter: crate::scene::Filter::Linear,
            minify: crate::scene::Minify::default(),
            encoding: crate::scene::Encoding::Linear,
        }];
        let context = Context { textures: &textures, texture_rows: &[Some(7)] };
        let orm = || Value::Texture { texture: 0, uv_set: 0, uv_transform: DAffine2::IDENTITY };
        let inputs = |x: f64| {
            [
                Value::Multiply(Box::new(Value::scalar(x)), Box::new(Value::Channel(Box::new(orm()), 1))),
                Value::Channel(Box::new(orm()), 2),
            ]
        };
        let mut patterns = Patterns::default();
        let (a, rows_a) = patterns.add(Role::Bsdf(0), &inputs(0.5), &context);
        let (b, rows_b) = patterns.add(Role::Bsdf(0), &inputs(0.25), &context);
        assert_eq!((a, b), (0, 0));
        assert_eq!(patterns.structures.len(), 1);
        assert_eq!(patterns.rows[rows_a as usize][0], 0.5f32.to_bits());
        assert_eq!(patterns.rows[rows_b as usize][0], 0.25f32.to_bits());
        let (text, outputs) = patterns.structures[0].glsl(false);
        assert_eq!(text.matches("texture_image(").count(), 1, "{text}");
        assert_eq!(outputs.len(), 2);
    }
}
