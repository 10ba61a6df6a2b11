//! Build script: names the static archives that Debian's libshaderc needs.
//!
//! libshaderc_combined.a of the package libshaderc-dev does not hold glslang and SPIRV-Tools, so the linker must be
//! given both (packages glslang-dev and spirv-tools). With the feature `shaderc-from-source` nothing is added.

use std::path::Path;

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
    if std::env::var_os("CARGO_FEATURE_SHADERC_FROM_SOURCE").is_some() {
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
}
