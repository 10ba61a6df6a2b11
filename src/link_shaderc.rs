//! Build script: names the static archives that Debian's libshaderc needs, and embeds `shaders/` in the binary.
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

/// Writes `OUT_DIR/shaders.rs` with `FILES: [(path, text)]`, sorted by path; src/shader/source.rs includes it.
fn embed_shaders() {
    println!("cargo:rerun-if-changed=shaders");
    let root = PathBuf::from(std::env::var_os("CARGO_MANIFEST_DIR").expect("cargo sets it")).join("shaders");
    let (mut folders, mut files) = (vec![root.clone()], Vec::new());
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).into_iter().flatten().flatten() {
            let path = entry.path();
            if path.is_dir() {
                folders.push(path);
            } else {
                let name = path.strip_prefix(&root).expect("it lies under the root").to_string_lossy().into_owned();
                files.push((name, path));
            }
        }
    }
    files.sort();
    let mut text = "pub static FILES: &[(&str, &str)] = &[\n".to_owned();
    for (name, path) in files {
        text += &format!("    ({name:?}, include_str!({:?})),\n", path.to_string_lossy());
    }
    let target = PathBuf::from(std::env::var_os("OUT_DIR").expect("cargo sets it")).join("shaders.rs");
    std::fs::write(target, text + "];\n").expect("OUT_DIR is writable");
}
