//! What glTF files may say, each read from a file made here.

use steradian::scene::{self, Choice, Value};

use crate::triangle::*;

fn load(folder: &Folder, text: &str, choice: Choice) -> Result<scene::Scene, String> {
    scene::load_choice(&folder.write("made.gltf", text.as_bytes()), choice).map_err(|e| e.to_string())
}

#[test]
fn an_unlit_material_is_emission_only() {
    let folder = Folder::new();
    let unlit = r#"{"name": "m", "extensions": {"KHR_materials_unlit": {}},
        "pbrMetallicRoughness": {"baseColorFactor": [0.25, 0.5, 1, 0.5]}, "alphaMode": "BLEND"}"#;
    let text = TRIANGLE.replacen(r#""COLOR_0": 2"#, r#""NORMAL": 2"#, 1).replacen(r#"{"name": "m"}"#, unlit, 1);
    let text = text.replacen(
        r#""version": "2.0"}"#,
        r#""version": "2.0"}, "extensionsRequired": ["KHR_materials_unlit"], "extensionsUsed": ["KHR_materials_unlit"]"#,
        1,
    );
    let scene = load(&folder, &text, Choice::default()).unwrap();
    let material = &scene.materials[0];
    assert_eq!(steradian::bsdf::MODELS[material.bsdf].keyword, "lambert");
    assert!(matches!(material.inputs[..], [Value::Constant([0.0, 0.0, 0.0, _])]));
    assert!(matches!(material.emission, Some(Value::Constant([0.25, 0.5, 1.0, 0.5]))) && material.emission_two_sided);
    assert!(matches!(material.alpha, scene::Alpha::Blend { value: Value::Constant([0.5, ..]) }));
    assert!(scene.notes.is_empty(), "{:?}", scene.notes);
}

#[test]
fn variants_are_chosen_by_name() {
    let folder = Folder::new();
    let text = TRIANGLE
        .replacen(r#"{"name": "m"}"#, r#"{"name": "m"}, {"name": "red"}, {"name": "blue"}"#, 1)
        .replacen(
            r#""material": 0}"#,
            r#""material": 0, "extensions": {"KHR_materials_variants": {"mappings": [
                {"material": 1, "variants": [0, 2]}, {"material": 2, "variants": [1]}]}}}"#,
            1,
        )
        .replacen(
            r#""scene": 0,"#,
            r#""scene": 0, "extensions": {"KHR_materials_variants": {"variants":
                [{"name": "Red"}, {"name": "Blue"}, {"name": "Also red"}, {"name": "Unmapped"}]}},"#,
            1,
        );
    let wears = |variant| load(&folder, &text, Choice { variant, scene: None }).map(|s| s.materials[0].name.clone());
    for (variant, material) in
        [(None, "m"), (Some("Red"), "red"), (Some("Blue"), "blue"), (Some("Also red"), "red"), (Some("Unmapped"), "m")]
    {
        assert_eq!(wears(variant).unwrap(), material, "{variant:?}");
    }
    let refused = wears(Some("red")).unwrap_err();
    assert!(refused.contains("none is called \"red\"; choose one of Red, Blue, Also red, Unmapped"), "{refused}");
    let scene = load(&folder, &text, Choice::default()).unwrap();
    assert_eq!(scene.variants.len(), 4);
    assert!(scene.notes.iter().any(|n| n.contains("--variant chooses one of Red, Blue")), "{:?}", scene.notes);
    let plain = load(&folder, TRIANGLE, Choice { variant: Some("Red"), scene: None }).unwrap_err();
    assert!(plain.contains("variants: has none, and \"Red\" was asked for"), "{plain}");
    // A variant that names a material which is not there.
    let broken = text.replacen(r#"{"material": 1, "#, r#"{"material": 9, "#, 1);
    let message = load(&folder, &broken, Choice { variant: Some("Red"), scene: None }).unwrap_err();
    assert!(message.contains("refers to material 9, and the file has 3"), "{message}");
    // In a .toml the choice stands in [[model]].
    let toml = |more: &str| {
        let text = format!("[[model]]\nfile = \"made.gltf\"\n{more}");
        folder.write("made.gltf", two_scenes().as_bytes());
        folder.write("made.toml", text.as_bytes())
    };
    assert_eq!(scene::load(&toml("scene = 1\n")).unwrap().instances.len(), 2);
    let message = scene::load_choice(&toml(""), Choice { variant: Some("Red"), scene: None }).unwrap_err().to_string();
    assert!(message.contains("write `variant` or `scene` in its [[model]]"), "{message}");
}

/// Two scenes: one leaf, and both leaves.
fn two_scenes() -> String {
    TRIANGLE.replacen(r#"[{"nodes": [0]}]"#, r#"[{"nodes": [0]}, {"nodes": [0, 2]}]"#, 1).replacen(
        r#"{"name": "leaf", "mesh": 0}"#,
        r#"{"name": "leaf", "mesh": 0}, {"name": "more", "mesh": 0}"#,
        1,
    )
}

#[test]
fn scenes_are_chosen_by_number() {
    let folder = Folder::new();
    let count = |scene| load(&folder, &two_scenes(), Choice { variant: None, scene }).map(|s| s.instances.len());
    assert_eq!((count(None), count(Some(0)), count(Some(1))), (Ok(1), Ok(1), Ok(2)));
    assert!(count(Some(2)).unwrap_err().contains("the choice of a scene: refers to scene 2, and the file has 2"));
}

/// Positions of zeros, two of them set by a sparse accessor with byte indices.
#[test]
fn sparse_accessors_set_single_rows() {
    let folder = Folder::new();
    let mut bytes = buffer();
    bytes.extend([1, 2, 0, 0]);
    for x in [5f32, 6., 7., 8., 9., 10.] {
        bytes.extend(x.to_le_bytes());
    }
    folder.write("triangle.bin", &bytes);
    let sparse = |index_type: u32, at: u32| {
        let parts = format!(
            r#""sparse": {{"count": 2, "indices": {{"bufferView": 3, "componentType": {index_type}}}, "values": {{"bufferView": 4}}}}"#
        );
        TRIANGLE
            .replacen(
                r#"{"bufferView": 0, "componentType": 5126, "#,
                &format!(r#"{{"componentType": 5126, {parts}, "#),
                1,
            )
            .replacen(
                r#""byteOffset": 44, "byteLength": 36}"#,
                &format!(
                    r#""byteOffset": 44, "byteLength": 36}}, {{"buffer": 0, "byteOffset": {at}, "byteLength": 2}},
                       {{"buffer": 0, "byteOffset": 84, "byteLength": 24}}"#
                ),
                1,
            )
            .replace(r#""byteLength": 80"#, r#""byteLength": 108"#)
    };
    let scene = load(&folder, &sparse(5121, 80), Choice::default()).unwrap();
    assert_eq!(scene.meshes[0].positions, [[0.0; 3], [5.0, 6.0, 7.0], [8.0, 9.0, 10.0]]);
    // The byte of a colour, 63, is no row.
    let message = load(&folder, &sparse(5121, 46), Choice::default()).unwrap_err();
    assert!(message.contains("sparse index 128 is beyond its 3 rows"), "{message}");
    let message = load(&folder, &sparse(5125, 80), Choice::default()).unwrap_err();
    assert!(message.contains("2 rows of 4 bytes, 4 apart from offset 0, do not fit the 2 bytes"), "{message}");
}

/// KHR_mesh_quantization: positions as 16-bit integers, normalised or not, placed by the node's scale.
#[test]
fn quantised_positions_are_their_integers() {
    let folder = Folder::new();
    let mut bytes = Vec::new();
    for x in [0i16, 0, 0, 0, 32767, 0, 0, 0, -32768, 16384, 0, 0] {
        bytes.extend(x.to_le_bytes());
    }
    bytes.resize(36, 0);
    bytes.extend(&buffer()[36..]);
    folder.write("triangle.bin", &bytes);
    let text = |normalized: bool| {
        TRIANGLE
            .replacen(r#""componentType": 5126"#, &format!(r#""componentType": 5122, "normalized": {normalized}"#), 1)
            .replacen(r#""byteLength": 36"#, r#""byteLength": 36, "byteStride": 8"#, 1)
            .replacen(
                r#""version": "2.0"}"#,
                r#""version": "2.0"}, "extensionsRequired": ["KHR_mesh_quantization"]"#,
                1,
            )
    };
    let positions = |n| load(&folder, &text(n), Choice::default()).unwrap().meshes[0].positions.clone();
    assert_eq!(positions(true), [[0.0; 3], [1.0, 0.0, 0.0], [-1.0, 16384.0 / 32767.0, 0.0]]);
    assert_eq!(positions(false), [[0.0; 3], [32767.0, 0.0, 0.0], [-32768.0, 16384.0, 0.0]]);
}

/// Every mode of a primitive: triangles, strips and fans of the same four corners cover a square; the rest is said.
#[test]
fn primitive_modes() {
    let folder = Folder::new();
    let mut bytes = Vec::new();
    for x in [0f32, 0., 0., 1., 0., 0., 0., 1., 0., 1., 1., 0.] {
        bytes.extend(x.to_le_bytes());
    }
    bytes.extend([0u8, 1, 2, 3, 0, 1, 3, 2]);
    folder.write("square.bin", &bytes);
    let text = |mode: u32, offset: u32| {
        format!(
            r#"{{"asset": {{"version": "2.0"}}, "scenes": [{{"nodes": [0]}}], "nodes": [{{"mesh": 0}}],
            "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}, "indices": 1, "mode": {mode}}}]}}],
            "accessors": [{{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"}},
                {{"bufferView": 1, "componentType": 5121, "count": 4, "type": "SCALAR"}}],
            "bufferViews": [{{"buffer": 0, "byteLength": 48}}, {{"buffer": 0, "byteOffset": {offset}, "byteLength": 4}}],
            "buffers": [{{"uri": "square.bin", "byteLength": 56}}]}}"#
        )
    };
    for (mode, offset, triangles) in [(5, 48, 2), (6, 52, 2), (4, 48, 1)] {
        let scene = load(&folder, &text(mode, offset), Choice::default()).unwrap();
        let mesh = &scene.meshes[0];
        assert_eq!(mesh.triangles.len(), triangles, "mode {mode}");
        for t in &mesh.triangles {
            let [a, b, c] = t.map(|i| mesh.positions[i as usize]);
            let twice_area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
            assert_eq!(twice_area, 1.0, "mode {mode} {t:?}: the front is +z");
        }
    }
    for (mode, word) in [(0, "points"), (1, "lines"), (2, "lines"), (3, "lines")] {
        let scene = load(&folder, &text(mode, 48), Choice::default()).unwrap();
        assert!(scene.instances.is_empty() && scene.notes[0].contains(word), "{:?}", scene.notes);
    }
    assert!(load(&folder, &text(7, 48), Choice::default()).unwrap_err().contains("mode 7 does not exist"));
}
