use std::path::Path;

use super::parse;
use crate::scene::{Scene, Shape, Value};

fn read(text: &str) -> Result<Scene, String> {
    parse(text, Path::new("test.toml")).map_err(|e| e.to_string())
}

#[test]
fn every_scene_of_the_project_loads() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let ignored = include_str!("../../../../.gitignore").lines();
    let generated: Vec<&str> = ignored.filter_map(|l| l.strip_prefix("/scenes/")).collect();
    let mut count = 0;
    let mut folders = vec![folder];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "toml") {
                // A few large files are made by `steradian generate` and not kept.
                let text = std::fs::read_to_string(&path).unwrap();
                let is_missing = |file: &str| text.contains(file) && !path.with_file_name(file).exists();
                if let Some(file) = generated.iter().find(|file| is_missing(file)) {
                    println!("skipped: {} needs {file}, which `steradian generate` makes", path.display());
                    continue;
                }
                if text.contains("STERADIAN_ASSETS") && std::env::var_os("STERADIAN_ASSETS").is_none() {
                    println!("skipped: no assets for {}", path.display());
                    continue;
                }
                crate::scene::load(&path).unwrap_or_else(|e| panic!("{e}"));
                count += 1;
            }
        }
    }
    assert!(count >= 20, "{count}");
}

#[test]
fn a_wrong_file_is_one_sentence_with_its_place() {
    for (text, wanted) in [
        (
            "[camera]\npostion = [0, 0, 1]\n",
            "test.toml:2:1: unknown key `postion` in [camera]; did you mean `position`?",
        ),
        ("[camera\n", "test.toml:1:8: this is not TOML"),
        ("camra = 1\n", "test.toml:1:1: unknown key `camra` in top level; did you mean `camera`?"),
        (
            "[camera]\nposition = [0, 0]\n",
            "test.toml:2:12: `position` in [camera] must be 3 numbers in [ ], and is 2 of them",
        ),
        ("[camera]\nposition = [0, nan, 0]\n", "test.toml:2:16: `position` in [camera] must be a finite number"),
        ("[camera]\nposition = [1, 0, inf]\n", "must be a finite number"),
        (
            "[camera]\nposition = [0, 0, 1]\nfov_y_deg = 180\n",
            "test.toml:3:13: `fov_y_deg` in [camera] must be above 0 and below 180",
        ),
        ("[camera]\nposition = [0, 1, 0]\n", "`up` in [camera] points along the view"),
        ("[film]\nsize = [0, 10]\n", "test.toml:2:8: `size` in [film] must be two whole numbers"),
        (
            "[film]\ncrop = [0, 0, 700, 10]\n",
            "test.toml:2:8: `crop` in [film] 0,0,700,10 reaches out of the image of 640x480",
        ),
        ("[film]\niso = 100\nshutter_s = 0.1\n", "[film] has no `f_number`; add it"),
        ("[film]\niso = 0\nshutter_s = 0.1\nf_number = 1\n", "`iso` in [film] must lie from"),
        ("[film]\ncrop = [3, 3, 3, 4]\n", "holds no pixel"),
        ("[film]\ncrop = [0.5, 0, 3, 4]\n", "four whole numbers"),
        ("[film]\nfilter = \"gauss\"\n", "is \"gauss\", which is no filter; did you mean `gaussian`?"),
        (
            "[film]\nfilter_radius = 0\n",
            "test.toml:2:17: `filter_radius` in [film] must be above 0 and at most 32 pixels",
        ),
        ("[sky]\nradiance = -1\n", "must not be negative"),
        ("[sky]\nfile = \"none.hdr\"\n", "there is no such file"),
        (
            "[[texture]]\nname = \"t\"\nfile = \"none.png\"\n",
            "test.toml:3:8: `file` in [[texture]] cannot be used: cannot read none.png: there is no such file",
        ),
        (
            "[[material]]\nname = \"m\"\ntype = \"lambrt\"\n",
            "test.toml:3:8: `type` in [[material]] is \"lambrt\", which is no material type; did you mean `lambert`?",
        ),
        (
            "[[material]]\nname = \"m\"\nalbdo = 1\n",
            "test.toml:3:1: unknown key `albdo` in [[material]]; of type \"lambert\"; did you mean `albedo`?",
        ),
        (
            "[[material]]\nname = \"m\"\nalbedo = { textur = \"t\" }\n",
            "test.toml:3:12: unknown key `textur` in value; did you mean `texture`?",
        ),
        (
            "[[material]]\nname = \"m\"\nalbedo = { texture = \"t\" }\n",
            "test.toml:3:22: `texture` in value is \"t\", which the file does not define",
        ),
        ("[[shape]]\ntype = \"spher\"\n", "test.toml:2:8: a [[shape]] without a known type"),
        ("[[shape]]\ntype = \"sphere\"\nradius = -1\n", "must be above 0 m"),
        (
            "[[shape]]\ntype = \"sphere\"\nscale = [1, 2, 1]\n",
            "test.toml:3:9: `scale` in [[shape]] type = \"sphere\" would make the sphere an ellipsoid",
        ),
        ("[[shape]]\ntype = \"sphere\"\nscale = 0\n", "gives a transform without an inverse"),
        (
            "[[shape]]\ntype = \"mesh\"\npositions = [[0,0,0]]\ntriangles = [[0,1,2]]\n",
            "test.toml:4:13: `triangles` in [[shape]] type = \"mesh\" has the vertex 1, and there are 1",
        ),
        ("[[shape]]\ntype = \"rectangle\"\nu = [1,0,0]\nv = [2,0,0]\n", "span no area"),
        (
            "[[model]]\nfile = \"none.glb\"\n",
            "test.toml:2:8: `file` in [[model]] cannot be used: cannot read none.glb: there is no such file",
        ),
        ("[material.\"Gold\"]\nalbedo = 1\n", "test.toml:1:11: no model brought a material \"Gold\""),
        ("[node.\"a/b\"]\nvisible = false\n", "test.toml:1:7: no model brought a node \"a/b\""),
        ("[shape]\ntype = \"sphere\"\n", "write [[shape]] in two brackets"),
    ] {
        let message = read(text).expect_err(text);
        assert!(message.contains(wanted), "\n{text}\nwanted: {wanted}\nfound:  {message}");
        assert!(!message.contains('\n'), "{message}");
    }
}

#[test]
fn keys_reach_the_scene() {
    let scene = read(
        "name = \"n\"\n[camera]\nposition=[0,0,5]\nfov_y_deg=90\n[film]\nsize=[3,2]\nspp=7\nmax_depth=2\n[sky]\nradiance=[1,2,3]\nscale=2\n\
         [[texture]]\nname=\"c\"\ntype=\"checker\"\nsquares=[1,2]\n\
         [[material]]\nname=\"m\"\nalbedo={texture=\"c\", channel=\"g\", factor=0.5}\nalpha=0.5\nemission=3\n\
         [[shape]]\ntype=\"box\"\nmaterial=\"m\"\ntranslate=[1,0,0]\n\
         [[shape]]\ntype=\"sphere\"\ncenter=[0,2,0]\nradius=3\nscale=2\n",
    )
    .unwrap();
    assert_eq!((scene.film.width, scene.film.height, scene.film.spp, scene.film.max_depth), (3, 2, Some(7), Some(2)));
    let crate::scene::Projection::Perspective { fov_y_rad } = scene.camera.projection else { panic!("perspective") };
    assert!(scene.camera.is_placed && (fov_y_rad - std::f64::consts::FRAC_PI_2).abs() < 1e-15);
    assert_eq!(scene.materials.len(), 2);
    let Value::Multiply(_, inner) = &scene.materials[0].inputs[0] else { panic!("{:?}", scene.materials[0]) };
    assert!(matches!(**inner, Value::Channel(_, 1)));
    let Shape::Mesh(mesh) = scene.instances[0].shape else { panic!() };
    // Every box triangle faces away from the middle.
    let mesh = &scene.meshes[mesh];
    for t in &mesh.triangles {
        let [a, b, c] = t.map(|i| glam::Vec3::from(mesh.positions[i as usize]));
        assert!((b - a).cross(c - a).dot(a) > 0.0, "{t:?}");
    }
    let sphere = scene.instances[1].to_world;
    assert_eq!(sphere.translation, glam::DVec3::new(0.0, 4.0, 0.0));
    assert_eq!(sphere.matrix3.x_axis.length(), 6.0);
}

#[test]
fn a_patch_after_a_material_is_no_key_of_it() {
    let message = read("[[material]]\nname=\"a\"\nalbedo=1\n[material.\"Gold\"]\nalbedo=0.5\n").unwrap_err();
    assert!(message.contains("no model brought a material \"Gold\""), "{message}");
}

#[test]
fn a_quarter_turn_of_the_coordinates() {
    // The example of KHR_texture_transform: the lower left quadrant of the picture, v running down.
    let t = super::uv_transform(glam::DVec2::new(0.0, 1.0), std::f64::consts::FRAC_PI_2, glam::DVec2::splat(0.5));
    for (uv, wanted) in
        [((0.0, 0.0), (0.0, 1.0)), ((1.0, 0.0), (0.0, 0.5)), ((0.0, 1.0), (0.5, 1.0)), ((1.0, 1.0), (0.5, 0.5))]
    {
        let found = t.transform_point2(uv.into());
        assert!((found - glam::DVec2::from(wanted)).length() < 1e-12, "{uv:?}: {found}");
    }
}

#[test]
fn a_normal_map_brings_tangents() {
    let map = "[[texture]]\nname=\"n\"\ntype=\"constant\"\ncolor=[0.5,0.5,1]\n\
        [[material]]\nname=\"m\"\nnormal_map={texture=\"n\", strength=2}\n[[shape]]\ntype=\"box\"\nmaterial=\"m\"\n";
    let scene = read(map).unwrap();
    assert_eq!(scene.meshes[0].tangents.as_ref().map(Vec::len), Some(24));
    let scene = read(&map.replace("box", "rectangle")).unwrap();
    assert_eq!(scene.meshes[0].tangents, Some(vec![[1.0, 0.0, 0.0, 1.0]; 4]));
    let message = read(&map.replace("strength=2", "factor=2")).unwrap_err();
    assert!(message.contains("takes neither `channel` nor `factor`"), "{message}");
}
