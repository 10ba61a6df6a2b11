//! .ply in its three encodings, good and bad.

use steradian::scene::{self, Mesh, Scene, Value};

use crate::bad::{noted, refused};
use crate::damage::damaged;
use crate::triangle::Folder;

/// A square of two triangles whose vertices carry everything, with elements and properties that nobody reads.
fn square(encoding: &str) -> Vec<u8> {
    let header = format!(
        "ply\nformat {encoding} 1.0\ncomment made here\nelement camera 1\nproperty list uchar float view\nproperty double far\n\
         element vertex 4\nproperty float x\nproperty double y\nproperty float z\nproperty float nx\nproperty float ny\n\
         property float nz\nproperty short quality\nproperty float s\nproperty float t\nproperty uchar red\nproperty uchar green\n\
         property uchar blue\nproperty list uchar int neighbours\nelement face 2\nproperty uchar flags\n\
         property list uchar int vertex_indices\nproperty list uchar float texcoord\nelement edge 1\nproperty int a\nend_header\n"
    );
    let mut out = Numbers { encoding, bytes: header.into_bytes() };
    out.write("u8 2 f32 1 f32 2 f64 3");
    for (x, y) in [(0, 0), (1, 0), (1, 1), (0, 1)] {
        out.write(&format!(
            "f32 {x} f64 {y} f32 0 f32 0 f32 0 f32 1 i16 -7 f32 {x} f32 {y} u8 255 u8 188 u8 0 u8 1 i32 9"
        ));
    }
    out.write("u8 1 u8 3 i32 0 i32 1 i32 2 u8 0");
    out.write("u8 1 u8 3 i32 0 i32 2 i32 3 u8 2 f32 1 f32 1");
    out.write("i32 5");
    out.bytes
}

struct Numbers<'a> {
    encoding: &'a str,
    bytes: Vec<u8>,
}

impl Numbers<'_> {
    /// Pairs of type and number.
    fn write(&mut self, row: &str) {
        let words: Vec<&str> = row.split(' ').collect();
        for pair in words.chunks(2) {
            if self.encoding == "ascii" {
                self.bytes.extend(format!("{} ", pair[1]).bytes());
                continue;
            }
            let x: f64 = pair[1].parse().unwrap();
            let mut bytes = match pair[0] {
                "u8" => vec![x as u8],
                "i16" => (x as i16).to_be_bytes().to_vec(),
                "i32" => (x as i32).to_be_bytes().to_vec(),
                "f32" => (x as f32).to_be_bytes().to_vec(),
                _ => x.to_be_bytes().to_vec(),
            };
            if self.encoding == "binary_little_endian" {
                bytes.reverse();
            }
            self.bytes.extend(bytes);
        }
        if self.encoding == "ascii" {
            self.bytes.push(b'\n');
        }
    }
}

const ENCODINGS: [&str; 3] = ["ascii", "binary_little_endian", "binary_big_endian"];

fn load(folder: &Folder, bytes: &[u8]) -> Scene {
    scene::load(&folder.write("a.ply", bytes)).unwrap_or_else(|e| panic!("{e}"))
}

fn check(mesh: &Mesh) {
    assert_eq!(mesh.positions, [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]);
    assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
    assert_eq!(mesh.normals.as_ref().unwrap()[3], [0.0, 0.0, 1.0]);
    assert_eq!(mesh.uvs[0].as_ref().unwrap()[2], [1.0, 0.0]);
    let color = mesh.colors.as_ref().unwrap()[0];
    // 188 of 255 is the sRGB byte next to one half.
    assert!(color[0] == 1.0 && (color[1] - 0.502_886).abs() < 1e-5 && color[2..] == [0.0, 1.0], "{color:?}");
}

#[test]
fn three_encodings_are_one_surface() {
    let folder = Folder::new();
    for encoding in ENCODINGS {
        let bytes = square(encoding);
        let scene = load(&folder, &bytes);
        check(&scene.meshes[0]);
        assert!(matches!(scene.materials[0].inputs[0], Value::VertexColor));
        assert_eq!((scene.materials[0].name.as_str(), scene.notes.len()), ("a", 0));
        // Old Macintosh and DOS ends of lines.
        let end = bytes.windows(11).position(|w| w == b"end_header\n").unwrap() + 11;
        let header = String::from_utf8(bytes[..end].to_vec()).unwrap();
        for ends in ["\r", "\r\n"] {
            let mut other = header.replace('\n', ends).into_bytes();
            other.extend(&bytes[end..]);
            check(&load(&folder, &other).meshes[0]);
        }
    }
}

fn text(vertices: &str, faces: &str) -> String {
    let count = vertices.split(';').count();
    let face_count = faces.split(';').count();
    let body = format!("{vertices};{faces}").replace(';', "\n");
    format!(
        "ply\nformat ascii 1.0\nelement vertex {count}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {face_count}\nproperty list uchar int vertex_index\nend_header\n{body}\n"
    )
}

const CORNERS: &str = "0 0 0;1 0 0;1 1 0;0 1 0";

#[test]
fn plain_files_are_flat_and_grey() {
    let folder = Folder::new();
    let scene = load(&folder, text(CORNERS, "4 0 1 2 3;2 0 1").as_bytes());
    let mesh = &scene.meshes[0];
    assert!(mesh.normals.is_none() && mesh.colors.is_none() && mesh.uvs[0].is_none());
    assert_eq!(mesh.triangles.len(), 2);
    let toml = b"[[model]]\nfile = \"a.ply\"\n[material.a]\nalbedo = 0.25\n";
    let scene = scene::load(&folder.write("a.toml", toml)).unwrap();
    assert!(matches!(scene.materials[0].inputs[0], Value::Constant([0.25, ..])));
    noted(
        &folder.write("a.ply", text("nan 0 0;1 0 0;1 1 0;0 1 0", "3 0 1 2;3 1 2 3").as_bytes()),
        "1 triangles left out, 1 vertices are NaN or infinite",
    );
}

#[test]
fn headers_that_are_wrong() {
    let folder = Folder::new();
    let good = text(CORNERS, "3 0 1 2");
    let huge = "vertex 4294967295000";
    for (from, to, wanted) in [
        ("ply\n", "plx\n", "does not begin with `ply`"),
        (
            "ascii",
            "binary_middle_endian",
            "line 2 of its header, \"format binary_middle_endian 1.0\", names no known encoding",
        ),
        ("1.0", "2.0", "is not of version 1.0"),
        ("format ascii 1.0\n", "", "has no `format` line"),
        ("float x", "flout x", "has an unknown type"),
        ("float x", "float w", "its vertices have no x, y and z"),
        ("vertex 4", "vertex -4", "has no count"),
        ("vertex 4", huge, "says 4294967295000 of element vertex, and"),
        ("vertex 4", "vertex 18446744073709551615", "the file is cut or damaged"),
        ("face 1", "face 100000", "says 100000 of element face"),
        ("vertex 4", "vertex 5", "of face 0 says 2 entries, and 1 bytes are left; the file is damaged"),
        ("list uchar int vertex_index", "list uchar int corners", "no list vertex_indices"),
        ("list uchar int vertex_index", "list uchar float vertex_index", "its vertex_indices are not whole numbers"),
        ("list uchar int vertex_index", "list float int vertex_index", "counts with fractions"),
        ("element vertex 4\n", "", "belongs to no element"),
        ("element face 1", "element vertex 1", "comes twice"),
        ("end_header", "end", "is not understood"),
        ("3 0 1 2", "3 0 1 9", "face 0 refers to vertex 9, and the file has 4"),
        ("3 0 1 2", "3 0 1 -1", "face 0 refers to vertex -1"),
        ("3 0 1 2", "-3 0 1 2", "the list vertex_index of face 0 says -3 entries"),
        ("3 0 1 2", "200 0 1 2", "says 200 entries, and"),
        ("3 0 1 2", "3 0 one 2", "\"one\" in element face 0 is no number"),
        ("3 0 1 2", "2 0 1", "holds no triangle that can be seen"),
    ] {
        assert!(good.contains(from), "{from}");
        refused(&folder.write("a.ply", good.replacen(from, to, 1).as_bytes()), wanted);
    }
    refused(&folder.write("a.ply", b""), "is empty (0 bytes)");
    refused(&folder.write("a.ply", b"ply\nformat ascii 1.0\nelement vertex 3"), "without `end_header`");
    refused(&folder.write("a.ply", b"ply\nformat ascii 1.0\nelement face 0\nend_header\n"), "has no vertices");
    let faces_first = "ply\nformat ascii 1.0\nelement face 1\nproperty list uchar int vertex_indices\nelement vertex 1\n\
        property float x\nproperty float y\nproperty float z\nend_header\n3 0 0 0\n0 0 0\n";
    refused(&folder.write("a.ply", faces_first.as_bytes()), "its faces stand before its vertices");
    let many = (0..5000).map(|_| "0").collect::<Vec<_>>().join(" ");
    let large = text(CORNERS, &format!("5000 {many}")).replace("uchar int", "ushort int");
    refused(&folder.write("a.ply", large.as_bytes()), "face 0 has 5000 corners, and 4096 are the most");
}

#[test]
fn every_cut_is_refused() {
    let folder = Folder::new();
    for encoding in ENCODINGS {
        let whole = square(encoding);
        // The last element is an edge that nobody reads; of a text the last blanks are no loss.
        for length in (1..whole.len() - 4).step_by(3) {
            let path = folder.write("cut.ply", &whole[..length]);
            let message = scene::load(&path).expect_err("a cut file").to_string();
            assert!(!message.contains('\n') && message.contains("cut.ply"), "{message}");
        }
    }
}

#[test]
fn random_damage_never_panics() {
    let folder = Folder::new();
    for encoding in ENCODINGS {
        let whole = square(encoding);
        let loaded = damaged(1500, &[&whole], |parts| folder.write("a.ply", &parts[0]));
        assert!((50..1450).contains(&loaded), "{encoding}: {loaded} of 1500 loaded");
    }
}
