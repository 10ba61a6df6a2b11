//! Lamps from outside: what is reported about them.

use super::{refuses, run};

fn written(lights: &str) -> (tempfile::TempDir, String) {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("lamps.toml");
    let floor = "[camera]\nposition = [0, 2, 3]\n[[shape]]\ntype = \"rectangle\"\nu = [2, 0, 0]\nv = [0, 0, -2]\n";
    std::fs::write(&path, format!("{floor}{lights}")).unwrap();
    (dir, path.display().to_string())
}

const LAMP: &str = "[[light]]\ntype = \"point\"\nname = \"bulb\"\nposition = [0, 1, 0]\n";

fn render(path: &str, more: &[&str]) -> super::Ran {
    let picture = path.replace(".toml", ".exr");
    let mut arguments = vec!["render", path, "--device", "cpu", "--size", "8x8", "--spp", "16", "-o", &picture];
    arguments.extend(more);
    run(&arguments)
}

#[test]
fn the_estimator_bsdf_says_that_it_cannot_see_them() {
    let (_dir, path) = written(&format!("{LAMP}power = 3\n"));
    let said = |more: &[&str]| {
        let ran = render(&path, more);
        assert_eq!(ran.code, 0, "{}", ran.stderr);
        ran.stderr.lines().filter(|l| l.contains("cannot find 1 lights without size")).count()
    };
    assert_eq!((said(&["--estimator", "bsdf"]), said(&[])), (1, 0));
}

#[test]
fn a_lamp_without_power_is_reported() {
    let (_dir, path) = written(&format!("{LAMP}power = 0\n"));
    let ran = render(&path, &[]);
    assert_eq!(ran.code, 0, "{}", ran.stderr);
    for words in ["the light 'bulb' has no power and was left out", "no light in the scene"] {
        assert!(ran.stderr.contains(words), "{words}: {}", ran.stderr);
    }
}

#[test]
fn lamps_that_cannot_be_are_one_sentence() {
    let cases: [(&str, &[&str]); 4] = [
        ("power = 1e42\n", &["lamps.toml:11", "power", "1e18 is the most"]),
        ("power = 1\nintensity = 2\n", &["lamps.toml:12", "intensity", "power"]),
        ("power = nan\n", &["lamps.toml:11", "finite"]),
        ("power_lm = -5\n", &["power_lm", "negative"]),
    ];
    for (strength, words) in cases {
        let (_dir, path) = written(&format!("{LAMP}{strength}"));
        refuses(&["render", &path, "--device", "cpu", "--size", "8x8", "--spp", "16"], words);
    }
}
