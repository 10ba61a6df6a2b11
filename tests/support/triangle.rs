//! A small glTF file that faults are put into, one at a time; shared by the binaries that need it.

#![allow(dead_code)]

use std::path::PathBuf;

/// A triangle with every part that a fault can be put into, as .gltf text; its buffer lies beside it.
/// 36 bytes of positions, 6 of indices (2 of padding), 36 of colours.
pub const TRIANGLE: &str = r#"{
  "asset": {"version": "2.0"},
  "scene": 0,
  "scenes": [{"nodes": [0]}],
  "nodes": [{"name": "root", "children": [1]}, {"name": "leaf", "mesh": 0}],
  "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "COLOR_0": 2}, "indices": 1, "material": 0}]}],
  "materials": [{"name": "m"}],
  "accessors": [
    {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
    {"bufferView": 1, "componentType": 5123, "count": 3, "type": "SCALAR"},
    {"bufferView": 2, "componentType": 5126, "count": 3, "type": "VEC3"}
  ],
  "bufferViews": [
    {"buffer": 0, "byteOffset": 0, "byteLength": 36},
    {"buffer": 0, "byteOffset": 36, "byteLength": 6},
    {"buffer": 0, "byteOffset": 44, "byteLength": 36}
  ],
  "buffers": [{"uri": "triangle.bin", "byteLength": 80}]
}"#;

pub const TEXTURED: (&str, &str) = (
    r#"{"name": "m"}"#,
    r#"{"name": "m", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}], "textures": [{"source": 0}], "images": [{"uri": "picture.png"}"#,
);

pub fn buffer() -> Vec<u8> {
    let mut bytes = Vec::new();
    for x in [0f32, 0., 0., 1., 0., 0., 0., 1., 0.] {
        bytes.extend(x.to_le_bytes());
    }
    bytes.extend([0, 0, 1, 0, 2, 0, 0, 0]);
    for x in [1f32; 9] {
        bytes.extend(x.to_le_bytes());
    }
    bytes
}

pub fn with_float(at: usize, value: f32) -> Vec<u8> {
    let mut bytes = buffer();
    bytes[at..at + 4].copy_from_slice(&value.to_le_bytes());
    bytes
}

pub struct Folder(pub tempfile::TempDir);

impl Folder {
    #[allow(clippy::new_without_default)]
    pub fn new() -> Self {
        let folder = Self(tempfile::tempdir().unwrap());
        folder.write("triangle.bin", &buffer());
        folder
    }
    pub fn write(&self, name: &str, bytes: &[u8]) -> PathBuf {
        let path = self.0.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        path
    }
    /// The triangle with one text replaced.
    pub fn gltf(&self, from: &str, to: &str) -> PathBuf {
        assert!(TRIANGLE.contains(from), "{from}");
        self.write("triangle.gltf", TRIANGLE.replacen(from, to, 1).as_bytes())
    }
}

pub fn glb(json: &str, binary: &[u8]) -> Vec<u8> {
    let mut json = json.as_bytes().to_vec();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut bytes = b"glTF\x02\0\0\0".to_vec();
    bytes.extend((28 + json.len() as u32 + binary.len() as u32).to_le_bytes());
    bytes.extend((json.len() as u32).to_le_bytes());
    bytes.extend(b"JSON");
    bytes.extend(json);
    bytes.extend((binary.len() as u32).to_le_bytes());
    bytes.extend(b"BIN\0");
    bytes.extend(binary);
    bytes
}

/// A PNG of one colour, written by the image crate.
pub fn png(width: u32, height: u32) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    image::RgbImage::from_pixel(width, height, image::Rgb([255, 128, 0]))
        .write_to(&mut bytes, image::ImageFormat::Png)
        .unwrap();
    bytes.into_inner()
}

/// The same with another size in its header, and that header's checksum right again.
pub fn lying_png(width: u32, height: u32) -> Vec<u8> {
    let mut bytes = png(4, 4);
    bytes[16..20].copy_from_slice(&width.to_be_bytes());
    bytes[20..24].copy_from_slice(&height.to_be_bytes());
    let mut crc = u32::MAX;
    for byte in &bytes[12..29] {
        crc ^= u32::from(*byte);
        for _ in 0..8 {
            crc = if crc & 1 == 1 { (crc >> 1) ^ 0xedb8_8320 } else { crc >> 1 };
        }
    }
    bytes[29..33].copy_from_slice(&(!crc).to_be_bytes());
    bytes
}
