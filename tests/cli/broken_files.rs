//! Scene files with one fault each, through the program: exit code 2 and one sentence. The library's own words are
//! held in tests/formats.

use super::refuses;
use crate::triangle::{Folder, TEXTURED, TRIANGLE, buffer, glb, lying_png};

fn render(path: std::path::PathBuf, words: &[&str]) {
    refuses(&["render", &path.display().to_string()], words);
}

#[test]
fn models() {
    let folder = Folder::new();
    let whole = glb(&TRIANGLE.replace("\"uri\": \"triangle.bin\", ", ""), &buffer());
    render(folder.write("cut.glb", &whole[..whole.len() / 2]), &["cut.glb", "truncated .glb"]);
    for (from, to, words) in [
        (r#""mesh": 0"#, r#""mesh": 7"#, "refers to mesh 7"),
        (r#""count": 3"#, r#""count": 400000000000"#, "do not fit the 36 bytes"),
        (r#"{"name": "leaf", "mesh": 0}"#, r#"{"name": "leaf", "children": [0]}"#, "a cycle in the node tree"),
        (r#""mesh": 0"#, r#""mesh": 0, "scale": [0, 1, 1]"#, "node 1 \"leaf\": its transform has no inverse"),
        (r#""mesh": 0"#, r#""mesh": 0, "translation": [1e400, 0, 0]"#, "number out of range"),
        (TEXTURED.0, TEXTURED.1, "picture.png: there is no such file"),
    ] {
        render(folder.gltf(from, to), &["triangle.gltf", words]);
    }
    let path = folder.gltf(TEXTURED.0, TEXTURED.1);
    for (width, height) in [(30_000, 30_000), (9, 9), (0, 4)] {
        folder.write("picture.png", &lying_png(width, height));
        render(path.clone(), &["triangle.gltf", "image picture.png"]);
    }
    let mut bytes = buffer();
    bytes[40] = 200;
    folder.write("triangle.bin", &bytes);
    render(folder.gltf("\"m\"", "\"m\""), &["index 200 at place 2 is beyond the 3 vertices"]);
}
