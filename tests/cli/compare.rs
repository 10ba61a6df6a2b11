//! `compare`: measures, JSON, error map, exit codes.

use serde_json::Value;
use steradian::metric::error;
use steradian::output::image::{self, Picture};

use super::{refuses, run};

fn picture(value: f32) -> Picture {
    Picture { width: 4, height: 2, pixels: (0..8).map(|i| [value, 0.5, i as f32 * 0.125]).collect() }
}

#[test]
fn measures_and_verdict() {
    let dir = tempfile::tempdir().unwrap();
    let path = |name: &str| dir.path().join(name).display().to_string();
    let (a, b, map) = (path("a.hdr"), path("b.hdr"), path("map.png"));
    image::write_hdr(a.as_ref(), &picture(0.5)).unwrap();
    image::write_hdr(b.as_ref(), &picture(1.0)).unwrap();
    let wanted = error::compare(&picture(0.5).pixels, &picture(1.0).pixels, 4);
    let ran = run(&["compare", &a, &b, "--json", "-o", &map, "--max-relmse", "0.1"]);
    assert_eq!((ran.code, ran.stderr.as_str()), (0, ""));
    let json: Value = serde_json::from_str(ran.stdout.trim()).unwrap();
    for (key, value) in [("relmse", wanted.relmse), ("rmse", wanted.rmse), ("bias", wanted.bias), ("flip", wanted.flip)]
    {
        assert!((json[key].as_f64().unwrap() - value).abs() < 1e-3, "{key}: {json}");
    }
    let map = image::read(map.as_ref()).unwrap();
    assert_eq!((map.width, map.height), (4, 2));
    let ran = run(&["compare", &a, &b, "--max-relmse", "0.01"]);
    assert!(ran.code == 1 && ran.stdout.contains("relMSE trimmed"), "{}", ran.stdout);
}

#[test]
fn what_cannot_be_compared_is_refused() {
    let dir = tempfile::tempdir().unwrap();
    let path = |name: &str| dir.path().join(name).display().to_string();
    let (a, wide, broken) = (path("a.hdr"), path("wide.hdr"), path("broken.exr"));
    image::write_hdr(a.as_ref(), &picture(0.5)).unwrap();
    image::write_hdr(wide.as_ref(), &Picture { width: 8, height: 1, ..picture(0.5) }).unwrap();
    std::fs::write(&broken, b"not a picture").unwrap();
    refuses(&["compare", &a, &wide], &["4x2", "8x1", "only images of one size"]);
    refuses(&["compare", &a, &broken], &["broken.exr", "cannot read"]);
    refuses(&["compare", &a, &path("missing.png")], &["missing.png", "no such file"]);
    refuses(&["compare", &a, &path("a.tif")], &["a.tif", "use .exr, .png or .hdr"]);
    refuses(&["compare", &a, &a, "-o", &path("map.exr")], &["map.exr", ".png"]);
    refuses(&["compare", &a, &a, "--max-relmse", "0"], &["--max-relmse", "above 0"]);
}
