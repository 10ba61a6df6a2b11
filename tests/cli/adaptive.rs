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

/// A checkpoint keeps the allocation: what goes on from it is one run, bit for bit. Ranges of samples are refused, and a file that was
/// begun the other way.
#[test]
fn an_adaptive_render_goes_on() {
    let dir = tempfile::tempdir().unwrap();
    let path = |name: &str| dir.path().join(name).display().to_string();
    let cornell = scene("cornell.toml").display().to_string();
    let begin = ["render", &cornell, "--device", "cpu", "--size", "16x12"];
    let render = |more: &[&str]| {
        let ran = run(&[&begin[..], more].concat());
        assert_eq!(ran.code, 0, "{more:?}: {}", ran.stderr);
        ran.stderr
    };
    render(&["--adaptive", "--spp", "400", "-o", &path("one.exr")]);
    render(&["--adaptive", "--spp", "144", "--checkpoint", &path("a.part"), "-o", &path("a.exr")]);
    let said = render(&["--adaptive", "--resume", &path("a.part"), "--spp", "400", "-o", &path("b.exr")]);
    assert!(said.contains("a.part at 14"), "{said}");
    let read = |name: &str| {
        let layers = ["R", "samples", "variance.R"];
        steradian::output::exr::read_channels(path(name).as_ref(), layers).unwrap().unwrap()
    };
    assert!(read("one.exr") == read("b.exr"), "the pictures differ");
    let refused = |more: &[&str], words: &[&str]| {
        let ran = run(&[&begin[..], more].concat());
        assert_eq!(ran.code, 2, "{more:?}: {}", ran.stderr);
        words.iter().for_each(|word| assert!(ran.stderr.contains(word), "\"{word}\" is missing: {}", ran.stderr));
    };
    refused(&["--adaptive", "--samples", "0..64", "-o", &path("c.part")], &["--adaptive", "--samples"]);
    refused(&["--resume", &path("a.part"), "--spp", "500", "-o", &path("c.png")], &["a.part", "begun with --adaptive"]);
    render(&["--spp", "32", "--checkpoint", &path("d.part"), "-o", &path("d.png")]);
    refused(
        &["--adaptive", "--resume", &path("d.part"), "-o", &path("c.png")],
        &["d.part", "begun without --adaptive"],
    );
}
