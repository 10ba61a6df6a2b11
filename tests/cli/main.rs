//! The program from outside: texts, exit codes, files. Renders on the CPU reference, which every machine has.

mod adaptive;
mod bad_input;
mod broken_files;
mod compare;
mod converge;
mod kills;
mod lights;
mod measure;
mod render;
mod resume;
#[path = "../support/triangle.rs"]
mod triangle;

use std::path::{Path, PathBuf};

use assert_cmd::Command;

/// The program, without the user's log settings.
pub fn steradian() -> Command {
    let mut command = Command::cargo_bin("steradian").unwrap();
    command.env_remove("RUST_LOG").timeout(std::time::Duration::from_secs(120));
    command
}

/// A small scene of this repository.
pub fn scene(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(name)
}

/// What a command printed and its exit code.
pub struct Ran {
    pub code: i32,
    pub stdout: String,
    pub stderr: String,
}

pub fn run(arguments: &[&str]) -> Ran {
    let output = steradian().args(arguments).output().unwrap();
    Ran {
        code: output.status.code().unwrap_or(-1),
        stdout: String::from_utf8(output.stdout).unwrap(),
        stderr: String::from_utf8(output.stderr).unwrap(),
    }
}

/// Exit code 2, nothing on stdout, and one sentence on stderr that holds every one of `words`.
#[track_caller]
pub fn refuses(arguments: &[&str], words: &[&str]) {
    let ran = run(arguments);
    let said = format!("{arguments:?}: exit {}, stderr: {}", ran.code, ran.stderr);
    assert_eq!(ran.code, 2, "{said}");
    assert_eq!(ran.stdout, "", "{said}");
    assert_eq!(ran.stderr.trim_end().lines().count(), 1, "{said}");
    assert!(ran.stderr.starts_with("steradian: "), "{said}");
    for word in words {
        assert!(ran.stderr.contains(word), "\"{word}\" is missing: {said}");
    }
}
