//! What a kernel holds, for scenes that differ: `includes()`, `defines()`, `tables()` and `constants()` as text in snapshots/.
//!
//! A change of what a scene gets compiled shows in review. `STERADIAN_BLESS=1 cargo test --lib shader::snapshots` writes them again.

use std::fmt::Write;
use std::path::Path;

use super::assemble::{constants, includes};
use crate::integrator::{Estimator, SamplerKind, Settings};
use crate::prepare::features::Features;
use crate::prepare::prepare;
use crate::reference::scenes;
use crate::scene::Scene;

/// Macros that are off are left out of the text: a new one then changes only the scenes that need it.
fn snapshot(scene: &Scene, settings: &Settings) -> String {
    let prepared = prepare(scene, settings).unwrap();
    let features = Features::of(&prepared, settings);
    let defines = features.defines();
    let on: Vec<&str> = defines.iter().filter(|d| d.1).map(|d| d.0).collect();
    let tables: Vec<&str> = features.tables().map(|t| t.name).collect();
    let constants = constants(settings, &prepared).map(|(name, value)| format!("{name} = {value}"));
    let mut text = String::new();
    for (title, lines) in [("includes", includes(&features).join("\n")), ("defines", on.join("\n"))] {
        let _ = writeln!(text, "[{title}]\n{lines}\n");
    }
    let _ = writeln!(text, "[tables]\n{}\n\n[constants]\n{}", tables.join("\n"), constants.join("\n"));
    text
}

fn check(name: &str, scene: &Scene, settings: &Settings) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("src/shader/snapshots/{name}.txt"));
    let text = snapshot(scene, settings);
    if std::env::var_os("STERADIAN_BLESS").is_some() {
        std::fs::write(&path, &text).unwrap();
    }
    let kept = std::fs::read_to_string(&path).unwrap_or_default();
    for (line, (is, was)) in text.lines().zip(kept.lines()).enumerate() {
        assert_eq!(
            is,
            was,
            "{}:{}: if that is meant, bless it (see the page of src/shader/snapshots.rs)",
            path.display(),
            line + 1
        );
    }
    assert_eq!(text, kept, "{}: if that is meant, bless it", path.display());
}

#[test]
fn kernels_hold_what_they_held() {
    let settings = Settings::default();
    for scene in [scenes::cornell(16), scenes::alpha_sheets(16), scenes::textured(16), scenes::materials(16)] {
        check(&scene.name, &scene, &settings);
    }
    let plain = Settings { estimator: Estimator::Bsdf, sampler: SamplerKind::Independent, ..settings };
    check("cornell-bsdf", &scenes::cornell(16), &plain);
}

#[test]
fn every_macro_is_always_given_once() {
    let names = |scene: &Scene| -> Vec<&'static str> {
        let settings = Settings::default();
        let features = Features::of(&prepare(scene, &settings).unwrap(), &settings);
        assert_eq!(features.defines().len(), features.clone().everything().defines().len());
        features.defines().iter().map(|d| d.0).collect()
    };
    let all = names(&scenes::cornell(16));
    let mut once = all.clone();
    once.sort_unstable();
    once.dedup();
    assert_eq!(once.len(), all.len(), "a macro is defined twice");
    assert_eq!(all, names(&scenes::materials(16)), "a macro is missing where it is off");
}
