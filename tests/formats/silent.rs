//! What would have no effect, or one that nobody can mean, is an error or a note with its place; never accepted in silence.

use crate::bad::{noted, refused};
use crate::triangle::*;

/// A scene file's text and what is said of it.
type Case = (&'static str, &'static str);

#[test]
fn toml_values_without_effect_or_sense_are_errors() {
    let folder = Folder::new();
    let cases: &[Case] = &[
        (
            "[[material]]\nname = \"m\"\nabsorption = 3\n",
            "a.toml:3:14: `absorption` in [[material]] is of what lies behind a surface that refracts",
        ),
        (
            "[[material]]\nname = \"m\"\npriority = 3\n",
            "a.toml:3:12: `priority` in [[material]] is of what lies behind",
        ),
        ("[[material]]\nname = \"m\"\ntype = \"thin_dielectric\"\nabsorption = 3\n", "a.toml:4:14: `absorption`"),
        ("[[material]]\nname = \"m\"\ntype = \"gltf\"\npriority = 3\n", "a.toml:4:12: `priority`"),
        (
            "[[material]]\nname = \"m\"\ntype = \"dielectric\"\nemission = 1\npriority = 3\n",
            "a.toml:5:12: `priority` in [[material]] has no meaning on a surface that shines",
        ),
        (
            "[[material]]\nname = \"m\"\ntype = \"dielectric\"\nabsorption = 1e300\n",
            "a.toml:4:14: `absorption` in [[material]] must lie from 0 to 1e20 1/m",
        ),
        ("[[material]]\nname = \"m\"\nalpha = -1\n", "a.toml:3:9: `alpha` in [[material]] must lie from 0 to 1"),
        ("[[material]]\nname = \"m\"\nalpha = 2\n", "a.toml:3:9: `alpha` in [[material]] must lie from 0 to 1"),
        ("[[material]]\nname = \"m\"\nalpha = 1\nalpha_cutoff = 2\n", "a.toml:4:16: `alpha_cutoff`"),
        (
            "[[texture]]\nname = \"t\"\ntype = \"checker\"\n[[material]]\nname = \"m\"\n\
             alpha = { texture = \"t\", factor = -1 }\n",
            "a.toml:6:9: `alpha` in [[material]] must lie from 0 to 1",
        ),
        (
            "[[texture]]\nname = \"t\"\ntype = \"checker\"\na = 2\n[[material]]\nname = \"m\"\n\
             albedo = { texture = \"t\" }\n",
            "a.toml:7:10: `albedo` in [[material]] must lie from 0 to 1",
        ),
        (
            "[[material]]\nname = \"m\"\nemission = 1e300\n",
            "a.toml:3:12: `emission` in [[material]] comes to a radiance of 1.000e300 W/(m2 sr), and 1e18 is the most",
        ),
        ("[[material]]\nname = \"m\"\nemission_nt = 1e300\n", "a.toml:3:15: `emission_nt` in [[material]] comes to"),
        (
            "[[texture]]\nname = \"t\"\ntype = \"checker\"\n[[material]]\nname = \"m\"\n\
             emission = { texture = \"t\", factor = 1e30 }\n",
            "a.toml:6:12: `emission` in [[material]] comes to a radiance of",
        ),
        (
            "[[texture]]\nname = \"t\"\ntype = \"checker\"\n[[material]]\nname = \"m\"\n\
             emission = { texture = \"t\", factor = -1 }\n",
            "a.toml:6:12: `emission` in [[material]] must not be negative",
        ),
        (
            "[[material]]\nname = \"m\"\nemission = 0\n[[shape]]\ntype = \"sphere\"\nmaterial = \"m\"\npower = 5\n",
            "a.toml:7:9: `power` in [[shape]] type = \"sphere\" scales the emission of its material, which is black",
        ),
        (
            "[[shape]]\ntype = \"sphere\"\npower = 1e300\n",
            "a.toml:3:9: `power` in [[shape]] type = \"sphere\" comes to",
        ),
        (
            "[[light]]\ntype = \"point\"\nposition = [0, 0, 0]\nintensity = 1e300\n",
            "a.toml:4:13: `intensity` in [[light]] type = \"point\" comes to 1.000e300",
        ),
        ("[sky]\nradiance = 1e300\n", "a.toml:2:12: `radiance` in [sky] comes to 1.000e300"),
        ("[sky]\nradiance = 1e10\nscale = 1e10\n", "a.toml:3:9: `scale` in [sky] makes the sky's radiance 1.000e20"),
        ("[sky]\nradiance = 1\nrotate_deg = 90\n", "a.toml:3:14: `rotate_deg` in [sky] turns the picture of `file`"),
        (
            "[[shape]]\ntype = \"sphere\"\ncopies = [{}, { scale = [1, 2, 1] }]\n",
            "a.toml:3:25: `scale` in copy would make the sphere an ellipsoid",
        ),
        (
            "[[shape]]\ntype = \"disc\"\ncopies = [\n{ matrix = [1,0,0,0, 0,2,0,0, 0,0,1,0, 0,0,0,1] }]\n",
            "a.toml:4:12: `matrix` in copy would make the disc an ellipse",
        ),
        (
            "[[texture]]\nname = \"t\"\ntype = \"checker\"\nfile = \"a.png\"\n",
            "a.toml:4:8: `file` in [[texture]] is no key of a texture of type \"checker\"",
        ),
        (
            "[[material]]\nname = \"m\"\ntype = \"conductor\"\neta = { metal = \"gold\", factor = 2 }\n",
            "a.toml:4:34: `factor` in value has no meaning beside `metal`",
        ),
        (
            "[[material]]\nname = \"m\"\nalbedo = { vertex_color = true, uv_set = 1 }\n",
            "a.toml:3:42: `uv_set` in value has no meaning beside `vertex_color`",
        ),
    ];
    for (text, wanted) in cases {
        refused(&folder.write("a.toml", text.as_bytes()), wanted);
    }
    folder.write("two.txt", b"1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 0 0 1 0 0 0 0 3 0\n");
    refused(
        &folder.write("a.toml", b"[[shape]]\ntype = \"sphere\"\ncopies_file = \"two.txt\"\n"),
        "a.toml:3:15: `copies_file` in [[shape]] type = \"sphere\" cannot be used: two.txt line 2 would make the sphere",
    );
}

#[test]
fn what_is_dark_or_empty_by_its_numbers_is_noted() {
    let folder = Folder::new();
    let cases: &[Case] = &[
        (
            "[[shape]]\ntype = \"sphere\"\npower = 0\n",
            "a.toml:3:9: `power` in [[shape]] type = \"sphere\" is 0: the shape is dark",
        ),
        (
            "[[shape]]\nname = \"none\"\ntype = \"mesh\"\npositions = [[0, 0, 0]]\ntriangles = []\n",
            "a.toml:1:1: the mesh \"none\" has no triangle: nothing of it is seen",
        ),
    ];
    for (text, wanted) in cases {
        noted(&folder.write("a.toml", text.as_bytes()), wanted);
    }
    let obj = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv nan 0 0\ng seen\nf 1 2 3\ng gone\nf 1 2 4\n";
    noted(&folder.write("a.obj", obj), "group \"gone\": no triangle in it, left out");
}

/// A colour in three numbers does not need one of the material.
#[test]
fn a_black_lamp_with_a_colour_of_its_own_shines() {
    let folder = Folder::new();
    let text = b"[[material]]\nname = \"m\"\nemission = 0\n[[shape]]\ntype = \"sphere\"\nmaterial = \"m\"\npower = [1, 2, 3]\n";
    let scene = steradian::scene::load(&folder.write("a.toml", text)).unwrap();
    assert!(scene.materials[scene.instances[0].material].emits() && scene.notes.is_empty());
}

/// What a mesh or an image decides is held to its sign only: it may never be 0 where its range ends above 0.
#[test]
fn an_index_by_vertex_colour_is_no_error() {
    let folder = Folder::new();
    let glass =
        "[[material]]\nname = \"m\"\ntype = \"dielectric\"\neta = { vertex_color = true, channel = \"r\", factor = ";
    let load =
        |factor: &str| steradian::scene::load(&folder.write("a.toml", format!("{glass}{factor} }}\n").as_bytes()));
    load("2").unwrap();
    assert!(load("-2").unwrap_err().to_string().contains("`eta` in [[material]] must lie from 0.1 to 10"));
}

#[test]
fn the_same_numbers_in_model_files_are_errors() {
    let folder = Folder::new();
    let shining = |strength: &str| {
        folder.gltf(
            r#"{"name": "m"}"#,
            &format!(
                r#"{{"name": "m", "emissiveFactor": [1, 1, 1], "extensions": {{"KHR_materials_emissive_strength":
                {{"emissiveStrength": {strength}}}}}}}"#
            ),
        )
    };
    steradian::scene::load(&shining("1e17")).unwrap();
    refused(&shining("1e19"), "material 0 \"m\": `emissiveFactor times emissiveStrength` is out of its range");
    let masked = r#"{"name": "m", "alphaMode": "MASK", "alphaCutoff": -1}"#;
    refused(&folder.gltf(r#"{"name": "m"}"#, masked), "material 0 \"m\": `alphaCutoff` is out of its range");
    folder.write("a.mtl", b"newmtl m\nKd 1 1 1\nKe 1e30 0 0\n");
    let obj = folder.write("a.obj", b"mtllib a.mtl\nusemtl m\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    refused(&obj, "a.mtl:3:1: `Ke` must be three numbers from 0 to 1e18; correct it");
    let ply = |property: &str| {
        let header =
            format!("ply\nformat ascii 1.0\nelement vertex 3\n{property}\nproperty float y\nproperty float z\n");
        let rest =
            "element face 1\nproperty list uchar int vertex_indices\nend_header\n1 0 0 0\n1 1 0 0\n1 0 1 0\n3 0 1 2\n";
        folder.write("a.ply", (header + rest).as_bytes())
    };
    refused(&ply("property list uchar float x"), "a.ply: the property x of its vertices is a list, not a number");
    refused(&ply("property float x\nproperty float x"), "line 5 of its header, \"property float x\", comes twice");
}
