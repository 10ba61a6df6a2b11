//! Writes glTF 2.0 binary files: one buffer, meshes, PNG textures, materials as JSON, nodes.

use serde_json::{Value, json};

use super::mesh::Mesh;
use super::pattern::Bitmap;

/// glTF's numbers for component and buffer-view kinds (glTF 2.0, 3.6.2 and 5.11).
const FLOAT: u32 = 5126;
const UNSIGNED_SHORT: u32 = 5123;
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;

/// A file under construction. Indices returned are glTF's.
#[derive(Default)]
pub struct Glb {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
    meshes: Vec<Value>,
    images: Vec<Value>,
    textures: Vec<Value>,
    materials: Vec<Value>,
    nodes: Vec<Value>,
    extensions: Vec<&'static str>,
}

/// Accessors of a stored mesh.
pub struct Shape {
    attributes: Value,
    indices: usize,
}

impl Glb {
    /// Adds a PNG texture (repeating, linear).
    pub fn texture(&mut self, name: &str, bitmap: &Bitmap) -> usize {
        let view = self.view(&bitmap.png(), None);
        self.images.push(json!({ "name": name, "mimeType": "image/png", "bufferView": view }));
        self.textures.push(json!({ "source": self.images.len() - 1, "sampler": 0 }));
        self.textures.len() - 1
    }

    /// Adds a material; extensions it names are declared.
    pub fn material(&mut self, material: Value) -> usize {
        for name in [
            "KHR_materials_transmission",
            "KHR_materials_volume",
            "KHR_materials_ior",
            "KHR_materials_emissive_strength",
        ] {
            if material["extensions"].get(name).is_some() && !self.extensions.contains(&name) {
                self.extensions.push(name);
            }
        }
        self.materials.push(material);
        self.materials.len() - 1
    }

    /// Stores vertices and indices; several meshes may share them.
    pub fn shape(&mut self, mesh: &Mesh) -> Shape {
        let (low, high) = mesh.bounds();
        let positions = self.floats(mesh.positions.as_flattened(), 3);
        self.accessors[positions]["min"] = json!(low);
        self.accessors[positions]["max"] = json!(high);
        let mut attributes = json!({ "POSITION": positions });
        attributes["NORMAL"] = json!(self.floats(mesh.normals.as_flattened(), 3));
        if mesh.keeps_uvs {
            attributes["TEXCOORD_0"] = json!(self.floats(mesh.uvs.as_flattened(), 2));
        }
        let indices: Vec<u8> = mesh.triangles.iter().flatten().flat_map(|i| i.to_le_bytes()).collect();
        let view = self.view(&indices, Some(ELEMENT_ARRAY_BUFFER));
        self.accessors.push(json!({
            "bufferView": view, "componentType": UNSIGNED_SHORT, "count": mesh.triangles.len() * 3, "type": "SCALAR"
        }));
        Shape { attributes, indices: self.accessors.len() - 1 }
    }

    pub fn mesh(&mut self, name: &str, shape: &Shape, material: usize) -> usize {
        self.meshes.push(json!({
            "name": name,
            "primitives": [{ "attributes": shape.attributes, "indices": shape.indices, "material": material }]
        }));
        self.meshes.len() - 1
    }

    /// Places a mesh; `turn` is a quaternion (x, y, z, w).
    pub fn node(&mut self, name: &str, mesh: usize, translation: [f64; 3], turn: [f64; 4]) {
        self.nodes.push(json!({ "name": name, "mesh": mesh, "translation": translation, "rotation": turn }));
    }

    pub fn finish(self) -> Vec<u8> {
        let roots: Vec<usize> = (0..self.nodes.len()).collect();
        let mut json = json!({
            "asset": { "version": "2.0", "generator": "steradian generate showcase" },
            "scene": 0,
            "scenes": [{ "name": "showcase", "nodes": roots }],
            "nodes": self.nodes,
            "meshes": self.meshes,
            "materials": self.materials,
            "textures": self.textures,
            "images": self.images,
            "samplers": [{ "magFilter": 9729, "minFilter": 9729, "wrapS": 10497, "wrapT": 10497 }],
            "accessors": self.accessors,
            "bufferViews": self.views,
            "buffers": [{ "byteLength": self.bytes.len() }]
        });
        json["extensionsUsed"] = json!(self.extensions);
        let text = pad(json.to_string().into_bytes(), b' ');
        let binary = pad(self.bytes, 0);
        let total = 12 + 8 + text.len() + 8 + binary.len();
        let mut file = b"glTF".to_vec();
        file.extend(2u32.to_le_bytes());
        file.extend((total as u32).to_le_bytes());
        for (kind, chunk) in [(b"JSON", text), (b"BIN\0", binary)] {
            file.extend((chunk.len() as u32).to_le_bytes());
            file.extend(kind);
            file.extend(chunk);
        }
        file
    }

    fn floats(&mut self, values: &[f32], width: usize) -> usize {
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        let view = self.view(&bytes, Some(ARRAY_BUFFER));
        self.accessors.push(json!({
            "bufferView": view, "componentType": FLOAT, "count": values.len() / width, "type": format!("VEC{width}")
        }));
        self.accessors.len() - 1
    }

    fn view(&mut self, bytes: &[u8], target: Option<u32>) -> usize {
        self.bytes = pad(std::mem::take(&mut self.bytes), 0);
        let mut view = json!({ "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len() });
        if let Some(target) = target {
            view["target"] = json!(target);
        }
        self.bytes.extend_from_slice(bytes);
        self.views.push(view);
        self.views.len() - 1
    }
}

/// To a multiple of 4 bytes, as chunks and floats need.
fn pad(mut bytes: Vec<u8>, with: u8) -> Vec<u8> {
    bytes.resize(bytes.len().next_multiple_of(4), with);
    bytes
}
