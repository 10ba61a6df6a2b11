//! `[[shape]]`: spheres, discs, rectangles, boxes and meshes written out.

use glam::{DAffine3, DMat3, DQuat, DVec3};

use super::table::{Item, Table};
use super::transform::{is_invertible, placed_by, transform};
use super::{Builder, keys, light, material};
use crate::scene::{Error, Instance, Material, Mesh, Shape};

impl<'a> Builder<'a> {
    pub fn shape(&mut self, item: &'a Item<'a>) -> Result<(), Error> {
        let kind = item.get_ref().get("type").and_then(|t| t.get_ref().as_str()).unwrap_or("").to_string();
        let section = match kind.as_str() {
            "sphere" => &keys::SPHERE,
            "disc" => &keys::DISC,
            "rectangle" => &keys::RECTANGLE,
            "box" => &keys::BOX,
            "mesh" => &keys::MESH,
            _ => {
                let hint = "add type = \"sphere\", \"disc\", \"rectangle\", \"box\" or \"mesh\"";
                let at = item.get_ref().get("type").map_or(item.span(), |t| t.span());
                return Err(self.source.error(at, format!("a [[shape]] without a known type; {hint}")));
            }
        };
        let table = Table::open(self.source, item, &[&keys::SHAPE, section], &[])?;
        let placed = transform(&table)?;
        if kind == "mesh"
            && let Some(file) = table.text("file")?
        {
            return self.mesh_file(&table, file, &placed);
        }
        let (shape, own) = match kind.as_str() {
            "sphere" => (Shape::Sphere, sphere(&table)?),
            "disc" => (Shape::Disc, disc(&table)?),
            "rectangle" => (Shape::Rectangle, rectangle(&table)?),
            _ => {
                let mesh = if kind == "box" { box_mesh(&table)? } else { self.mesh(&table)? };
                self.scene.meshes.push(mesh);
                (Shape::Mesh(self.scene.meshes.len() - 1), DAffine3::IDENTITY)
            }
        };
        let name = table.text("name")?.unwrap_or(&kind).to_string();
        if let Shape::Mesh(mesh) = shape {
            self.scene.meshes[mesh].name.clone_from(&name);
            crate::scene::format::clean::clean(&mut self.scene.meshes[mesh], &mut self.scene.notes);
            if self.scene.meshes[mesh].triangles.is_empty() {
                let reason = format!("the mesh \"{name}\" has no triangle: nothing of it is seen");
                self.scene.notes.push(self.source.error(table.at.clone(), reason).to_string());
            }
        }
        let material = match table.text("material")? {
            Some(name) => self.named(&self.materials, &table, "material", name)?,
            None => self.default_material(),
        };
        shape.stays_round(&(placed * own)).map_err(|reason| table.error(placed_by(&table), reason))?;
        for copy in self.copies(&table, &|copy| shape.stays_round(&(*copy * placed * own)))? {
            let to_world = copy * placed * own;
            let material = self.with_power(&table, material, &[shape], &to_world)?;
            let material = self.in_group(&table, material)?;
            self.scene.instances.push(Instance { name: name.clone(), shape, to_world, material });
        }
        Ok(())
    }

    /// The meshes of a file as one shape each, all in the material of the shape.
    fn mesh_file(&mut self, table: &Table<'a>, file: &str, placed: &DAffine3) -> Result<(), Error> {
        for key in ["positions", "triangles", "normals", "uvs", "uvs1", "colors"] {
            if table.get(key).is_some() {
                return Err(table.error(key, "stands beside `file`; keep one of the two"));
            }
        }
        let path = self.path(table, "file", file)?;
        let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
        if !matches!(extension.as_str(), "obj" | "ply") {
            return Err(table.error("file", "must be an .obj or .ply file; write [[model]] for others"));
        }
        let loaded = crate::scene::format::load_model(&path, crate::scene::Choice::default())
            .map_err(|e| table.error("file", format!("cannot be used: {e}")))?
            .scene;
        let material = match table.text("material")? {
            Some(name) => self.named(&self.materials, table, "material", name)?,
            None => self.default_material(),
        };
        let name = table.text("name")?.unwrap_or("mesh");
        let first = self.scene.meshes.len();
        self.scene.meshes.extend(loaded.meshes);
        let shapes: Vec<Shape> = (first..self.scene.meshes.len()).map(Shape::Mesh).collect();
        for copy in self.copies(table, &|_| Ok(()))? {
            let to_world = copy * *placed;
            let material = self.with_power(table, material, &shapes, &to_world)?;
            let material = self.in_group(table, material)?;
            for &shape in &shapes {
                self.scene.instances.push(Instance { name: name.into(), shape, to_world, material });
            }
        }
        // What was said of materials does not matter here.
        self.scene.notes.extend(loaded.notes.into_iter().filter(|n| !n.starts_with("material")));
        Ok(())
    }

    /// The material, or a copy of it that gives this one lamp the power the shape asks for.
    fn with_power(
        &mut self,
        table: &Table<'a>,
        material: usize,
        shapes: &[Shape],
        to_world: &DAffine3,
    ) -> Result<usize, Error> {
        // A million copies that ask for none are not measured.
        if !light::asks_for_power(table) {
            return Ok(material);
        }
        let area = shapes.iter().map(|&shape| light::area(shape, to_world, &self.scene.meshes)).sum();
        let own = &self.scene.materials[material];
        let sides = if own.emission_two_sided { 2.0 } else { 1.0 };
        let Some(emission) = light::emission_of_power(table, own.emission.as_ref(), area, sides)? else {
            return Ok(material);
        };
        if emission.is_zero() {
            let key = if table.get("power").is_some() { "power" } else { "power_lm" };
            let note = table.error(key, "is 0: the shape is dark").to_string();
            if !self.scene.notes.contains(&note) {
                self.scene.notes.push(note);
            }
        }
        let own = &self.scene.materials[material];
        let lamp = Material { emission: Some(emission), ..own.clone() };
        self.scene.materials.push(lamp);
        Ok(self.scene.materials.len() - 1)
    }

    /// Grey lambert, made when first needed. No file can write its name: names are not empty there.
    fn default_material(&mut self) -> usize {
        *self.materials.entry(String::new()).or_insert_with(|| {
            self.scene.materials.push(material::plain("default", 0));
            self.scene.materials.len() - 1
        })
    }

    fn mesh(&mut self, table: &Table<'a>) -> Result<Mesh, Error> {
        let positions = table.rows::<3>("positions")?.ok_or_else(|| table.missing("positions"))?;
        let count = positions.len();
        let rows = table.rows::<3>("triangles")?.ok_or_else(|| table.missing("triangles"))?;
        let mut triangles = Vec::with_capacity(rows.len());
        for row in rows {
            if let Some(bad) = row.iter().find(|i| i.fract() != 0.0 || **i < 0.0 || **i >= count as f64) {
                return Err(table.error("triangles", format!("has the vertex {bad}, and there are {count}, from 0")));
            }
            triangles.push(row.map(|i| i as u32));
        }
        let uvs = |key| Ok::<_, Error>(per_vertex(table, key, count, table.rows::<2>(key)?)?.map(|v| to_f32(&v)));
        let colors = match table.get("colors").and_then(|i| i.get_ref().as_array()?.iter().next()) {
            Some(first) if first.get_ref().as_array().is_some_and(|a| a.iter().count() == 4) => {
                table.rows::<4>("colors")?
            }
            _ => table.rows::<3>("colors")?.map(|v| v.iter().map(|c| [c[0], c[1], c[2], 1.0]).collect()),
        };
        Ok(Mesh {
            name: String::new(),
            positions: to_f32(&positions),
            normals: per_vertex(table, "normals", count, table.rows::<3>("normals")?)?.map(|v| to_f32(&v)),
            tangents: None,
            uvs: [uvs("uvs")?, uvs("uvs1")?],
            colors: per_vertex(table, "colors", count, colors)?.map(|v| to_f32(&v)),
            triangles,
        })
    }
}

fn to_f32<const N: usize>(rows: &[[f64; N]]) -> Vec<[f32; N]> {
    rows.iter().map(|row| row.map(|x| x as f32)).collect()
}

fn per_vertex<T>(table: &Table<'_>, key: &str, count: usize, rows: Option<Vec<T>>) -> Result<Option<Vec<T>>, Error> {
    match rows {
        Some(rows) if rows.len() != count => {
            Err(table.error(key, format!("has {} entries, and there are {count} positions", rows.len())))
        }
        rows => Ok(rows),
    }
}

fn sphere(table: &Table<'_>) -> Result<DAffine3, Error> {
    let (center, radius) = round(table)?;
    Ok(DAffine3 { matrix3: DMat3::from_diagonal(DVec3::splat(radius)), translation: center })
}

fn disc(table: &Table<'_>) -> Result<DAffine3, Error> {
    let (center, radius) = round(table)?;
    let normal = DVec3::from(table.numbers::<3>("normal")?.unwrap_or([0.0, 0.0, 1.0]))
        .try_normalize()
        .ok_or_else(|| table.error("normal", "must not be zero"))?;
    let turn = DMat3::from_quat(DQuat::from_rotation_arc(DVec3::Z, normal));
    Ok(DAffine3 { matrix3: turn * DMat3::from_diagonal(DVec3::splat(radius)), translation: center })
}

/// `center` and `radius`.
fn round(table: &Table<'_>) -> Result<(DVec3, f64), Error> {
    let center = DVec3::from(table.numbers::<3>("center")?.unwrap_or([0.0; 3]));
    let radius = table.number("radius")?.unwrap_or(1.0);
    if radius <= 0.0 {
        return Err(table.error("radius", "must be above 0 m"));
    }
    Ok((center, radius))
}

fn rectangle(table: &Table<'_>) -> Result<DAffine3, Error> {
    let vector = |key, default: DVec3| Ok::<_, Error>(table.numbers::<3>(key)?.map_or(default, DVec3::from));
    let (u, v) = (vector("u", DVec3::X)?, vector("v", DVec3::Y)?);
    let matrix3 = DMat3::from_cols(u, v, u.cross(v).normalize_or_zero());
    if !is_invertible(&matrix3) {
        return Err(table.error("v", "and `u` span no area; give two directions"));
    }
    Ok(DAffine3 { matrix3, translation: vector("center", DVec3::ZERO)? })
}

/// 24 vertices, so that each face has its own texture coordinates.
fn box_mesh(table: &Table<'_>) -> Result<Mesh, Error> {
    let low = DVec3::from(table.numbers::<3>("min")?.unwrap_or([-1.0; 3]));
    let high = DVec3::from(table.numbers::<3>("max")?.unwrap_or([1.0; 3]));
    if !low.cmplt(high).all() {
        return Err(table.error("max", "must be above `min` in x, y and z"));
    }
    let (center, half) = (low * 0.5 + high * 0.5, (high - low) * 0.5);
    // Outward normal, and the direction of texture u; v runs along u x n, which is down.
    let faces = [
        (DVec3::X, DVec3::NEG_Z),
        (DVec3::NEG_X, DVec3::Z),
        (DVec3::Y, DVec3::X),
        (DVec3::NEG_Y, DVec3::X),
        (DVec3::Z, DVec3::X),
        (DVec3::NEG_Z, DVec3::NEG_X),
    ];
    let mut mesh = Mesh::default();
    let mut uvs = Vec::new();
    for (normal, along) in faces {
        let down = along.cross(normal);
        let first = mesh.positions.len() as u32;
        for (u, v) in [(0.0, 1.0), (1.0, 1.0), (1.0, 0.0), (0.0, 0.0)] {
            let p = center + half * (normal + along * (2.0 * u - 1.0) + down * (2.0 * v - 1.0));
            mesh.positions.push(p.as_vec3().to_array());
            uvs.push([u as f32, v as f32]);
        }
        mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    }
    mesh.uvs[0] = Some(uvs);
    Ok(mesh)
}
