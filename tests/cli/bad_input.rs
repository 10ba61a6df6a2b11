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
fn flags() {
    let cornell = scene("cornell.toml").display().to_string();
    let cases: [(&[&str], &[&str]); 23] = [
        (&["--size", "65536x65536"], &["65536x65536", "MiB", "--size"]),
        (&["--size", "0x10"], &["0x10", "1 to 65536"]),
        (&["--size", "640"], &["640", "WIDTHxHEIGHT"]),
        (&["--spp", "0"], &["--spp"]),
        (&["--time", "nan"], &["--time", "above 0"]),
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
        (&["--tonemap", "filmic"], &["filmic", "neutral"]),
        (&["--aov", "albdo", "-o", "a.exr"], &["albdo", "did you mean albedo"]),
        (&["--aov", "uv", "-o", "a.png"], &["--aov", ".exr"]),
        (&["-o", "a.tif"], &["a.tif", "use .exr, .png or .hdr"]),
    ];
    for (flags, words) in cases {
        let mut arguments = vec!["render", &cornell];
        arguments.extend(flags);
        refuses(&arguments, words);
    }
    refuses(&["render"], &["SCENE"]);
    refuses(&["rendr", &cornell], &["rendr", "render"]);
}
