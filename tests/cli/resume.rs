//! Ranges, checkpoints, resume and merge, on the CPU reference and on the Vulkan device where there is one: the same bits as one run,
//! and a sentence for whatever does not fit. Kills: tests/cli/kills.rs.

use std::path::Path;

use super::{refuses, run, scene};

pub const SIZE: [&str; 2] = ["--size", "24x16"];

/// Devices that can be tested here; says so where there is only one.
pub fn devices() -> Vec<&'static str> {
    let has_vulkan = run(&["devices"]).stdout.lines().any(|l| l.starts_with("0 "));
    if !has_vulkan {
        println!("skipped: resume and merge on a Vulkan device (there is none)");
    }
    ["cpu", "auto"].into_iter().filter(|d| *d == "cpu" || has_vulkan).collect()
}

/// Every channel of an .exr by name, as bits.
pub fn layers(path: &Path) -> Vec<(String, Vec<u32>)> {
    use exr::prelude::*;
    let image = read().no_deep_data().largest_resolution_level().all_channels().first_valid_layer().all_attributes();
    let layer = image.from_file(path).unwrap().layer_data;
    let count = layer.size.area();
    let bits = |c: &AnyChannel<FlatSamples>| -> Vec<u32> {
        (0..count).map(|i| c.sample_data.value_by_flat_index(i).to_f32().to_bits()).collect()
    };
    layer.channel_data.list.iter().map(|c| (c.name.to_string(), bits(c))).collect()
}

/// A folder, and renders of cornell.toml into it.
struct Bench {
    dir: tempfile::TempDir,
    device: &'static str,
}

impl Bench {
    fn new(device: &'static str) -> Self {
        Self { dir: tempfile::tempdir().unwrap(), device }
    }

    fn path(&self, name: &str) -> String {
        self.dir.path().join(name).display().to_string()
    }

    /// `render` with names that begin with "./" in the folder.
    fn try_render(&self, more: &[&str]) -> super::Ran {
        let cornell = scene("cornell.toml").display().to_string();
        let mut arguments = vec!["render".to_owned(), cornell, "--device".into(), self.device.into()];
        arguments.extend(SIZE.into_iter().filter(|_| !more.contains(&"--size")).map(String::from));
        arguments.extend(more.iter().map(|a| a.strip_prefix("./").map_or(a.to_string(), |name| self.path(name))));
        run(&arguments.iter().map(String::as_str).collect::<Vec<_>>())
    }

    #[track_caller]
    fn render(&self, more: &[&str]) -> super::Ran {
        let ran = self.try_render(more);
        assert_eq!(ran.code, 0, "{more:?}: {}", ran.stderr);
        ran
    }

    #[track_caller]
    fn refuses(&self, more: &[&str], words: &[&str]) {
        let ran = self.try_render(more);
        let said = format!("{more:?}: exit {}, {}", ran.code, ran.stderr);
        assert!(ran.code == 2 && ran.stdout.is_empty(), "{said}");
        let last = ran.stderr.trim_end().lines().next_back().unwrap_or_default();
        words.iter().for_each(|word| assert!(last.contains(word), "\"{word}\" is missing: {said}"));
    }

    #[track_caller]
    fn merge(&self, parts: &[&str], outputs: &[&str]) -> super::Ran {
        let mut arguments = vec!["merge".to_owned()];
        arguments.extend(parts.iter().map(|p| self.path(p)));
        outputs.iter().for_each(|o| arguments.extend(["-o".into(), self.path(o)]));
        let ran = run(&arguments.iter().map(String::as_str).collect::<Vec<_>>());
        assert_eq!(ran.code, 0, "{parts:?}: {}", ran.stderr);
        ran
    }

    #[track_caller]
    fn same(&self, a: &str, b: &str) {
        let (a, b) = (layers(self.path(a).as_ref()), layers(self.path(b).as_ref()));
        assert_eq!(a.len(), b.len());
        for ((name, x), (other, y)) in a.iter().zip(&b) {
            let apart = x.iter().zip(y).filter(|(x, y)| x != y).count();
            assert!(name == other && apart == 0, "{}: {apart} pixels of {name} differ", self.device);
        }
    }
}

/// 0..16, 16..48 and 48..80 in any order and as a tree: every layer of the .exr of one run, bit for bit.
#[test]
fn merged_ranges_are_one_run() {
    for device in devices() {
        let bench = Bench::new(device);
        bench.render(&["--spp", "80", "--aov", "all", "-o", "./one.exr", "-o", "./one.hdr"]);
        for (range, name) in [("0..16", "./a.part"), ("16..48", "./b.part"), ("48..80", "./c.part")] {
            bench.render(&["--samples", range, "--aov", "all", "-o", name]);
        }
        bench.merge(&["c.part", "a.part", "b.part"], &["m.exr", "m.hdr"]);
        bench.same("one.exr", "m.exr");
        let bytes = |name: &str| std::fs::read(bench.path(name)).unwrap();
        assert_eq!(bytes("one.hdr"), bytes("m.hdr"));
        bench.merge(&["b.part", "a.part"], &["ab.part"]);
        bench.merge(&["ab.part", "c.part"], &["tree.exr"]);
        bench.same("one.exr", "tree.exr");
        // The record holds the sums, and a merge goes on like any part.
        let record = steradian::output::exr::read_record(bench.path("tree.exr").as_ref()).unwrap().unwrap();
        let record: serde_json::Value = serde_json::from_str(&record).unwrap();
        assert_eq!((record["spp"].as_u64(), record["samples"].as_u64()), (Some(80), Some(80 * 24 * 16)));
        assert!(record["relmse_est"]["value"].as_f64() > Some(0.0) && record["rays"].as_u64() > Some(80 * 24 * 16));
        bench.render(&["--resume", "./ab.part", "--spp", "64", "-o", "./gone_on.exr"]);
        bench.render(&["--resume", "./ab.part", "--aov", "all", "--spp", "80", "-o", "./gone_on.exr"]);
        bench.same("one.exr", "gone_on.exr");
    }
}

#[test]
fn a_resumed_render_is_one_run() {
    for device in devices() {
        let bench = Bench::new(device);
        bench.render(&["--spp", "96", "-o", "./one.exr"]);
        let ran = bench.render(&["--spp", "32", "--checkpoint", "./kept", "-o", "./a.exr"]);
        assert!(ran.stdout.contains("kept"), "{}", ran.stdout);
        // Layers are those of the checkpoint, unless others are asked for. Then on into another file.
        let ran = bench.render(&["--resume", "./kept", "--spp", "64", "--checkpoint", "./more", "-o", "./b.exr"]);
        assert!(ran.stderr.contains("goes on from") && ran.stderr.contains("at 32 samples"), "{}", ran.stderr);
        bench.render(&["--resume", "./more", "--spp", "96", "-o", "./c.exr"]);
        bench.same("one.exr", "c.exr");
        // `more` holds 96 now: fewer are no reason to throw samples away, and none asked for are as many as before.
        let ran = bench.render(&["--resume", "./more", "--spp", "32", "-o", "./d.exr"]);
        assert!(ran.stderr.contains("none is rendered") && ran.stdout.contains("at 96 spp"), "{}", ran.stdout);
        bench.same("one.exr", "d.exr");
        let ran = bench.render(&["--resume", "./kept", "-o", "./e.png"]);
        assert!(ran.stderr.contains("none is rendered") && ran.stdout.contains("at 32 spp"), "{}", ran.stdout);
    }
}

/// Ctrl-C in the middle of a pass leaves pixels with different counts; going on makes them level, to the bits of one run.
#[cfg(unix)]
#[test]
fn an_interrupted_render_goes_on() {
    for device in devices() {
        let dir = tempfile::tempdir().unwrap();
        let path = |name: &str| dir.path().join(name).display().to_string();
        let (kept, exr, one) = (path("kept"), path("a.exr"), path("one.exr"));
        let cornell = scene("cornell.toml").display().to_string();
        let common = ["render", &cornell, "--device", device, "--size", "128x96"];
        let mut child = std::process::Command::new(env!("CARGO_BIN_EXE_steradian"))
            .args(common)
            .args(["--spp", "100000", "--checkpoint", &kept, "--checkpoint-every", "0.02", "-o", &exr])
            .stdout(std::process::Stdio::null())
            .stderr(std::process::Stdio::null())
            .spawn()
            .unwrap();
        let begun = std::time::Instant::now();
        while !Path::new(&kept).exists() && begun.elapsed().as_secs() < 60 {
            std::thread::sleep(std::time::Duration::from_millis(20));
        }
        std::thread::sleep(std::time::Duration::from_millis(300));
        std::process::Command::new("kill").args(["-TERM", &child.id().to_string()]).status().unwrap();
        let code = child.wait().unwrap().code();
        assert_eq!(code, Some(130));
        let film = steradian::output::part::read(kept.as_ref()).unwrap().film;
        let more = (film.max_block_count() * 16 + 16).to_string();
        println!("{device}: interrupted at {} to {} blocks", film.min_block_count(), film.max_block_count());
        for arguments in
            [["--resume", &kept, "-o", &exr], ["--aov", "albedo,normal,depth,variance,samples", "-o", &one]]
        {
            let ran = run(&[&common[..], &["--spp", &more], &arguments].concat());
            assert_eq!(ran.code, 0, "{}", ran.stderr);
        }
        assert!(layers(exr.as_ref()) == layers(one.as_ref()), "{device}: not the bits of one run");
    }
}

/// A kernel with everything in it makes every layer, and its film is kept with all of them.
#[test]
fn everything_is_kept() {
    let bench = Bench::new(devices().pop().unwrap());
    bench.render(&["--everything", "--spp", "32", "-o", "./one.exr"]);
    bench.render(&["--everything", "--spp", "16", "--checkpoint", "./kept", "-o", "./a.png"]);
    bench.render(&["--everything", "--resume", "./kept", "--spp", "32", "-o", "./b.exr"]);
    bench.same("one.exr", "b.exr");
    bench.render(&["--everything", "--samples", "0..16", "-o", "./a.part"]);
    bench.render(&["--everything", "--samples", "16..32", "-o", "./b.part"]);
    bench.merge(&["b.part", "a.part"], &["m.exr"]);
    bench.same("one.exr", "m.exr");
    // A film with fewer layers cannot take those samples.
    bench.render(&["--samples", "0..16", "-o", "./plain.part"]);
    let flags = ["--everything", "--resume", "./plain.part", "--spp", "32", "-o", "./c.exr"];
    bench.refuses(&flags, &["plain.part", "--aov albedo", "leave out --everything"]);
}

/// A run that ends by --time leaves the target as it was; without one there is nothing to go on to.
#[test]
fn the_target_is_remembered() {
    let bench = Bench::new("cpu");
    bench.render(&["--spp", "48", "--time", "0.001", "--checkpoint", "./kept", "-o", "./a.png"]);
    bench.render(&["--resume", "./kept", "--time", "0.001", "-o", "./a.png"]);
    let ran = bench.render(&["--resume", "./kept", "-o", "./a.png"]);
    assert!(ran.stdout.contains("at 48 spp"), "{}", ran.stdout);
    bench.render(&["--time", "0.001", "--checkpoint", "./timed", "-o", "./a.png"]);
    bench.refuses(&["--resume", "./timed", "-o", "./a.png"], &["timed", "give --spp, --time or --error"]);
    bench.render(&["--resume", "./timed", "--time", "0.001", "-o", "./a.png"]);
    // What is short of its target is said where it is merged.
    bench.render(&["--spp", "4096", "--time", "0.001", "-o", "./short.part"]);
    let ran = bench.merge(&["short.part"], &["m.png"]);
    assert!(ran.stderr.contains("not finished") && ran.stderr.contains("of 4096 samples"), "{}", ran.stderr);
}

/// A link stays a link to the checkpoint; what is no file is not waited for.
#[cfg(unix)]
#[test]
fn links_and_pipes() {
    let bench = Bench::new("cpu");
    bench.render(&["--spp", "16", "--checkpoint", "./kept", "-o", "./a.png"]);
    std::os::unix::fs::symlink(bench.path("kept"), bench.path("link")).unwrap();
    bench.render(&["--resume", "./link", "--spp", "32", "-o", "./a.png"]);
    assert!(Path::new(&bench.path("link")).is_symlink());
    assert_eq!(steradian::output::part::read(bench.path("kept").as_ref()).unwrap().film.spp(), 32);
    let pipe = bench.path("pipe.part");
    assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    bench.refuses(&["--resume", "./pipe.part", "-o", "./a.png"], &["pipe.part", "no regular file"]);
    refuses(&["merge", &pipe, "-o", &bench.path("m.png")], &["pipe.part", "no regular file"]);
}

/// What does not fit is refused by name, with both values.
#[test]
fn what_does_not_fit_is_refused() {
    let bench = Bench::new("cpu");
    bench.render(&["--samples", "0..16", "-o", "./a.part", "-o", "./a.exr"]);
    bench.render(&["--samples", "16..32", "-o", "./b.part"]);
    let cases: [(&[&str], &[&str]); 18] = [
        (&["--adaptive"], &["--adaptive", "--resume"]),
        (&["--seed", "7"], &["a.part", "--seed 0", "has 7"]),
        (&["--size", "24x17"], &["--size 24x16", "has 24x17"]),
        (&["--sampler", "independent"], &["--sampler sobol", "has independent"]),
        (&["--estimator", "bsdf"], &["--estimator mis", "has bsdf"]),
        (&["--integrator", "direct"], &["--integrator path", "has direct"]),
        (&["--max-depth", "3"], &["--max-depth", "has 3"]),
        (&["--crop", "0,0,8,8"], &["--crop none", "has 0,0,8,8"]),
        (&["--pixel-filter", "gaussian"], &["--pixel-filter box", "has gaussian"]),
        (&["--aov", "uv"], &["--aov albedo,normal,depth,variance,samples", "has uv"]),
        (&["--env", "sky.hdr"], &["begun with", "cornell.toml", "not the scene"]),
        (&["--samples", "16..32"], &["begin at 0", "--samples 0..32"]),
        (&["--tiled"], &["--tiled", "whole film"]),
        (&["--samples", "0..32", "--spp", "32"], &["--samples", "--spp"]),
        (&["--samples", "0..40"], &["whole blocks of 16", "0..48"]),
        (&["--checkpoint", "./b.part"], &["b.part", "there already", "--resume"]),
        (&["--checkpoint", "/no/such/folder/c"], &["/no/such/folder/c", "cannot write"]),
        (&["-o", "./a.part"], &["a.part", "another name"]),
    ];
    let sky = steradian::output::image::Picture { width: 2, height: 1, pixels: vec![[1.0; 3]; 2] };
    steradian::output::image::write_hdr(bench.path("sky.hdr").as_ref(), &sky).unwrap();
    let before = std::fs::read(bench.path("a.part")).unwrap();
    let sky = bench.path("sky.hdr");
    for (flags, words) in cases {
        let flags: Vec<&str> = flags.iter().map(|f| if *f == "sky.hdr" { sky.as_str() } else { f }).collect();
        bench.refuses(&[&["--resume", "./a.part", "-o", "./x.exr"][..], &flags].concat(), words);
    }
    assert_eq!(std::fs::read(bench.path("a.part")).unwrap(), before, "a refusal leaves the file alone");
    bench.refuses(&["--resume", "./b.part", "--spp", "64"], &["begin at 16", "--samples 16..B"]);
    bench.refuses(&["--resume", "./none"], &["none", "no such file"]);
    bench.refuses(&["--resume", "./a.exr"], &["a.exr", "not a part file"]);
    bench.refuses(&["--checkpoint-every", "5"], &["--checkpoint-every", "--checkpoint"]);
    bench.refuses(&["--checkpoint", "./a.exr/c"], &["a.exr/c", "cannot write"]);
    // Merging.
    let (a, b, out) = (bench.path("a.part"), bench.path("b.part"), bench.path("m.exr"));
    bench.render(&["--samples", "48..64", "-o", "./d.part"]);
    bench.render(&["--samples", "16..32", "--seed", "5", "-o", "./seed.part"]);
    let (d, seed) = (bench.path("d.part"), bench.path("seed.part"));
    refuses(&["merge", &a, &d, "-o", &out], &["samples 16..48 are missing", "a.part", "--samples 16..48"]);
    refuses(&["merge", &a, &a, "-o", &out], &["overlap", "0..16"]);
    refuses(&["merge", &a, &seed, "-o", &out], &["seed.part: its --seed is 5", "a.part is 0", "one render"]);
    refuses(&["merge", &a, &b, "-o", &a], &["a.part", "another name"]);
    refuses(&["merge", &a, &b, "-o", "m.tif"], &["m.tif", "or .part"]);
    refuses(&["merge", &a, "-o", "/no/such/folder/m.exr"], &["/no/such/folder/m.exr", "cannot write"]);
    refuses(&["merge", &a, &b], &["--output"]);
    refuses(&["merge", "-o", &out], &["PARTS"]);
    let other = scene("minimal.toml").display().to_string();
    let room = bench.path("room.part");
    let ran = run(&["render", &other, "--device", "cpu", "--size", "24x16", "--samples", "16..32", "-o", &room]);
    assert_eq!(ran.code, 0, "{}", ran.stderr);
    refuses(&["merge", &a, &room, "-o", &out], &["room.part", "max-depth"]);
}

#[test]
fn damaged_parts_are_refused() {
    let bench = Bench::new("cpu");
    bench.render(&["--samples", "0..16", "-o", "./a.part"]);
    let whole = std::fs::read(bench.path("a.part")).unwrap();
    let (bad, out) = (bench.path("bad.part"), bench.path("m.exr"));
    let mut flipped = whole.clone();
    flipped[whole.len() / 2] ^= 4;
    for (bytes, word) in [
        (&whole[..whole.len() - 1], "cut short"),
        (&whole[..whole.len() / 2], "cut short"),
        (&whole[..30], "too short"),
        (&[][..], "too short"),
        (&flipped[..], "damaged"),
        (&[0; 4096][..], "not a part file"),
    ] {
        std::fs::write(&bad, bytes).unwrap();
        refuses(&["merge", &bad, "-o", &out], &["bad.part", word]);
        bench.refuses(&["--resume", "./bad.part", "-o", "./m.exr"], &["bad.part", word]);
    }
    refuses(&["merge", &bench.dir.path().display().to_string(), "-o", &out], &["directory"]);
    assert!(!Path::new(&out).exists());
}

/// Files may grow to 8 KiB only: the write of a checkpoint fails, is said, and the last good one stays.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_keeps_the_last_checkpoint() {
    let bench = Bench::new("cpu");
    bench.render(&["--spp", "32", "--checkpoint", "./kept", "-o", "./a.exr"]);
    let before = std::fs::read(bench.path("kept")).unwrap();
    let cornell = scene("cornell.toml").display().to_string();
    let check = |shell: &str, word: &str, kept: &Path, before: &[u8]| {
        let output = std::process::Command::new("bash")
            .args(["-c", shell, "bash", env!("CARGO_BIN_EXE_steradian"), "render", &cornell, "--device", "cpu"])
            .args(SIZE)
            .args(["--spp", "4096", "--checkpoint-every", "0.01", "--resume"])
            .arg(kept)
            .args(["-o", &bench.path("b.png"), "--record", &bench.path("b.json")])
            .output()
            .unwrap();
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.contains("the render goes on, and the checkpoint before stays"), "{said}");
        let last = said.trim_end().lines().next_back().unwrap_or_default();
        assert!(last.contains("cannot write") && last.contains(word), "{said}");
        assert_eq!(std::fs::read(kept).unwrap(), before, "the last good file is as it was");
        let folder = std::fs::read_dir(kept.parent().unwrap()).unwrap();
        let left = folder.filter(|f| f.as_ref().unwrap().file_name().to_string_lossy().ends_with(".tmp")).count();
        assert_eq!(left, 0, "half a file is not left behind");
        for name in ["b.png", "b.json"] {
            assert!(Path::new(&bench.path(name)).exists(), "{name} is written nevertheless");
        }
        steradian::output::part::read(kept).unwrap();
    };
    check("ulimit -f 8; exec \"$@\"", "file too large", bench.path("kept").as_ref(), &before);
    // And a disk that is really full, where one can be made.
    let disk = bench.dir.path().join("disk");
    std::fs::create_dir(&disk).unwrap();
    let mount = |arguments: &[&str]| {
        let made = std::process::Command::new("mount").args(arguments).arg(&disk).output();
        made.is_ok_and(|m| m.status.success())
    };
    if !mount(&["-t", "tmpfs", "-o", "size=100k", "tmpfs"]) {
        println!("skipped: a full disk (no tmpfs can be mounted here)");
        return;
    }
    std::fs::write(disk.join("kept"), &before).unwrap();
    let tested = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
        check("exec \"$@\"", "no space left", &disk.join("kept"), &before);
        // Read only: refused before anything is rendered, and the file can still be gone on from into another place.
        assert!(mount(&["-o", "remount,ro"]), "a disk that was mounted can be mounted again");
        let kept = disk.join("kept").display().to_string();
        bench.refuses(&["--resume", &kept, "-o", "./c.png"], &["kept", "cannot write", "read-only"]);
        bench.render(&["--resume", &kept, "--checkpoint", "./elsewhere", "--spp", "48", "-o", "./c.png"]);
    }));
    std::process::Command::new("umount").arg(&disk).status().unwrap();
    tested.unwrap();
}
