//! `converge`: one folder with a page that needs no network, every snapshot, and a reference that is kept.

use super::{refuses, run, scene};

#[test]
fn one_folder_with_everything() {
    let dir = tempfile::tempdir().unwrap();
    let out = dir.path().join("study");
    let path = scene("minimal.toml").display().to_string();
    let arguments = [
        "converge",
        &path,
        "-o",
        &out.display().to_string(),
        "--device",
        "cpu",
        "--size",
        "12x8",
        "--budget",
        "0.3",
        "--repeats",
        "2",
        "--reference-spp",
        "256",
        "--variants",
        "mis,bsdf+independent",
        "--json",
    ];
    let ran = run(&arguments);
    assert_eq!(ran.code, 0, "{}", ran.stderr);
    let lines: Vec<serde_json::Value> = ran.stdout.lines().map(|l| serde_json::from_str(l).unwrap()).collect();
    assert_eq!(lines.len(), 2, "one line a variant: {}", ran.stdout);
    for (line, name) in lines.iter().zip(["mis", "bsdf+independent"]) {
        assert_eq!(line["summary"]["variant"], name);
        assert_eq!(line["summary"]["seeds"], serde_json::json!([1, 2]));
        assert!(line["summary"]["at_budget"]["relmse"].as_f64().unwrap() >= 0.0);
    }
    let csv = std::fs::read_to_string(out.join("runs.csv")).unwrap();
    let columns = csv.lines().next().unwrap().split(',').count();
    assert!(csv.lines().count() >= 5 && csv.lines().all(|l| l.split(',').count() == columns), "{csv}");
    let page = std::fs::read_to_string(out.join("index.html")).unwrap();
    assert!(page.contains("<svg") && page.contains("data:image/png;base64,"));
    let overview = std::fs::read_to_string(out.join("overview.svg")).unwrap();
    for carried in ["converge", "CPU reference", "seeds 1 to 2", "data in runs.csv"] {
        assert!(overview.contains(carried), "a figure says what it was made by: {carried}");
    }
    let table = std::fs::read_to_string(out.join("table.md")).unwrap();
    assert!(table.contains("| minimal | bsdf+independent |") && table.contains("seeds 1 to 2"), "{table}");
    assert!(out.join("minimal-equal-time.png").is_file());
    let remote = page.match_indices("http").filter(|(i, _)| !page[*i..].starts_with("http://www.w3.org/")).count();
    assert_eq!(remote, 0, "the page is read offline");
    let kept = || std::fs::read_dir(out.join("references")).unwrap().count();
    assert_eq!(kept(), 1);
    let again = run(&arguments);
    assert!(again.code == 0 && !again.stderr.contains("reference of"), "the reference is kept: {}", again.stderr);
    assert_eq!(kept(), 1);
}

#[test]
fn what_cannot_be_studied_is_refused() {
    let dir = tempfile::tempdir().unwrap();
    let out = dir.path().display().to_string();
    let path = scene("minimal.toml").display().to_string();
    refuses(&["converge", &path, "-o", &out, "--variants", "mis+soboll"], &["soboll", "sobol"]);
    refuses(&["converge", &path, "-o", &out, "--variants", "mis,bsdf,mis"], &["--variants", "'mis'", "twice"]);
    refuses(&["converge", &path, &path, "-o", &out], &["two scenes are called", "rename"]);
    refuses(&["converge", &path, "-o", &out, "--variants", "bsdf+light"], &["'bsdf' and 'light'"]);
    refuses(&["converge", &path, "-o", &out, "--budget", "0"], &["--budget", "above 0"]);
    refuses(&["converge", &path, "-o", "/proc/none"], &["/proc/none"]);
    refuses(&["converge", "missing.toml", "-o", &out], &["missing.toml", "no such file"]);
    let picture = dir.path().join("small.hdr");
    let small = steradian::output::image::Picture { width: 2, height: 1, pixels: vec![[1.0; 3]; 2] };
    steradian::output::image::write_hdr(&picture, &small).unwrap();
    let reference = picture.display().to_string();
    refuses(&["converge", &path, "-o", &out, "--device", "cpu", "--reference", &reference], &["2x1", "--size"]);
}
