//! SIGKILL at random moments of a render that keeps checkpoints: after each the checkpoint is whole and no older than the one before,
//! and what is gone on with in the end is the picture of a render that nobody killed, bit for bit.
//!
//! Five kills by default, and one more for every four of them at a moment when a checkpoint is half written. More:
//! `STERADIAN_KILLS=100 cargo test --test cli kills -- --nocapture`; `STERADIAN_SEED` for other moments.
#![cfg(unix)]

use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use super::resume::{devices, layers};
use super::scene;

const SPP: &str = "256";

struct Case<'a> {
    folder: &'a Path,
    device: &'static str,
}

impl Case<'_> {
    fn spawn(&self, picture: &str, keep: &[&str]) -> Child {
        Command::new(env!("CARGO_BIN_EXE_steradian"))
            .arg("render")
            .arg(scene("cornell.toml"))
            .args(["--device", self.device, "--size", "64x48", "--spp", SPP])
            .args(keep)
            .arg("-o")
            .arg(self.folder.join(picture))
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap()
    }

    /// One more run of the render that is killed over and over.
    fn go_on(&self) -> Child {
        let kept = self.folder.join("kept").display().to_string();
        let flag = if Path::new(&kept).exists() { "--resume" } else { "--checkpoint" };
        self.spawn("killed.exr", &[flag, &kept, "--checkpoint-every", "0.02"])
    }
}

#[test]
fn kills_lose_no_checkpoint_and_no_bit() {
    let wanted: u32 = std::env::var("STERADIAN_KILLS").ok().and_then(|n| n.parse().ok()).unwrap_or(5);
    // The fastest device that is here: on it most of a run is samples and checkpoints.
    let device = devices().pop().unwrap();
    let dir = tempfile::tempdir().unwrap();
    let case = Case { folder: dir.path(), device };
    // The first run compiles.
    assert!(case.spawn("one.exr", &[]).wait().unwrap().success());
    let begun = Instant::now();
    assert!(case.spawn("one.exr", &[]).wait().unwrap().success());
    let life_s = begun.elapsed().as_secs_f64();
    let one = layers(&dir.path().join("one.exr"));
    let kept = dir.path().join("kept");
    let seed: u64 = std::env::var("STERADIAN_SEED").ok().and_then(|n| n.parse().ok()).unwrap_or(1);
    let mut state = seed | 1;
    let mut tries_left = 20 * wanted;
    let (mut kills, mut aimed, mut blocks) = (0, 0, 0);
    let (mut finished, mut in_writing, mut without) = (0, 0, 0);
    let is_finished = |finished: &mut i32| {
        assert!(layers(&dir.path().join("killed.exr")) == one, "seed {seed}: not the bits of one run");
        std::fs::remove_file(&kept).unwrap();
        *finished += 1;
    };
    while kills + aimed < wanted + wanted / 4 {
        assert!(tries_left > 0, "seed {seed}: renders end before they are killed");
        tries_left -= 1;
        let mut child = case.go_on();
        let is_aimed = aimed < (kills + aimed) / 5;
        if is_aimed {
            let half = dir.path().join(format!(".kept.{}.tmp", child.id()));
            while !half.exists() && child.try_wait().unwrap().is_none() {
                std::thread::sleep(Duration::from_micros(50));
            }
        } else {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            std::thread::sleep(Duration::from_secs_f64(life_s * (state >> 40) as f64 / (1u64 << 24) as f64));
        }
        if let Some(status) = child.try_wait().unwrap() {
            assert!(status.success(), "seed {seed}: {status}");
            is_finished(&mut finished);
            blocks = 0;
            continue;
        }
        child.kill().unwrap();
        // A render that ended between the question and the signal was not killed.
        let was_killed = child.wait().unwrap().code().is_none();
        *(if is_aimed { &mut aimed } else { &mut kills }) += u32::from(was_killed);
        let files: Vec<String> = std::fs::read_dir(dir.path())
            .unwrap()
            .map(|f| f.unwrap().file_name().to_string_lossy().into_owned())
            .collect();
        in_writing += i32::from(files.iter().any(|f| f.contains(".kept.") && f.contains(&child.id().to_string())));
        let left = files.iter().filter(|f| f.ends_with(".tmp")).count();
        assert!(left <= 2, "what a killed run leaves is removed by the next: {files:?}");
        if !kept.exists() {
            assert_eq!(blocks, 0, "seed {seed}: a checkpoint is gone");
            without += 1;
            continue;
        }
        let part = steradian::output::part::read(&kept).unwrap_or_else(|e| panic!("seed {seed}: {e}"));
        assert!(part.film.min_block_count() >= blocks, "seed {seed}: an older checkpoint");
        blocks = part.film.min_block_count();
    }
    assert!(case.go_on().wait().unwrap().success());
    is_finished(&mut finished);
    println!(
        "{device}: {kills} kills at random moments and {aimed} aimed at a write, in {:.0} s (seed {seed}; a whole run takes {life_s:.1} \
         s): {in_writing} left half a checkpoint, {without} came before the first one; every checkpoint left was whole, {finished} renders gone on with to the end, all of them the bits of one run",
        begun.elapsed().as_secs_f64()
    );
}
