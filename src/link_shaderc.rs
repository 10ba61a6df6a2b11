//! Build script: names the static archives that Debian's libshaderc needs, embeds `shaders/` in the binary, and hashes the sources
//! that samples depend on.
//!
//! libshaderc_combined.a of the package libshaderc-dev does not hold glslang and SPIRV-Tools, so the linker must be
//! given both (packages glslang-dev and spirv-tools). With the feature `shaderc-from-source` nothing is added.

use std::path::{Path, PathBuf};

const ARCHIVES: [&str; 10] = [
    "glslang",
    "MachineIndependent",
    "GenericCodeGen",
    "OSDependent",
    "OGLCompiler",
    "HLSL",
    "SPIRV",
    "glslang-default-resource-limits",
    "SPIRV-Tools-opt",
    "SPIRV-Tools",
];

fn main() {
    println!("cargo:rerun-if-changed=src/link_shaderc.rs");
    embed_shaders();
    hash_sources();
    if std::env::var_os("CARGO_FEATURE_SHADERC_FROM_SOURCE").is_some() {
        println!("cargo:rustc-env=STERADIAN_SHADERC=from-source");
        return;
    }
    let triple = std::env::var("CARGO_CFG_TARGET_ARCH").unwrap_or_default();
    let folder = format!("/usr/lib/{triple}-linux-gnu");
    if !Path::new(&folder).join("libglslang.a").exists() {
        println!(
            "cargo:warning=libglslang.a is not in {folder}: run ./x once, which installs it, or build with --features shaderc-from-source"
        );
    }
    println!("cargo:rustc-link-search=native={folder}");
    for archive in ARCHIVES {
        println!("cargo:rustc-link-lib=static={archive}");
    }
    fingerprint(Path::new(&folder));
}

/// Sizes and times of the compiler's archives, a part of the SPIR-V cache's key: shaderc does not tell its version.
fn fingerprint(folder: &Path) {
    let mut text = String::new();
    for archive in ["shaderc_combined", "SPIRV", "MachineIndependent", "SPIRV-Tools-opt"] {
        let path = folder.join(format!("lib{archive}.a"));
        let Ok(meta) = std::fs::metadata(&path) else { continue };
        println!("cargo:rerun-if-changed={}", path.display());
        let since = meta.modified().ok().and_then(|t| t.duration_since(std::time::UNIX_EPOCH).ok());
        text += &format!("{archive}:{}:{} ", meta.len(), since.map_or(0, |d| d.as_secs()));
    }
    println!("cargo:rustc-env=STERADIAN_SHADERC={}", text.trim());
}

/// All files below `root` with their names from there, sorted.
fn files_under(root: &Path) -> Vec<(String, PathBuf)> {
    let (mut folders, mut files) = (vec![root.to_owned()], Vec::new());
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).into_iter().flatten().flatten() {
            let path = entry.path();
            if path.is_dir() {
                folders.push(path);
            } else {
                let name =
                    path.strip_prefix(root).expect("it lies under the root").to_string_lossy().replace('\\', "/");
                files.push((name, path));
            }
        }
    }
    files.sort();
    files
}

/// Folders of `src` that come after the samples, or only check them.
const NOT_SAMPLES: [&str; 6] = ["cli", "conform", "measure", "output", "report", "showcase"];

/// A hash (FNV-1a, 64 bits) of every source that a sample can depend on, tests left out: films of two builds are of one render only
/// where it is the same. See `output::part::identity`.
fn hash_sources() {
    let root = PathBuf::from(std::env::var_os("CARGO_MANIFEST_DIR").expect("cargo sets it"));
    let mut folders = vec![root.join("shaders")];
    for entry in std::fs::read_dir(root.join("src")).into_iter().flatten().flatten() {
        if entry.path().is_dir() && !NOT_SAMPLES.iter().any(|name| entry.file_name() == *name) {
            folders.push(entry.path());
        }
    }
    folders.sort();
    let mut hash = 0xcbf2_9ce4_8422_2325u64;
    let mut add = |bytes: &[u8]| {
        for byte in bytes.iter().filter(|b| **b != b'\r') {
            hash = (hash ^ u64::from(*byte)).wrapping_mul(0x100_0000_01b3);
        }
    };
    // A new folder comes with a line there.
    println!("cargo:rerun-if-changed=src/lib.rs");
    for folder in folders {
        println!("cargo:rerun-if-changed={}", folder.display());
        for (name, path) in files_under(&folder) {
            if name.ends_with("tests.rs") {
                continue;
            }
            add(name.as_bytes());
            add(&[0]);
            add(&std::fs::read(&path).expect("a source can be read"));
            add(&[0]);
        }
    }
    println!("cargo:rustc-env=STERADIAN_SOURCES={hash:016x}");
}

/// Writes `OUT_DIR/shaders.rs` with `FILES: [(path, text)]`, sorted by path; src/shader/source.rs includes it.
fn embed_shaders() {
    println!("cargo:rerun-if-changed=shaders");
    let root = PathBuf::from(std::env::var_os("CARGO_MANIFEST_DIR").expect("cargo sets it")).join("shaders");
    let files = files_under(&root);
    let mut text = "pub static FILES: &[(&str, &str)] = &[\n".to_owned();
    for (name, path) in files {
        text += &format!("    ({name:?}, include_str!({:?})),\n", path.to_string_lossy());
    }
    let target = PathBuf::from(std::env::var_os("OUT_DIR").expect("cargo sets it")).join("shaders.rs");
    std::fs::write(target, text + "];\n").expect("OUT_DIR is writable");
}
