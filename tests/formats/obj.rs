//! .obj and .mtl: what is read, and what is refused in one sentence.

use steradian::bsdf::MODELS;
use steradian::scene::{self, Alpha, Mesh, Scene, Shape, Texture, Value};

use crate::bad::{noted, refused};
use crate::damage::damaged;
use crate::triangle::{Folder, png};

const QUAD: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

fn load(folder: &Folder, text: &str) -> Scene {
    scene::load(&folder.write("a.obj", text.as_bytes())).unwrap_or_else(|e| panic!("{e}\n{text}"))
}

fn material(folder: &Folder, library: &str) -> (Scene, steradian::scene::Material) {
    folder.write("a.mtl", library.as_bytes());
    let scene = load(folder, &format!("mtllib a.mtl\n{QUAD}usemtl m\nf 1 2 3\n"));
    let material = scene.materials[0].clone();
    (scene, material)
}

fn area(mesh: &Mesh) -> f32 {
    let at = |i: u32| glam::Vec3::from(mesh.positions[i as usize]);
    mesh.triangles.iter().map(|&[a, b, c]| 0.5 * (at(b) - at(a)).cross(at(c) - at(a)).length()).sum()
}

#[test]
fn faces_by_every_way_to_name_a_corner() {
    let folder = Folder::new();
    for face in [
        "f 1 2 3 4",
        "f -4 -3 -2 -1",
        "f 1// 2// 3// 4//",
        "f 1 2 \\\n3 4",
        "f 1 2 3 4 # a comment",
        "f 1 2 3\nf 1 3 4",
    ] {
        let scene = load(&folder, &format!("{QUAD}{face}"));
        let mesh = &scene.meshes[0];
        assert_eq!((mesh.positions.len(), mesh.triangles.len(), area(mesh)), (4, 2, 1.0), "{face}");
        assert!(mesh.normals.is_none() && mesh.uvs[0].is_none(), "{face}");
    }
    let scene = load(&folder, &format!("{QUAD}vt 0.25 0.25\nvn 0 0 2\nf 1/1/1 2/1/1 3/-1/-1\n"));
    let mesh = &scene.meshes[0];
    // v of a texture runs up in the file and down here.
    assert_eq!(mesh.uvs[0].as_ref().unwrap()[0], [0.25, 0.75]);
    assert_eq!(mesh.normals.as_ref().unwrap()[0], [0.0, 0.0, 2.0]);
    // An L: a fan from its first corner would cover what is not there.
    let l = "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\nf 2 3 4 5 6 1\n";
    assert_eq!(area(&load(&folder, l).meshes[0]), 3.0);
}

#[test]
fn groups_and_materials_part_the_faces() {
    let folder = Folder::new();
    let text = format!(
        "{QUAD}o body\ng left\nusemtl a\nf 1 2 3\nusemtl b\nf 1 3 4\ng right\nf 1 2 3\ng left\nusemtl a\nf 1 2 4\n"
    );
    let scene = load(&folder, &text);
    let names: Vec<&str> = scene.instances.iter().map(|i| i.name.as_str()).collect();
    assert_eq!(names, ["left", "left", "right"]);
    let triangles: Vec<usize> = scene.meshes.iter().map(|m| m.triangles.len()).collect();
    assert_eq!((triangles, scene.materials.len()), (vec![2, 1, 1], 2));
    noted(&folder.write("a.obj", text.as_bytes()), "material \"a\" is not in the material library");
    noted(&folder.write("a.obj", format!("mtllib no.mtl\n{QUAD}f 1 2 3").as_bytes()), "no.mtl cannot be read");
    noted(&folder.write("a.obj", format!("{QUAD}l 1 2\np 1\nf 1 2 3").as_bytes()), "1 lines left out");
    // Patches find groups and materials.
    let toml = "[[model]]\nfile = \"a.obj\"\n[node.right]\nvisible = false\n[material.a]\nalbedo = 0.1\n";
    folder.write("a.obj", text.as_bytes());
    let scene = scene::load(&folder.write("a.toml", toml.as_bytes())).unwrap();
    assert_eq!(scene.instances.len(), 2);
    assert!(matches!(scene.materials[0].inputs[0], Value::Constant([0.1, ..])));
    // As a shape, a file brings its surface and nothing else.
    let toml = "[[material]]\nname = \"m\"\n[[shape]]\ntype = \"mesh\"\nfile = \"a.obj\"\nmaterial = \"m\"\ntranslate = [0, 0, 7]\n";
    let scene = scene::load(&folder.write("a.toml", toml.as_bytes())).unwrap();
    assert_eq!((scene.instances.len(), scene.materials.len(), scene.notes.len()), (3, 1, 0));
    assert!(scene.instances.iter().all(|i| i.to_world.translation.z == 7.0 && matches!(i.shape, Shape::Mesh(_))));
}

/// A roof of two faces: its ridge is smooth within one group, sharp across two and where smoothing is off.
#[test]
fn smoothing_groups_make_normals() {
    let folder = Folder::new();
    let roof = "v 0 0 0\nv 0 0 1\nv 1 1 0\nv 1 1 1\nv 2 0 0\nv 2 0 1\n";
    let ridge = |text: &str| -> Vec<[f32; 3]> {
        let scene = load(&folder, &format!("{roof}{text}"));
        let mesh = &scene.meshes[0];
        let Some(normals) = &mesh.normals else { return Vec::new() };
        let is_ridge = |i: &usize| mesh.positions[*i][0] == 1.0;
        (0..mesh.positions.len()).filter(is_ridge).map(|i| normals[i]).collect()
    };
    let smooth = ridge("s 1\nf 1 2 4 3\nf 3 4 6 5\n");
    assert_eq!(smooth.len(), 2);
    assert!(smooth.iter().all(|n| (n[1] - 1.0).abs() < 1e-6 && n[0].abs() < 1e-6), "{smooth:?}");
    assert_eq!(ridge("s 1\nf 1 2 4 3\ns 2\nf 3 4 6 5\n").len(), 4);
    let mixed = ridge("s off\nf 1 2 4 3\ns 2\nf 3 4 6 5\n");
    assert!(mixed.len() == 4 && mixed.iter().all(|n| (n[0].abs() - 0.5f32.sqrt()).abs() < 1e-6), "{mixed:?}");
    assert!(ridge("f 1 2 4 3\nf 3 4 6 5\n").is_empty());
}

#[test]
fn materials_become_the_nearest_surface() {
    let folder = Folder::new();
    let model = |m: &scene::Material| MODELS[m.bsdf].keyword;
    let input = |m: &scene::Material, name: &str| -> [f64; 4] {
        let at = MODELS[m.bsdf].inputs.iter().position(|i| i.name == name).unwrap();
        let Value::Constant(c) = m.inputs[at] else { panic!("{:?}", m.inputs[at]) };
        c
    };
    let (_, m) = material(&folder, "newmtl m\nKd 0.2 0.4 0.6\nKa 1 1 1\nd 1\n");
    assert_eq!((model(&m), &input(&m, "albedo")[..3]), ("lambert", &[0.2, 0.4, 0.6][..]));
    let (_, m) = material(&folder, "newmtl m\nKd 0.2 0.4 0.6\nKs 1 1 1\nNs 198\nNi 1.45\nillum 2\n");
    assert_eq!((model(&m), input(&m, "ior")[0]), ("gltf", 1.45));
    // alpha = sqrt(2/200) = 0.1.
    assert!((input(&m, "roughness")[0] - 0.1f64.sqrt()).abs() < 1e-12);
    let (_, m) = material(&folder, "newmtl m\nKd 0 0 0\nKs 0.9 0.8 0.7\nillum 3\n");
    assert_eq!((model(&m), input(&m, "metallic")[0], input(&m, "base_color")[1]), ("gltf", 1.0, 0.8));
    let (_, m) = material(&folder, "newmtl m\nNi 1.33\nillum 7\nd 0.2\n");
    assert_eq!((model(&m), input(&m, "eta")[0], matches!(m.alpha, Alpha::Opaque)), ("dielectric", 1.33, true));
    let (_, m) = material(&folder, "newmtl m\nKe 3 2 1\nTr 0.25\n");
    assert!(matches!(m.emission, Some(Value::Constant([3.0, 2.0, 1.0, _]))));
    let Alpha::Blend { value: Value::Channel(value, 0) } = &m.alpha else { panic!("{:?}", m.alpha) };
    assert!(matches!(**value, Value::Constant([0.75, ..])));
    folder.write("my picture.png", &png(4, 4));
    let (scene, m) = material(&folder, "newmtl m\nKd 1 1 1\nmap_Kd -s 2 3 1 -o 0.5 0.25 -clamp on my picture.png\n");
    let Value::Texture { texture, uv_transform, .. } = &m.inputs[0] else { panic!("{:?}", m.inputs[0]) };
    assert!(matches!(scene.textures[*texture], Texture::Image { wrap: [scene::Wrap::Clamp, scene::Wrap::Clamp], .. }));
    // (u, v) = (0.5, 0.5) up: (1.5, 1.75) up, which is -0.75 down.
    assert_eq!(uv_transform.transform_point2((0.5, 0.5).into()), glam::DVec2::new(1.5, -0.75));
    let path = folder.write("a.obj", format!("mtllib a.mtl\n{QUAD}usemtl m\nf 1 2 3\n").as_bytes());
    folder.write("a.mtl", b"newmtl m\nKx 3\nbump a.png\n");
    noted(&path, "keys of the material library left out: Kx, bump");
    for (line, wanted) in [
        ("Kd 1 nan 1", "a.mtl:2:1: `Kd` must be three numbers from 0 to 1"),
        ("Kd -1 0 0", "`Kd` must be three numbers"),
        ("Ke 1e400 0 0", "`Ke` must be three numbers"),
        ("Ns -3", "`Ns` must be a number from 0"),
        ("Ni", "`Ni` must be a number from 0 to 10"),
        ("map_Kd none.png", "none.png: there is no such file"),
        ("map_Kd", "it is a directory"),
    ] {
        folder.write("a.mtl", format!("newmtl m\n{line}\n").as_bytes());
        refused(&path, wanted);
    }
}

#[test]
fn bad_lines_are_named() {
    let folder = Folder::new();
    for (text, wanted) in [
        ("f 1 2 9", "a.obj:5:7: refers to vertex 9, and 4 stand before it"),
        ("f 0 1 2", "a.obj:5:3: refers to vertex 0"),
        ("f -5 1 2", "refers to vertex -5, and 4 stand before it"),
        ("f 1/1 2/1 3/1", "refers to texture coordinate 1, and 0 stand before it"),
        ("f 1//1 2//1 3//1", "refers to normal 1"),
        ("f 1 2", "a.obj:5:1: a face needs 3 corners and has 2; the line is cut or wrong"),
        ("f 1 2 x", "a.obj:5:7: \"x\" is no index of vertex"),
        ("f / / /", "a corner without a vertex"),
        ("f 99999999999999999999 1 2", "is no index of vertex"),
        ("v 1 2", "a vertex needs 3 numbers and has 2; the line is cut or wrong"),
        ("v 1 2 three", "a.obj:5:7: \"three\" is no number"),
        ("s smooth", "\"smooth\" is no smoothing group"),
        ("v 1 2 3", "holds no triangle that can be seen"),
        ("f 1 1 1\nv nan 0 0\nf 5 1 2", "holds no triangle"),
    ] {
        let wanted_later = wanted == "holds no triangle";
        if wanted_later {
            // What is only partly unusable is taken without that part, and said.
            let text = format!("{QUAD}v nan 0 0\nf 5 1 2\nf 1 2 3\n");
            noted(&folder.write("a.obj", text.as_bytes()), "1 triangles left out, 1 vertices are NaN or infinite");
            refused(&folder.write("a.obj", b"v nan 0 0\nv 0 0 0\nv 1 0 0\nf 1 2 3\n"), wanted);
            continue;
        }
        refused(&folder.write("a.obj", format!("{QUAD}{text}").as_bytes()), wanted);
    }
    let many = (0..5000).map(|i| (i % 4 + 1).to_string()).collect::<Vec<_>>().join(" ");
    let path = folder.write("a.obj", format!("{QUAD}f {many}").as_bytes());
    refused(&path, "a.obj:5:1: a face of 5000 corners, and 4096 are the most; cut it into smaller ones");
    refused(&folder.write("a.obj", b""), "holds no triangle");
    refused(&folder.write("a.obj", b"glTF\0\0\0"), "holds bytes that are no text");
    refused(
        &folder.write("a.toml", b"[[shape]]\ntype = \"mesh\"\nfile = \"none.obj\"\n"),
        "a.toml:3:8: `file` in [[shape]]",
    );
    refused(
        &folder.write("a.toml", b"[[shape]]\ntype = \"mesh\"\nfile = \"none.glb\"\n"),
        "must be an .obj or .ply file",
    );
    refused(
        &folder.write("a.toml", b"[[model]]\nfile = \"$NO_SUCH_FOLDER/a.obj\"\n"),
        "NO_SUCH_FOLDER, which is not set",
    );
    refused(
        &folder.write("a.toml", b"[[shape]]\ntype = \"mesh\"\nfile = \"a.obj\"\nuvs = [[0, 0]]\n"),
        "`uvs` in [[shape]] type = \"mesh\" stands beside `file`",
    );
}

#[test]
fn random_damage_never_panics() {
    let folder = Folder::new();
    folder.write("p.png", &png(4, 4));
    let library = b"newmtl m\nKd 0.5 0.5 0.5\nKs 1 1 1\nNs 30\nd 0.5\nmap_Kd -s 2 2 p.png\nillum 2\n";
    let model = format!(
        "mtllib a.mtl\n{QUAD}vt 0 0\nvt 1 1\nvn 0 0 1\no b\ng c\nusemtl m\ns 1\nf 1/1/1 2/2/1 3/1/1 4/2\nf -1 -2 -3\n"
    );
    let loaded = damaged(3000, &[library, model.as_bytes()], |parts| {
        folder.write("a.mtl", &parts[0]);
        folder.write("a.obj", &parts[1])
    });
    assert!((300..2900).contains(&loaded), "{loaded} of 3000 loaded");
}

#[test]
fn a_real_cow() {
    let Some(folder) = super::assets_folder() else { return };
    let mut scene = scene::load(&folder.join("meshes/spot.obj")).unwrap();
    let mesh = &scene.meshes[0];
    assert_eq!((scene.meshes.len(), mesh.triangles.len()), (1, 5856));
    assert!(mesh.uvs[0].is_some() && mesh.normals.is_none(), "no normals and no smoothing: flat");
    // Closed: each edge is there once in each direction, by place.
    let mut edges = std::collections::HashMap::new();
    let key = |i: u32| mesh.positions[i as usize].map(f32::to_bits);
    for t in &mesh.triangles {
        for k in 0..3 {
            *edges.entry((key(t[k]), key(t[(k + 1) % 3]))).or_insert(0) += 1;
        }
    }
    assert!(edges.iter().all(|((a, b), n)| *n == 1 && edges.contains_key(&(*b, *a))));
    scene::frame_camera(&mut scene);
    assert!(scene.camera.is_placed);
}
