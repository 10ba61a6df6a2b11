//! `render`: files, record, stops, interrupts.

use std::process::{Command, Stdio};
use std::time::Duration;

use serde_json::Value;

use super::{run, scene};

const SMALL: [&str; 4] = ["--device", "cpu", "--size", "16x12"];

#[test]
fn writes_every_file_and_the_record() {
    let dir = tempfile::tempdir().unwrap();
    let path = |name: &str| dir.path().join(name).display().to_string();
    let cornell = scene("cornell.toml").display().to_string();
    let (exr, png, hdr, json) = (path("a.exr"), path("a.png"), path("a.hdr"), path("a.json"));
    let mut arguments = vec!["render", &cornell, "-o", &exr, "-o", &png, "-o", &hdr, "--record", &json, "--spp", "33"];
    arguments.extend(SMALL);
    let ran = run(&arguments);
    assert_eq!(ran.code, 0, "{}", ran.stderr);
    assert!(ran.stderr.contains("33 samples a pixel are rounded up to 48"), "{}", ran.stderr);
    assert!(ran.stdout.contains("at 48 spp") && ran.stdout.contains("Msamples/s"), "{}", ran.stdout);
    let record: Value = serde_json::from_str(&std::fs::read_to_string(&json).unwrap()).unwrap();
    for (key, wanted) in [("spp", 48u64), ("width", 16), ("height", 12), ("samples", 48 * 192), ("seed", 0)] {
        assert_eq!(record[key].as_u64(), Some(wanted), "{key}");
    }
    assert_eq!((record["stopped_by"].as_str(), record["device_kind"].as_str()), (Some("spp"), Some("cpu")));
    for key in ["wall_s", "throughput_MSps", "throughput_Mrays_ps", "peak_host_bytes", "rays"] {
        assert!(record[key].as_f64().unwrap() > 0.0, "{key}");
    }
    let estimate = &record["relmse_est"];
    assert!(estimate["low"].as_f64() <= estimate["value"].as_f64(), "{estimate}");
    for stage in ["load", "bvh", "compile", "upload", "trace", "write"] {
        assert!(record["seconds"][stage].is_f64(), "{stage}");
    }
    let in_header = steradian::output::exr::read_record(exr.as_ref()).unwrap().unwrap();
    let in_header: Value = serde_json::from_str(&in_header).unwrap();
    assert_eq!(in_header["relmse_est"], record["relmse_est"]);
    assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 4, "nothing is left beside");
}

#[test]
fn the_same_seed_gives_the_same_bytes_and_another_does_not() {
    let dir = tempfile::tempdir().unwrap();
    let cornell = scene("cornell.toml").display().to_string();
    let picture = |name: &str, seed: &str| {
        let path = dir.path().join(name).display().to_string();
        let mut arguments = vec!["render", &cornell, "-o", &path, "--spp", "16", "--seed", seed];
        arguments.extend(SMALL);
        assert_eq!(run(&arguments).code, 0);
        std::fs::read(path).unwrap()
    };
    assert_eq!(picture("a.png", "1"), picture("b.png", "1"));
    assert_ne!(picture("a.png", "1"), picture("c.png", "2"));
}

/// A crop's pixels are those of the whole image, bit for bit, and its file says where it lies.
#[test]
fn a_crop_equals_the_whole_image_there() {
    let dir = tempfile::tempdir().unwrap();
    let cornell = scene("cornell.toml").display().to_string();
    let render = |name: &str, more: &[&str]| {
        let path = dir.path().join(name).display().to_string();
        let mut arguments = vec!["render", &cornell, "-o", &path, "--spp", "16", "--pixel-filter", "gaussian"];
        arguments.extend(SMALL);
        arguments.extend(more);
        let ran = run(&arguments);
        assert_eq!(ran.code, 0, "{}", ran.stderr);
        steradian::output::image::read(path.as_ref()).unwrap()
    };
    let whole = render("whole.exr", &[]);
    let crop = render("crop.exr", &["--crop", "5,2,12,11"]);
    assert_eq!((crop.width, crop.height), (7, 9));
    for y in 0..9 {
        for x in 0..7 {
            assert_eq!(crop.pixels[y * 7 + x], whole.pixels[(y + 2) * 16 + x + 5], "({x}, {y})");
        }
    }
    let meta = exr::meta::MetaData::read_from_file(dir.path().join("crop.exr"), false).unwrap();
    let header = &meta.headers[0];
    let (data, display) = (header.own_attributes.layer_position, header.shared_attributes.display_window);
    assert_eq!((data.x(), data.y(), display.size.x(), display.size.y()), (5, 2, 16, 12));
}

/// scenes/lecture/exposure.toml: 18 % of white. Twice the time is a stop more, and so is --exposure 1.
#[test]
fn a_film_is_exposed_by_shutter_iso_and_f_number() {
    let dir = tempfile::tempdir().unwrap();
    let scene = scene("lecture/exposure.toml").display().to_string();
    let code = |name: &str, more: &[&str]| {
        let path = dir.path().join(name).display().to_string();
        let mut arguments = vec!["render", &scene, "-o", &path, "--device", "cpu"];
        arguments.extend(more);
        let ran = run(&arguments);
        assert_eq!(ran.code, 0, "{}", ran.stderr);
        let picture = steradian::output::image::read(path.as_ref()).unwrap();
        (steradian::output::image::srgb_encode(picture.pixels[0][1]) * 255.0).round() as u32
    };
    assert_eq!((code("a.png", &[]), code("b.png", &["--exposure", "1"])), (118, 162));
    assert_eq!(code("c.png", &["--exposure", "20", "--tonemap", "neutral"]), 255);
}

/// Band by band, the same picture; a limit that no row fits in is refused with numbers, and so is a time.
#[test]
fn bands_make_the_same_picture() {
    let dir = tempfile::tempdir().unwrap();
    let cornell = scene("cornell.toml").display().to_string();
    let picture = |name: &str, more: &[&str]| {
        let path = dir.path().join(name).display().to_string();
        let mut arguments = vec!["render", &cornell, "-o", &path, "--spp", "16"];
        arguments.extend(SMALL);
        arguments.extend(more);
        let ran = run(&arguments);
        assert_eq!(ran.code, 0, "{}", ran.stderr);
        (steradian::output::image::read(path.as_ref()).unwrap(), ran.stderr)
    };
    let (whole, _) = picture("whole.exr", &[]);
    let (bands, said) = picture("bands.exr", &["--tiled"]);
    assert!(said.contains("is finished in 1 bands of 12 rows"), "{said}");
    assert_eq!(whole, bands);
    let refused = |more: &[&str], word: &str| {
        let ran = run(&[&["render", &cornell, "--device", "cpu"][..], more].concat());
        assert!(ran.code == 2 && ran.stderr.contains(word), "{}", ran.stderr);
    };
    refused(&["--tiled", "--time", "5"], "give --spp instead of --time");
    refused(&["--max-memory", "1M"], "MiB or more");
}

#[test]
fn time_is_a_stop() {
    let dir = tempfile::tempdir().unwrap();
    let cornell = scene("cornell.toml").display().to_string();
    let (png, json) = (dir.path().join("a.png").display().to_string(), dir.path().join("a.json").display().to_string());
    let mut arguments = vec!["render", &cornell, "-o", &png, "--record", &json, "--time", "1"];
    arguments.extend(SMALL);
    assert_eq!(run(&arguments).code, 0);
    let record: Value = serde_json::from_str(&std::fs::read_to_string(json).unwrap()).unwrap();
    assert_eq!(record["stopped_by"], "time");
    assert!(record["wall_s"].as_f64().unwrap() < 3.0 && record["spp"].as_u64().unwrap() >= 32, "{record}");
}

/// SIGINT and SIGTERM: what is rendered is written, exit code 130.
#[cfg(unix)]
#[test]
fn interrupt_writes_what_is_there() {
    for signal in ["INT", "TERM"] {
        let dir = tempfile::tempdir().unwrap();
        let (png, json) = (dir.path().join("a.png"), dir.path().join("a.json"));
        let mut child = Command::new(env!("CARGO_BIN_EXE_steradian"))
            .args(["render", &scene("cornell.toml").display().to_string(), "--time", "100"])
            .args(SMALL)
            .args(["-o".as_ref(), png.as_os_str(), "--record".as_ref(), json.as_os_str()])
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        std::thread::sleep(Duration::from_millis(1500));
        Command::new("kill").args([format!("-{signal}"), child.id().to_string()]).status().unwrap();
        assert_eq!(child.wait().unwrap().code(), Some(130), "SIG{signal}");
        assert!(std::fs::metadata(&png).unwrap().len() > 100);
        let record: Value = serde_json::from_str(&std::fs::read_to_string(&json).unwrap()).unwrap();
        assert_eq!(record["stopped_by"], "interrupt");
    }
}

/// A large picture in bands, interrupted: the rows below are black, and ending takes no longer than a small one's.
#[cfg(unix)]
#[test]
fn an_interrupted_picture_in_bands_is_whole_soon() {
    let dir = tempfile::tempdir().unwrap();
    let path = |name: &str| dir.path().join(name);
    let mut child = Command::new(env!("CARGO_BIN_EXE_steradian"))
        .args(["render", &scene("cornell.toml").display().to_string(), "--device", "cpu", "--tiled"])
        .args(["--size", "3000x3000", "--spp", "16"])
        .args(["a.exr", "a.png", "a.hdr"].iter().flat_map(|name| ["-o".into(), path(name)]))
        .arg("--record")
        .arg(path("a.json"))
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // Once a band is written, there is something to keep.
    let begun_picture = path(&format!(".a.hdr.{}.tmp", child.id()));
    let is_begun = || std::fs::metadata(&begun_picture).is_ok_and(|m| m.len() > 4096);
    while !is_begun() && child.try_wait().unwrap().is_none() {
        std::thread::sleep(Duration::from_millis(20));
    }
    let begun = std::time::Instant::now();
    Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert!(begun.elapsed() < Duration::from_secs(20), "{:?}", begun.elapsed());
    let record: Value = serde_json::from_str(&std::fs::read_to_string(path("a.json")).unwrap()).unwrap();
    assert_eq!(record["stopped_by"], "interrupt");
    for name in ["a.exr", "a.png", "a.hdr"] {
        let picture = steradian::output::image::read(&path(name)).unwrap();
        assert_eq!((picture.width, picture.height), (3000, 3000), "{name}");
        assert_eq!(picture.pixels[8_999_999], [0.0; 3], "{name}");
    }
    assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 4, "nothing is left beside");
}

/// A signal while the kernel is compiled, by the program or by the driver: at once, with a sentence, and no file.
#[cfg(unix)]
#[test]
fn interrupt_before_the_first_samples_ends_at_once() {
    for wait_ms in [700, 2500] {
        let dir = tempfile::tempdir().unwrap();
        let png = dir.path().join("a.png");
        let child = Command::new(env!("CARGO_BIN_EXE_steradian"))
            .args(["render", &scene("showcase.toml").display().to_string(), "--everything", "--no-cache"])
            .args(["--size", "64x40", "--spp", "16", "-o"])
            .arg(&png)
            .env("MESA_SHADER_CACHE_DISABLE", "true")
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        std::thread::sleep(Duration::from_millis(wait_ms));
        let begun = std::time::Instant::now();
        Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
        let ended = child.wait_with_output().unwrap();
        let said = String::from_utf8_lossy(&ended.stderr).into_owned();
        assert_eq!(ended.status.code(), Some(130), "{said}");
        // Compiling all of it takes longer than this.
        assert!(begun.elapsed() < Duration::from_secs(2), "{:?}", begun.elapsed());
        assert!(said.contains("before the first samples: nothing is written"), "{said}");
        assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 0, "nothing is left behind");
    }
}

#[test]
fn help_and_version_go_to_stdout() {
    for arguments in [&["--help"][..], &["--version"], &["render", "--help"], &["compare", "--help"]] {
        let ran = run(arguments);
        assert_eq!((ran.code, ran.stderr.as_str()), (0, ""), "{arguments:?}");
        assert!(ran.stdout.contains("steradian"), "{arguments:?}");
    }
}

#[test]
fn devices_lists_the_cpu_at_least() {
    let ran = run(&["devices"]);
    assert!(ran.code == 0 && ran.stdout.contains("cpu  double-precision reference"), "{}", ran.stderr);
    for line in run(&["devices", "--json"]).stdout.lines() {
        assert!(serde_json::from_str::<Value>(line).unwrap()["name"].is_string(), "{line}");
    }
}

/// The layers of the light groups are there by name, and add up to the picture.
#[test]
fn light_groups_are_layers_that_add_up() {
    use steradian::output::exr::read_channels;
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("groups.toml");
    let text = "[camera]\nposition = [0, 2, 3]\n[sky]\nradiance = [0.1, 0.2, 0.3]\ngroup = \"sky\"\n\
                [[light]]\ntype = \"point\"\nposition = [0, 1, 0]\npower = 9\ngroup = \"key\"\n\
                [[light]]\ntype = \"point\"\nposition = [1, 1, 0]\npower = 3\n\
                [[material]]\nname = \"glow\"\nemission = 2\n\
                [[shape]]\ntype = \"sphere\"\nradius = 0.4\nmaterial = \"glow\"\ngroup = \"ball\"\n\
                [[shape]]\ntype = \"sphere\"\nradius = 0.2\ncenter = [-1, 0, 0]\npower = 4\ngroup = \"key\"\n\
                [[shape]]\ntype = \"rectangle\"\nu = [2, 0, 0]\nv = [0, 0, -2]\n";
    std::fs::write(&path, text).unwrap();
    let exr = dir.path().join("a.exr");
    for more in [&[][..], &["--tiled"]] {
        let mut arguments = vec!["render", path.to_str().unwrap(), "--device", "cpu", "--size", "9x7", "--spp", "32"];
        arguments.extend(["--aov", "light_groups,object", "-o", exr.to_str().unwrap()]);
        arguments.extend(more);
        let ran = run(&arguments);
        assert_eq!(ran.code, 0, "{}", ran.stderr);
        let layer = |name: &str| {
            read_channels(&exr, ["R", "G", "B"].map(|c| format!("{name}{c}")).each_ref().map(|c| c.as_str()))
        };
        let radiance = layer("").unwrap().unwrap();
        let parts: Vec<Vec<[f32; 3]>> = ["ball", "default", "key", "sky"]
            .map(|name| layer(&format!("light.{name}.")).unwrap().unwrap_or_else(|| panic!("no layer {name}")))
            .to_vec();
        assert!(layer("light.unused.").unwrap().is_none());
        for part in &parts {
            assert!(part.iter().any(|p| p[0] > 0.0));
        }
        for (pixel, r) in radiance.iter().enumerate() {
            for c in 0..3 {
                let sum: f64 = parts.iter().map(|part| f64::from(part[pixel][c])).sum();
                // Each layer and the picture are rounded to f32 a block and a pixel.
                assert!((sum - f64::from(r[c])).abs() <= 2.4e-7 * f64::from(r[c]), "{pixel} {sum} {r:?}");
            }
        }
    }
}

#[test]
fn light_groups_have_names_that_a_layer_can_have_and_are_not_too_many() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("groups.toml");
    let scene = |lights: &str| std::fs::write(&path, format!("[camera]\nposition = [0, 2, 3]\n{lights}")).unwrap();
    let lamp =
        |group: &str| format!("[[light]]\ntype = \"point\"\nposition = [0, 1, 0]\npower = 9\ngroup = \"{group}\"\n");
    let exr = dir.path().join("a.exr");
    let arguments = ["render", path.to_str().unwrap(), "--device", "cpu", "--size", "4x4", "--spp", "16"];
    let arguments = [&arguments[..], &["--aov", "light_groups", "-o", exr.to_str().unwrap()]].concat();
    for group in ["a.b", "", "one two", "a-name-that-is-longer-than-32-letters"] {
        scene(&lamp(group));
        super::refuses(&arguments, &["groups.toml:7", "group", "1 to 32 letters"]);
    }
    scene(&(0..17).map(|k| lamp(&format!("g{k}"))).collect::<String>());
    super::refuses(&arguments, &["17 light groups", "16"]);
    scene("[[shape]]\ntype = \"sphere\"\ngroup = \"key\"\n");
    super::refuses(&arguments, &["groups.toml:5", "it emits nothing"]);
    // A material without light may get some by a shape's power: a note where it does not. So for a sky that is dimmed to 0.
    let dark = |more: &str| {
        scene(&format!("[[material]]\nname = \"m\"\ntype = \"lambert\"\ngroup = \"key\"\n{more}"));
        run(&arguments)
    };
    let ran = dark("[sky]\nradiance = 0\ngroup = \"sky\"\n");
    assert!(ran.stderr.contains("groups.toml:6") && ran.stderr.contains("groups.toml:9"), "{}", ran.stderr);
    let ran = dark("[[shape]]\ntype = \"sphere\"\nmaterial = \"m\"\npower = 3\n");
    assert!(ran.code == 0 && !ran.stderr.contains("emits nothing"), "{}", ran.stderr);
}

/// A reader that goes away is no fault; a full disk is one sentence, and the picture is there either way.
#[cfg(target_os = "linux")]
#[test]
fn stdout_that_takes_nothing() {
    let dir = tempfile::tempdir().unwrap();
    let (png, cornell) = (dir.path().join("a.png"), scene("cornell.toml"));
    let render = |stdout: Stdio| {
        let mut command = Command::new(assert_cmd::cargo::cargo_bin("steradian"));
        command.arg("render").arg(&cornell).args(SMALL).args(["--spp", "16", "-o"]).arg(&png);
        let child = command.stdout(stdout).stderr(Stdio::piped()).spawn().unwrap();
        let output = child.wait_with_output().unwrap();
        assert!(std::fs::remove_file(&png).is_ok());
        (output.status.code(), String::from_utf8(output.stderr).unwrap())
    };
    let full = std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let (code, said) = render(full.into());
    assert!(code == Some(2) && said.contains("steradian: stdout: cannot write: no space left"), "{code:?} {said}");
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    let (code, said) = render(writer.into());
    assert!(code == Some(0) && !said.contains("stdout"), "{code:?} {said}");
}
