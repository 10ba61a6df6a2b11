//! Files made to be wrong, one fault each: the message is one sentence that says what, where, and what to do.

use std::path::Path;

use steradian::scene::{self, Scene};

use crate::triangle::*;

pub fn refused(path: &Path, wanted: &str) {
    let message = match scene::load(path) {
        Ok(_) => panic!("{} loaded; wanted: {wanted}", path.display()),
        Err(e) => e.to_string(),
    };
    assert!(message.contains(wanted), "\nwanted: {wanted}\nfound:  {message}");
    assert!(!message.contains('\n') && message.len() < 600, "one sentence: {message}");
}

pub fn noted(path: &Path, wanted: &str) -> Scene {
    let scene = scene::load(path).unwrap_or_else(|e| panic!("{e}"));
    assert!(scene.notes.iter().any(|n| n.contains(wanted)), "\nwanted: {wanted}\nfound: {:?}", scene.notes);
    scene
}

#[test]
fn the_triangle_itself_is_right() {
    let folder = Folder::new();
    let scene = scene::load(&folder.gltf("\"m\"", "\"m\"")).unwrap();
    assert_eq!((scene.meshes[0].triangles.len(), scene.instances[0].name.as_str()), (1, "root/leaf"));
    assert!(scene.notes.is_empty(), "{:?}", scene.notes);
    let text = TRIANGLE.replace("\"uri\": \"triangle.bin\", ", "");
    let scene = scene::load(&folder.write("triangle.glb", &glb(&text, &buffer()))).unwrap();
    assert_eq!(scene.meshes[0].colors.as_ref().unwrap()[2], [1.0; 4]);
}

#[test]
fn cameras_of_both_types() {
    use steradian::scene::Projection;
    let folder = Folder::new();
    let placed = |camera: &str| {
        let path = folder.gltf(r#""scene": 0,"#, &format!(r#""scene": 0, "cameras": [{camera}],"#));
        let text = std::fs::read_to_string(&path).unwrap();
        std::fs::write(&path, text.replace(r#"{"name": "root""#, r#"{"name": "root", "camera": 0"#)).unwrap();
        path
    };
    let projection = |camera: &str| scene::load(&placed(camera)).unwrap_or_else(|e| panic!("{e}")).camera.projection;
    let far = r#""znear": 0.1, "zfar": 9"#;
    assert_eq!(
        projection(&format!(r#"{{"type": "orthographic", "orthographic": {{"xmag": 3, "ymag": -2, {far}}}}}"#)),
        Projection::Orthographic { half_width: 3.0, half_height: 2.0 }
    );
    assert_eq!(
        projection(r#"{"type": "perspective", "perspective": {"yfov": 0.5, "znear": 0.1}}"#),
        Projection::Perspective { fov_y_rad: 0.5 }
    );
    let flat = format!(r#"{{"type": "orthographic", "orthographic": {{"xmag": 0, "ymag": 1, {far}}}}}"#);
    refused(&placed(&flat), "camera 0: `xmag` and `ymag` must not be 0");
    refused(&placed(r#"{"type": "perspective", "perspective": {"yfov": 4}}"#), "camera 0: `yfov` must be above 0");
    noted(&placed(r#"{"type": "orthographic"}"#), "without its parameters left out");
}

#[test]
fn files_that_are_no_scene() {
    let folder = Folder::new();
    let at = |name: &str| folder.0.path().join(name);
    refused(&at("none.glb"), "none.glb: there is no such file; check the path");
    refused(&at("none.toml"), "none.toml: there is no such file; check the path");
    refused(&at("none"), "none: there is no such file");
    refused(folder.0.path(), "is a directory; name the scene file inside it");
    refused(
        &folder.write("a.txt", b""),
        "a.txt: .txt is not a scene format; name a .toml, .gltf, .glb, .obj or .ply file",
    );
    refused(&folder.write("noextension", b""), "has no extension");
    refused(&folder.write("empty.gltf", b""), "empty.gltf: file: is empty (0 bytes); export it again");
    refused(&folder.write("empty.glb", b""), "empty.glb: file: is empty (0 bytes); export it again");
    refused(&folder.write("words.gltf", b"a triangle"), "words.gltf:1:1: this is not valid glTF JSON: expected value");
    refused(&folder.write("list.gltf", b"[1"), "this is not valid glTF JSON");
    refused(&folder.write("words.glb", b"a triangle"), "does not begin with `glTF`");
    refused(&folder.write("a.toml", b"\xff\xfe"), "byte 0 is no UTF-8 text");
}

#[test]
fn every_cut_of_a_glb_is_refused() {
    let folder = Folder::new();
    let whole = glb(&TRIANGLE.replace("\"uri\": \"triangle.bin\", ", ""), &buffer());
    for length in (1..whole.len()).step_by(7).chain([4, 8, 11, 12, 19, 20, whole.len() - 1]) {
        let path = folder.write("cut.glb", &whole[..length]);
        let message = scene::load(&path).expect_err("a cut file").to_string();
        assert!(length < 4 || message.contains("truncated .glb"), "{length}: {message}");
    }
    // A container of the right length whose buffer is cut: the JSON says 80 bytes.
    let text = TRIANGLE.replace("\"uri\": \"triangle.bin\", ", "");
    refused(
        &folder.write("short.glb", &glb(&text, &buffer()[..40])),
        "buffer 0: should have 80 bytes and has 40; the file is cut",
    );
    // A length below the header's own.
    let mut lying = whole.clone();
    lying[8..12].copy_from_slice(&3u32.to_le_bytes());
    refused(&folder.write("lying.glb", &lying), "says 3 bytes");
    let mut lying = whole;
    lying[12..16].copy_from_slice(&u32::MAX.to_le_bytes());
    refused(&folder.write("lying.glb", &lying), "a damaged .glb; export it again");
}

#[test]
fn numbers_that_point_nowhere() {
    let folder = Folder::new();
    for (from, to, wanted) in [
        (r#""mesh": 0"#, r#""mesh": 7"#, "node 1 \"leaf\": refers to mesh 7, and the file has 1"),
        (r#""children": [1]"#, r#""children": [9]"#, "node 0 \"root\": refers to node 9, and the file has 2"),
        (r#""nodes": [0]"#, r#""nodes": [5]"#, "the scene: refers to node 5"),
        (r#""scene": 0"#, r#""scene": 4"#, "the default scene: refers to scene 4"),
        (r#""material": 0"#, r#""material": 3"#, "mesh 0: refers to material 3, and the file has 1"),
        (r#""indices": 1"#, r#""indices": 11"#, "mesh 0: refers to accessor 11"),
        (r#""POSITION": 0"#, r#""POSITION": 1"#, "accessor 1: has 1 components a row where 3 are needed"),
        (r#"{"bufferView": 0"#, r#"{"bufferView": 8"#, "accessor 0: refers to buffer view 8"),
        (r#"{"buffer": 0"#, r#"{"buffer": 2"#, "buffer view 0: refers to buffer 2"),
        (r#""name": "leaf""#, r#""camera": 0, "name": "leaf""#, "refers to camera 0, and the file has 0"),
        (r#"{"name": "m"}"#, r#"{"name": "m", "normalTexture": {"index": 2}}"#, "a material: refers to texture 2"),
        (r#""uri": "triangle.bin""#, r#""uri": "other.bin""#, "other.bin: there is no such file"),
        (r#""uri": "triangle.bin""#, r#""uri": "https://a.b/c""#, "nothing is fetched from the network"),
        (r#""uri": "triangle.bin""#, r#""uri": "data:text,abc""#, "a data URI that is not base64"),
        (r#""componentType": 5123"#, r#""componentType": 5126"#, "component type 5126 cannot be an index"),
        (r#""componentType": 5126"#, r#""componentType": 1"#, "component type 1 does not exist"),
        (r#""version": "2.0""#, r#""version": "1.0""#, "is glTF 1.0, and only 2.0 is read"),
    ] {
        refused(&folder.gltf(from, to), wanted);
    }
    let mut bytes = buffer();
    bytes[40] = 200;
    folder.write("triangle.bin", &bytes);
    refused(&folder.gltf("\"m\"", "\"m\""), "accessor 1: index 200 at place 2 is beyond the 3 vertices of mesh 0");
}

#[test]
fn counts_beyond_the_bytes() {
    let folder = Folder::new();
    for (from, to, wanted) in [
        (
            r#""count": 3"#,
            r#""count": 4"#,
            "accessor 0: 4 rows of 12 bytes, 12 apart from offset 0, do not fit the 36 bytes",
        ),
        (r#""count": 3"#, r#""count": 18446744073709551615"#, "do not fit the 36 bytes"),
        (r#""count": 3"#, r#""count": 3, "byteOffset": 18446744073709551615"#, "do not fit the 36 bytes"),
        (r#"{"bufferView": 0, "#, r#"{"#, "mesh 0: COLOR_0 has 3 rows"),
        (
            r#""byteLength": 36"#,
            r#""byteLength": 36000"#,
            "buffer view 0: ends 36000 bytes after offset 0, and buffer 0 has 80 bytes",
        ),
        (r#""byteOffset": 0"#, r#""byteOffset": 18446744073709551615"#, "after offset 18446744073709551615"),
        (r#""byteLength": 36"#, r#""byteStride": 4, "byteLength": 36"#, "rows of 12 bytes stand 4 bytes apart"),
        (r#""byteLength": 80"#, r#""byteLength": 81"#, "buffer 0: should have 81 bytes and has 80"),
    ] {
        let path = match wanted.contains("COLOR_0") {
            // Zeros without bytes: allowed, up to a limit; the other attributes must still fit.
            true => folder.write(
                "triangle.gltf",
                TRIANGLE.replacen(from, to, 1).replacen("\"count\": 3", "\"count\": 5", 1).as_bytes(),
            ),
            false => folder.gltf(from, to),
        };
        refused(&path, wanted);
    }
    let text = TRIANGLE.replacen(r#"{"bufferView": 0, "#, "{", 1).replacen("\"count\": 3", "\"count\": 4000000000", 1);
    refused(&folder.write("absurd.gltf", text.as_bytes()), "claims 4000000000 rows without any bytes");
}

#[test]
fn node_trees_that_are_none() {
    let folder = Folder::new();
    let leaf = r#"{"name": "leaf", "mesh": 0}"#;
    let cycle = r#"{"name": "leaf", "mesh": 0, "children": [0]}"#;
    refused(&folder.gltf(leaf, cycle), "node 0 \"root\": is its own ancestor: a cycle in the node tree");
    refused(&folder.gltf(r#""children": [1]"#, r#""children": [0]"#), "is its own ancestor");
    refused(&folder.gltf(r#""nodes": [0]"#, r#""nodes": [0, 1]"#), "node 1 \"leaf\": has two parents");
    let text = TRIANGLE.replacen(leaf, cycle, 1).replacen(r#""scene": 0,"#, "", 1).replacen(
        r#""scenes": [{"nodes": [0]}],"#,
        "",
        1,
    );
    refused(&folder.write("rootless.gltf", text.as_bytes()), "has no root: its nodes form a cycle");
    let chain: Vec<String> = (0..3000).map(|i| format!(r#"{{"children": [{}]}}"#, i + 1)).collect();
    let deep = format!(
        r#"{{"asset": {{"version": "2.0"}}, "scenes": [{{"nodes": [0]}}], "nodes": [{}, {{}}]}}"#,
        chain.join(",")
    );
    refused(&folder.write("deep.gltf", deep.as_bytes()), "is more than 1024 levels deep");
}

#[test]
fn transforms_that_place_nothing() {
    let folder = Folder::new();
    for (key, wanted) in [
        (r#""scale": [1, 0, 1]"#, "node 1 \"leaf\": its transform has no inverse (a scale of 0"),
        (r#""rotation": [0, 0, 0, 0]"#, "node 1 \"leaf\": its rotation is zero or not finite"),
        (r#""translation": [1e400, 0, 0]"#, "number out of range"),
        (r#""scale": [1e308, 1e308, 1e308]"#, "node 1 \"leaf\": its transform"),
        (r#""matrix": [1,0,0,0, 1,0,0,0, 0,0,1,0, 0,0,0,1]"#, "its transform has no inverse"),
        (r#""matrix": [1,0,0,1, 0,1,0,0, 0,0,1,0, 0,0,0,1]"#, "its matrix does not end in 0, 0, 0, 1"),
        (r#""matrix": [1,0,0]"#, "this is not valid glTF JSON"),
        (r#""translation": ["NaN", 0, 0]"#, "this is not valid glTF JSON"),
    ] {
        refused(&folder.gltf(r#""mesh": 0"#, &format!(r#""mesh": 0, {key}"#)), wanted);
    }
}

#[test]
fn vertices_and_colours_that_are_no_numbers() {
    let folder = Folder::new();
    let path = folder.gltf("\"m\"", "\"m\"");
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        folder.write("triangle.bin", &with_float(4, bad));
        let scene = noted(&path, "mesh 0: 1 triangles left out, 1 vertices are NaN or infinite");
        assert!(scene.instances.is_empty());
        folder.write("triangle.bin", &with_float(44, bad));
        let scene = noted(&path, "1 texture coordinates or colours are NaN or infinite, set to 0");
        assert_eq!(scene.meshes[0].colors.as_ref().unwrap()[0], [0.0, 1.0, 1.0, 1.0]);
    }
    folder.write("triangle.bin", &buffer());
    for key in
        [r#""baseColorFactor": [1e400, 0, 0, 1]"#, r#""baseColorFactor": [-1, 0, 0, 1]"#, r#""roughnessFactor": 2"#]
    {
        let material = format!(r#"{{"name": "m", "pbrMetallicRoughness": {{{key}}}}}"#);
        let wanted = if key.contains("e400") { "number out of range" } else { "material 0 \"m\": `" };
        refused(&folder.gltf(r#"{"name": "m"}"#, &material), wanted);
    }
}

#[test]
fn pictures_that_lie() {
    let folder = Folder::new();
    let path = folder.gltf(TEXTURED.0, TEXTURED.1);
    refused(&path, "image 0: cannot read");
    refused(&path, "picture.png: there is no such file; check the path");
    folder.write("picture.png", &png(4, 4));
    assert_eq!(scene::load(&path).unwrap().images[0].width, 4);
    folder.write("picture.png", b"");
    refused(&path, "image picture.png is empty (0 bytes)");
    folder.write("picture.png", b"no picture at all");
    refused(&path, "image picture.png is no PNG, JPEG, WebP or HDR file");
    folder.write("picture.png", &lying_png(30_000, 30_000));
    refused(&path, "says 30000 x 30000");
    folder.write("picture.png", &lying_png(u32::MAX >> 1, 2_000_000_000));
    refused(&path, "image picture.png");
    folder.write("picture.png", &lying_png(9, 9));
    refused(&path, "image picture.png (9 x 9) does not decode");
    folder.write("picture.png", &lying_png(0, 4));
    refused(&path, "image picture.png");
    let whole = png(64, 64);
    folder.write("picture.png", &whole[..whole.len() / 2]);
    refused(&path, "does not decode");
}

#[test]
fn skies_that_are_none() {
    let folder = Folder::new();
    let scene = folder.write("sky.toml", b"[sky]\nfile = \"sky.hdr\"\n");
    refused(&scene, "sky.toml:2:8: `file` in [sky] cannot be used: cannot read");
    folder.write("sky.hdr", b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 0 +X 0\n");
    refused(&scene, "sky.hdr");
    folder.write("sky.hdr", b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 100000 +X 100000\n");
    refused(&scene, "says 100000 x 100000");
    folder.write("sky.hdr", b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 64 +X 64\nabc");
    refused(&scene, "does not decode");
}

#[test]
fn exr_pixels_that_are_no_radiance_are_counted() {
    let folder = Folder::new();
    let path = folder.0.path().join("sky.exr");
    exr::prelude::write_rgb_file(&path, 4, 2, |x, y| match (x, y) {
        (0, 0) => (f32::NAN, f32::INFINITY, -1.0),
        (1, 0) => (65_504.0, 1.0, 1.0),
        _ => (0.5, 1.0, 2.0),
    })
    .unwrap();
    let scene = folder.write("sky.toml", b"[sky]\nfile = \"sky.exr\"\n");
    let loaded = noted(&scene, "sky sky.exr: 1 NaN, 1 infinite and 1 negative values were set to 0");
    assert!(loaded.notes.iter().any(|n| n.contains("1 values are 65504")), "{:?}", loaded.notes);
    let scene::Pixels::RgbF32(pixels) = &loaded.images[0].pixels else { panic!() };
    assert_eq!(pixels[..6], [0.0, 0.0, 0.0, 65_504.0, 1.0, 1.0]);
    // Cut anywhere, it is refused.
    let whole = std::fs::read(&path).unwrap();
    for length in [4, 20, whole.len() / 2, whole.len() - 3] {
        std::fs::write(&path, &whole[..length]).unwrap();
        refused(&scene, "sky.exr");
    }
}

#[test]
fn extensions_by_what_they_ask() {
    let folder = Folder::new();
    let used = |used: &str, required: &str| {
        let text =
            format!(r#""asset": {{"version": "2.0"}}, "extensionsUsed": [{used}], "extensionsRequired": [{required}]"#);
        folder.gltf(r#""asset": {"version": "2.0"}"#, &text)
    };
    refused(
        &used(r#""KHR_draco_mesh_compression""#, r#""KHR_draco_mesh_compression""#),
        "extensionsRequired: the file requires KHR_draco_mesh_compression, which is not supported",
    );
    noted(&used(r#""A_new_one", "KHR_materials_sheen""#, ""), "optional extensions not supported, left out: A_new_one");
    refused(
        &used(r#""KHR_materials_sheen""#, r#""KHR_materials_sheen""#),
        "extensionsRequired: the file requires KHR_materials_sheen, which is not shaded yet",
    );
    noted(&used(r#""KHR_materials_sheen""#, ""), "known but not shaded yet: KHR_materials_sheen");
}

#[test]
fn patches_find_what_models_brought() {
    let folder = Folder::new();
    folder.gltf("\"m\"", "\"m\"");
    let scene =
        |text: &str| folder.write("scene.toml", format!("[[model]]\nfile = \"triangle.gltf\"\n{text}").as_bytes());
    let loaded = scene::load(&scene("translate = [0, 2, 0]\n[material.\"m\"]\nemission = 3\n")).unwrap();
    assert!(loaded.materials[0].emission.is_some());
    assert_eq!(loaded.instances[0].to_world.translation.y, 2.0);
    assert!(scene::load(&scene("[material.0]\nemission = 3\n")).unwrap().materials[0].emission.is_some());
    assert!(scene::load(&scene("[node.\"root/leaf\"]\nvisible = false\n")).unwrap().instances.is_empty());
    assert!(scene::load(&scene("[node.leaf]\nvisible = false\n")).unwrap().instances.is_empty());
    refused(
        &scene("[material.\"n\"]\nemission = 3\n"),
        "scene.toml:3:11: no model brought a material \"n\"; known are: m",
    );
    refused(&scene("[node.root]\nvisible = false\n"), "no model brought a node \"root\"");
    let twice = "[[model]]\nfile = \"triangle.gltf\"\n";
    refused(
        &scene(&format!("{twice}[material.m]\nemission = 1\n")),
        "\"m\" is both material 0 of triangle.gltf and material 0 of triangle.gltf",
    );
    refused(&scene("[material.m]\nname = \"x\"\n"), "cannot be changed by a patch");
}

/// Nothing a file can hold makes the reader panic: bytes, digits and letters of a good file are changed at random.
#[test]
fn random_damage_never_panics() {
    let folder = Folder::new();
    folder.write("picture.png", &png(8, 8));
    let text = TRIANGLE.replacen(TEXTURED.0, TEXTURED.1, 1).replace("\"uri\": \"triangle.bin\", ", "");
    let whole = glb(&text, &buffer());
    let scene =
        b"[[model]]\nfile = \"damaged.glb\"\nscale = 2\n[material.m]\nroughness = 0.5\n[sky]\nradiance = 1\n".to_vec();
    // Marsaglia 2003, xorshift.
    let mut state = 0x9e37_79b9u32;
    let mut random = |below: usize| {
        state ^= state << 13;
        state ^= state >> 17;
        state ^= state << 5;
        state as usize % below
    };
    let mut loaded = 0;
    for round in 0..4000 {
        let is_toml = round % 4 == 0;
        let mut bytes = if is_toml { scene.clone() } else { whole.clone() };
        for _ in 0..1 + random(3) {
            let at = random(bytes.len());
            bytes[at] = match random(3) {
                0 => random(256) as u8,
                1 => b"0123456789-e."[random(13)],
                _ => b"[]{}\",:\n"[random(8)],
            };
        }
        let path = if is_toml {
            folder.write("damaged.glb", &whole);
            folder.write("damaged.toml", &bytes)
        } else {
            folder.write("damaged.glb", &bytes)
        };
        match scene::load(&path) {
            Ok(mut scene) => {
                scene::frame_camera(&mut scene);
                scene::ensure_light(&mut scene);
                loaded += 1;
            }
            Err(e) => assert!(!e.to_string().contains('\n'), "{e}"),
        }
    }
    assert!((100..3900).contains(&loaded), "{loaded} of 4000 loaded");
}
