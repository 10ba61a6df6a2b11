//! What a user can get wrong: each is one sentence and exit code 2.

use super::{refuses, scene};

/// Writes `text` as a scene in a fresh folder.
fn written(text: &str, name: &str) -> (tempfile::TempDir, String) {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join(name);
    std::fs::write(&path, text).unwrap();
    (dir, path.display().to_string())
}

#[test]
fn scene_files() {
    let dir = tempfile::tempdir().unwrap();
    let path = |name: &str| dir.path().join(name).display().to_string();
    refuses(&["render", &path("missing.toml")], &["missing.toml", "no such file"]);
    refuses(&["render", &path("missing.glb")], &["missing.glb", "no such file"]);
    refuses(&["render", &dir.path().display().to_string()], &["directory"]);
    for name in ["empty.glb", "empty.gltf"] {
        std::fs::write(path(name), b"").unwrap();
        refuses(&["render", &path(name)], &[name]);
    }
    std::fs::write(path("text.gltf"), b"this is not JSON").unwrap();
    refuses(&["render", &path("text.gltf")], &["text.gltf"]);
    std::fs::write(path("a.blend"), b"").unwrap();
    refuses(&["render", &path("a.blend")], &["a.blend"]);
}

#[test]
fn unknown_key_names_the_nearest() {
    let (_dir, path) = written("[camera]\npositon = [0, 0, 1]\n", "typo.toml");
    refuses(&["render", &path], &["typo.toml:2", "positon", "position"]);
}

#[test]
fn cameras() {
    let cases: [(&str, &[&str]); 14] = [
        ("fov_y_deg = 180", &["fov_y_deg", "below 180"]),
        ("fov_y_deg = 0", &["fov_y_deg", "above 0"]),
        ("fov_y_deg = nan", &["fov_y_deg", "finite"]),
        ("fov_y_deg = 179.9999999999", &["field of view", "too near 180"]),
        ("type = \"fisheye\"", &["type", "panorama"]),
        ("lens_radius = 0.1", &["lens_radius", "perspective"]),
        ("type = \"thin_lens\"\nlens_radius = -1", &["lens_radius", "negative"]),
        ("type = \"thin_lens\"\nfocus_distance = 0", &["focus_distance", "above 0"]),
        ("type = \"thin_lens\"\nf_number = 2.8", &["focal_length_mm", "f_number"]),
        ("type = \"thin_lens\"\nf_number = 0\nfocal_length_mm = 50", &["f_number", "above 0"]),
        ("type = \"thin_lens\"\nf_number = 2\nlens_radius = 1", &["f_number", "lens_radius"]),
        ("type = \"orthographic\"\nheight = 0", &["height", "above 0"]),
        ("type = \"orthographic\"\nfov_y_deg = 40", &["fov_y_deg", "orthographic"]),
        ("target = [0, 0, 5]", &["target", "where the camera stands"]),
    ];
    for (keys, words) in cases {
        let (_dir, path) =
            written(&format!("[camera]\nposition = [0, 0, 5]\n{keys}\n[[shape]]\ntype = \"sphere\"\n"), "c.toml");
        refuses(&["render", &path, "--device", "cpu", "--size", "4x4"], words);
    }
    let (_dir, path) = written("camera = { type = \"panorama\" }\n", "c.toml");
    refuses(&["render", &path], &["position"]);
    // One pixel, and every camera framed or placed, is a picture.
    for keys in [
        "",
        "fov_y_deg = 179.99",
        "type = \"thin_lens\"\nlens_radius = 0.5",
        "type = \"orthographic\"",
        "type = \"panorama\"\nposition = [0, 0, 5]",
    ] {
        let (dir, path) = written(&format!("[camera]\n{keys}\n[[shape]]\ntype = \"sphere\"\n"), "c.toml");
        let png = dir.path().join("c.png").display().to_string();
        let ran = super::run(&["render", &path, "--device", "cpu", "--size", "1x1", "--spp", "16", "-o", &png]);
        assert_eq!(ran.code, 0, "{keys}: {}", ran.stderr);
    }
}

#[test]
fn flags() {
    let cornell = scene("cornell.toml").display().to_string();
    let cases: [(&[&str], &[&str]); 35] = [
        (&["--variant", "Red"], &["cornell.toml", "`variant`", "[[model]]"]),
        (&["--scene", "1"], &["cornell.toml", "`scene`", "[[model]]"]),
        (&["--texture-filter", "blur"], &["blur", "exact", "mipmap"]),
        (&["--size", "65536x65536"], &["65536x65536", "MiB", "--size"]),
        (&["--size", "0x10"], &["0x10", "1 to 65536"]),
        (&["--size", "640"], &["640", "WIDTHxHEIGHT"]),
        (&["--spp", "0"], &["--spp"]),
        (&["--time", "nan"], &["--time", "above 0"]),
        (&["--error", "0"], &["--error", "above 0"]),
        (&["--error", "-1"], &["--error", "above 0"]),
        (&["--samples", "-16..16"], &["--samples", "-16..16"]),
        (&["-o", "a.png", "-o", "./a.png"], &["./a.png", "another name"]),
        (&["-o", "a.png", "--record", "a.png"], &["a.png", "another name"]),
        (&["--tiled", "--error", "0.1"], &["--spp", "--error"]),
        (&["--exposure", "inf"], &["--exposure", "finite"]),
        (&["--device", "zorg"], &["zorg", "cpu"]),
        (&["--estimator", "guess"], &["guess", "mis"]),
        (&["--sppp", "4"], &["--sppp", "--spp"]),
        (&["--env", "missing.hdr"], &["missing.hdr", "no such file"]),
        (&["--env-rotate", "90"], &["--env-rotate", "no sky"]),
        (&["-o", "/no/such/folder/a.exr"], &["/no/such/folder/a.exr", "cannot write"]),
        (&["--crop", "0,0,10"], &["0,0,10", "X0,Y0,X1,Y1"]),
        (&["--crop", "5,0,5,9"], &["--crop", "holds no pixel"]),
        (&["--crop", "0,0,9,1000"], &["--crop", "reaches out of the image of 400x400"]),
        (&["--pixel-filter", "gausian"], &["gausian", "gaussian"]),
        (&["--filter-radius", "0"], &["--filter-radius", "at most 32"]),
        (&["--filter-radius", "1e9"], &["--filter-radius", "at most 32"]),
        (&["--filter-radius", "nan"], &["--filter-radius", "at most 32"]),
        (&["--max-memory", "lots"], &["lots", "512M"]),
        (&["--tonemap", "filmic"], &["filmic", "neutral"]),
        (&["--aov", "albdo", "-o", "a.exr"], &["albdo", "did you mean albedo"]),
        (&["--aov", "uv", "-o", "a.png"], &["--aov", ".exr"]),
        (&["--exposure", "1", "-o", "a.exr"], &["--exposure", ".png"]),
        (&["--tonemap", "none", "-o", "a.hdr"], &["--tonemap", ".png"]),
        (&["-o", "a.tif"], &["a.tif", "use .exr, .png, .hdr or .part"]),
    ];
    for (flags, words) in cases {
        let mut arguments = vec!["render", &cornell];
        arguments.extend(flags);
        refuses(&arguments, words);
    }
    refuses(&["render"], &["SCENE"]);
    refuses(&["rendr", &cornell], &["rendr", "render"]);
}

/// Flags that would change nothing: what they are for is not there.
#[test]
fn flags_without_effect() {
    let path = |name: &str| scene(name).display().to_string();
    let (cornell, sky, meters) = (path("cornell.toml"), path("uniform_sky.toml"), path("lecture/meters.toml"));
    let dir = tempfile::tempdir().unwrap();
    let folder = dir.path().display().to_string();
    refuses(&["render", &sky, "--env-rotate", "90"], &["--env-rotate", "the same all around"]);
    refuses(&["render", &sky, "--env-scale", "1e300"], &["--env-scale", "1e18 is the most"]);
    refuses(&["measure", &meters, "--instances", "often"], &["often", "auto, always, never"]);
    refuses(&["bench", "--filter", "zorg"], &["zorg", "build, rays, instances, samples, specialise"]);
    refuses(&["bench", &cornell, "--filter", "rays"], &["samples", "--filter rays"]);
    refuses(&["bench", "--filter", "rays", "--seeds", "5"], &["--seeds", "coverage"]);
    refuses(&["bench", &cornell, "--filter", "coverage", "--try", "."], &["--try", "samples"]);
    refuses(&["bench", "--filter", "coverage", "--rounds", "3"], &["--rounds", "coverage"]);
    refuses(&["bench", "--filter", "estimate", "--seeds", "3"], &["--seeds", "exponents"]);
    refuses(&["render", &cornell, "--integrator", "direct", "--max-depth", "9"], &["--max-depth 9", "direct", "2"]);
    let converge = ["converge", &cornell, "-o", &folder, "--reference", "a.exr"];
    refuses(&[&converge[..], &["--reference-spp", "64"]].concat(), &["--reference-spp", "--reference"]);
    refuses(&[&converge[..], &[&sky]].concat(), &["--reference", "one scene, and 2 are given"]);
    let png = dir.path().join("a.png").display().to_string();
    let cpu = ["--device", "cpu", "--size", "4x4", "--spp", "16", "--everything", "-o", &png];
    let ran = super::run(&[&["render", cornell.as_str()], &cpu[..]].concat());
    assert!(ran.code == 0 && ran.stderr.contains("--everything and --no-cache have no effect"), "{}", ran.stderr);
}

#[test]
fn copies_of_shapes() {
    let shape = |more: &str| format!("[[shape]]\ntype = \"box\"\n{more}\n");
    for (text, words) in [
        (shape("copies = [{ translate = [0, 0] }]"), &["copies.toml:3", "translate", "3 numbers"][..]),
        (shape("copies = [{ scale = 0 }]"), &["copies.toml:3", "without an inverse"]),
        (shape("copies = [{ scale = nan }]"), &["copies.toml:3", "finite"]),
        (shape("copies = [{ translat = [0, 0, 1] }]"), &["translat", "translate"]),
        (shape("copies = []"), &["copies.toml:3", "holds no copy"]),
        (shape("copies_file = \"missing.txt\""), &["missing.txt", "no such file"]),
        (shape("copies_file = \"copies.toml\""), &["copies.toml line 1", "[[shape]]"]),
        (shape("copies = [{}]\ncopies_file = \"a.txt\""), &["copies_file", "beside `copies`"]),
    ] {
        let (_dir, path) = written(&text, "copies.toml");
        refuses(&["render", &path], words);
    }
    let cornell = scene("cornell.toml").display().to_string();
    refuses(&["render", &cornell, "--instances", "often"], &["often", "auto, always, never"]);
}
