//! Real models and skies, where they are at hand.

use std::path::{Path, PathBuf};

use steradian::scene::{self, Scene, Shape};

fn models(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut open = vec![folder.join("gltf")];
    while let Some(folder) = open.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            match path.extension().and_then(|e| e.to_str()) {
                _ if path.is_dir() => open.push(path),
                Some("gltf" | "glb") => found.push(path),
                _ => {}
            }
        }
    }
    found.sort();
    found
}

#[test]
fn every_sample_model_loads() {
    let Some(folder) = super::assets_folder() else { return };
    let models = models(&folder);
    assert!(!models.is_empty());
    for path in models {
        let scene = scene::load(&path).unwrap_or_else(|e| panic!("{e}"));
        check_indices(&scene);
        let triangles: usize = scene.meshes.iter().map(|m| m.triangles.len()).sum();
        println!(
            "{}: {} instances, {triangles} triangles, {} materials, {} textures",
            scene.name,
            scene.instances.len(),
            scene.materials.len(),
            scene.textures.len()
        );
        scene.notes.iter().for_each(|n| println!("    {n}"));
        assert!(triangles > 0 && scene::bounds(&scene).is_some(), "{}", path.display());
    }
}

fn check_indices(scene: &Scene) {
    for instance in &scene.instances {
        assert!(instance.material < scene.materials.len());
        assert!(matches!(instance.shape, Shape::Mesh(m) if m < scene.meshes.len()));
    }
    for material in &scene.materials {
        assert_eq!(material.inputs.len(), steradian::bsdf::MODELS[material.bsdf].inputs.len());
    }
    for mesh in &scene.meshes {
        let count = mesh.positions.len();
        assert!(mesh.triangles.iter().flatten().all(|i| (*i as usize) < count));
        assert!(mesh.normals.as_ref().is_none_or(|n| n.len() == count));
        assert!(mesh.tangents.as_ref().is_none_or(|n| n.len() == count));
        assert!(mesh.uvs.iter().flatten().all(|n| n.len() == count));
        assert!(mesh.colors.as_ref().is_none_or(|n| n.len() == count));
    }
}

#[test]
fn every_sky_loads_and_is_no_darkness() {
    let Some(folder) = super::assets_folder() else { return };
    let mut open = vec![folder.join("hdri")];
    while let Some(folder) = open.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                open.push(path);
            } else if path.extension().is_some_and(|e| e == "hdr" || e == "exr") {
                let mut notes = Vec::new();
                match scene::format::image_file::read_sky(&path, &mut notes) {
                    Ok(image) => println!("{}: {} x {} {notes:?}", image.name, image.width, image.height),
                    // Compression methods without an open reader are refused in one sentence.
                    Err(e) => println!("{e}"),
                }
            }
        }
    }
}
