//! `render --adaptive` from outside.

use serde_json::Value;

use super::{refuses, run, scene};

/// --adaptive: --spp is the mean, counts differ by pixel and none is starved, the record says both; twice the same bytes; what has no
/// whole film is refused.
#[test]
fn adaptive_sampling_keeps_the_mean() {
    let dir = tempfile::tempdir().unwrap();
    let path = |name: &str| dir.path().join(name).display().to_string();
    let cornell = scene("cornell.toml").display().to_string();
    let (first, second, json) = (path("a.exr"), path("b.exr"), path("a.json"));
    for exr in [&first, &second] {
        let arguments = ["render", &cornell, "--adaptive", "--spp", "128", "-o", exr, "--record", &json];
        let ran = run(&[&arguments[..], &["--device", "cpu", "--size", "16x12"]].concat());
        assert_eq!(ran.code, 0, "{}", ran.stderr);
        assert!(ran.stdout.contains("spp on average"), "{}", ran.stdout);
    }
    let record: Value = serde_json::from_str(&std::fs::read_to_string(&json).unwrap()).unwrap();
    let (samples, wanted) = (record["samples"].as_u64().unwrap(), 128 * 192);
    assert!(samples <= wanted && samples + 4 * 16 >= wanted, "{samples} of {wanted}");
    let read = |exr: &str| {
        steradian::output::exr::read_channels(exr.as_ref(), ["R", "samples", "variance.R"]).unwrap().unwrap()
    };
    let (layers, again) = (read(&first), read(&second));
    assert_eq!(layers, again);
    let counts = || layers.iter().map(|p| p[1] as u64);
    assert_eq!(counts().sum::<u64>(), samples);
    let (fewest, most) = (counts().min().unwrap(), counts().max().unwrap());
    assert!(fewest >= 64 && most > 128, "{fewest} to {most}");
    assert_eq!(record["adaptive"], serde_json::json!({ "fewest_spp": fewest, "most_spp": most }));
    for flag in [&["--tiled"][..], &["--max-memory", "1G"]] {
        refuses(&[&["render", &cornell, "--adaptive"][..], flag].concat(), &["--adaptive", flag[0]]);
    }
}
