//! KHR_lights_punctual, each light read from a file made here.

use std::f64::consts::PI;

use steradian::light::Lamp;
use steradian::scene::{self, Scene};

use crate::triangle::*;

/// One node that carries `light`, turned by `rotation` and moved, below a node that doubles everything.
fn load(light: &str, rotation: &str) -> Result<Scene, String> {
    let folder = Folder::new();
    let text = format!(
        r#"{{"asset": {{"version": "2.0"}}, "extensionsUsed": ["KHR_lights_punctual"],
        "extensions": {{"KHR_lights_punctual": {{"lights": [{light}]}}}}, "scene": 0, "scenes": [{{"nodes": [0]}}],
        "nodes": [{{"scale": [2, 2, 2], "children": [1]}}, {{"name": "n", "translation": [1, 2, 3], "rotation": {rotation},
            "extensions": {{"KHR_lights_punctual": {{"light": 0}}}}}}]}}"#
    );
    scene::load(&folder.write("made.gltf", text.as_bytes())).map_err(|e| e.to_string())
}

const STRAIGHT: &str = "[0, 0, 0, 1]";
/// -90 degrees about x: -z becomes -y.
const DOWN: &str = "[-0.7071067811865476, 0, 0, 0.7071067811865476]";

#[test]
fn candela_and_lux_become_watts_and_nodes_aim() {
    let scene = load(r#"{"type": "point", "intensity": 683, "color": [1, 0.5, 0.25], "range": 5}"#, STRAIGHT).unwrap();
    let Lamp::Point(point) = scene.lights[0].lamp else { panic!("{:?}", scene.lights) };
    assert_eq!((point.position.to_array(), point.intensity.to_array()), ([2.0, 4.0, 6.0], [1.0, 0.5, 0.25]));
    assert!(scene.notes.iter().any(|n| n.contains("`range` of lights is not used")), "{:?}", scene.notes);
    assert!(!scene.notes.iter().any(|n| n.contains("KHR_lights_punctual")), "{:?}", scene.notes);

    let scene = load(r#"{"type": "directional", "intensity": 1366}"#, DOWN).unwrap();
    let Lamp::Directional(sun) = scene.lights[0].lamp else { panic!("{:?}", scene.lights) };
    assert!((sun.to_light.y - 1.0).abs() < 1e-12 && (sun.irradiance.x - 2.0).abs() < 1e-12, "{sun:?}");

    let spot = r#"{"type": "spot", "intensity": 683, "spot": {"innerConeAngle": 0.2, "outerConeAngle": 0.6}}"#;
    let Lamp::Spot(spot) = load(spot, DOWN).unwrap().lights[0].lamp else { panic!("a spot") };
    assert!((spot.axis.y + 1.0).abs() < 1e-12);
    for angle in [0.0f64, 0.1, 0.3, 0.5, 0.7, 3.0] {
        // The specification's own words: scale and offset, held to [0, 1], squared.
        let scale = 1.0 / (0.2f64.cos() - 0.6f64.cos()).max(0.001);
        let expected = (angle.cos() * scale - 0.6f64.cos() * scale).clamp(0.0, 1.0).powi(2);
        assert!((spot.falloff.share(angle.cos()) - expected).abs() < 1e-12, "{angle}");
    }
    let Lamp::Spot(default) = load(r#"{"type": "spot"}"#, STRAIGHT).unwrap().lights[0].lamp else { panic!("a spot") };
    assert_eq!((default.falloff.share(1.0), default.falloff.share((0.251 * PI).cos())), (1.0, 0.0));
    assert!((default.intensity.x * 683.0 - 1.0).abs() < 1e-12);
    // The same angle twice is a hard cone, not a division by 0.
    let hard = r#"{"type": "spot", "spot": {"innerConeAngle": 0.5, "outerConeAngle": 0.5}}"#;
    let Lamp::Spot(hard) = load(hard, STRAIGHT).unwrap().lights[0].lamp else { panic!("a spot") };
    assert_eq!([0.499f64, 0.501].map(|a| hard.falloff.share(a.cos())), [1.0, 0.0]);
}

/// Two nodes with the same light, one with a mesh beside it: a node that is hidden takes its own light along, in every copy.
#[test]
fn a_hidden_node_s_light_is_dark() {
    let folder = Folder::new();
    let with_light =
        |node: &str| node.replace(r#""name""#, r#""extensions": {"KHR_lights_punctual": {"light": 0}}, "name""#);
    let leaf = r#"{"name": "leaf", "mesh": 0}"#;
    let text = TRIANGLE
        .replacen(r#"{"name": "root""#, &with_light(r#"{"name": "root""#), 1)
        .replacen(leaf, &with_light(leaf), 1)
        .replacen(
            r#""scene": 0,"#,
            r#""extensions": {"KHR_lights_punctual": {"lights": [{"type": "point"}]}}, "scene": 0,"#,
            1,
        );
    folder.write("lit.gltf", text.as_bytes());
    let scene = |patch: &str| {
        let model = "[[model]]\nfile = \"lit.gltf\"\ncopies = [{}, { translate = [5, 0, 0] }]\n";
        scene::load(&folder.write("lit.toml", format!("{model}{patch}").as_bytes())).map_err(|e| e.to_string())
    };
    let counts = |s: Result<Scene, String>| s.map(|s| (s.instances.len(), s.lights.len())).unwrap();
    assert_eq!(counts(scene("")), (2, 4));
    assert_eq!(counts(scene("[node.root]\nvisible = false\n")), (2, 2));
    assert_eq!(counts(scene("[node.\"root/leaf\"]\nvisible = false\n")), (0, 2));
    assert_eq!(counts(scene("[node.0]\nvisible = false\n[node.leaf]\nvisible = false\n")), (0, 0));
    let refused = scene("[[material]]\nname = \"x\"\n[node.root]\nmaterial = \"x\"\n").unwrap_err();
    assert!(
        refused.contains("lit.toml:7:12: `material` in [node.\"path/name\"] is given to a node that has a light"),
        "{refused}"
    );
}

#[test]
fn lights_that_are_none_are_refused() {
    for (light, wanted) in [
        (r#"{"type": "area"}"#, "light 0: type \"area\" is not point, spot or directional"),
        (r#"{"type": "point", "intensity": -1}"#, "light 0: its colour and intensity"),
        (r#"{"type": "point", "color": [1, -0.5, 0]}"#, "light 0: its colour and intensity"),
        (r#"{"type": "spot", "spot": {"outerConeAngle": 1.6}}"#, "light 0: its cone must have"),
        (r#"{"type": "spot", "spot": {"innerConeAngle": 0.7, "outerConeAngle": 0.6}}"#, "light 0: its cone must have"),
        (r#"{"type": "spot", "spot": {"innerConeAngle": 0, "outerConeAngle": 0}}"#, "light 0: its cone must have"),
    ] {
        let said = load(light, STRAIGHT).unwrap_err();
        assert!(said.contains(wanted), "{light}: {said}");
    }
    let said = load("", STRAIGHT).unwrap_err();
    assert!(said.contains("light") && said.contains('0'), "{said}");
}

#[test]
fn a_model_s_lights_take_the_groups_that_patches_name() {
    let folder = Folder::new();
    let text = r#"{"asset": {"version": "2.0"}, "extensionsUsed": ["KHR_lights_punctual"],
        "extensions": {"KHR_lights_punctual": {"lights": [{"type": "point"}]}}, "scene": 0, "scenes": [{"nodes": [0, 1]}],
        "nodes": [{"name": "left", "extensions": {"KHR_lights_punctual": {"light": 0}}},
            {"name": "right", "extensions": {"KHR_lights_punctual": {"light": 0}}}]}"#;
    folder.write("made.gltf", text.as_bytes());
    let model = "[[model]]\nfile = \"made.gltf\"\n";
    let load = |more: &str| scene::load(&folder.write("made.toml", format!("{model}{more}").as_bytes()));
    let groups = |more: &str| load(more).unwrap().light_groups();
    assert_eq!(groups(""), ["default"]);
    assert_eq!(groups("group = \"lamps\"\n"), ["lamps"]);
    assert_eq!(groups("group = \"lamps\"\n[node.\"left\"]\ngroup = \"key\"\n"), ["key", "lamps"]);
    assert_eq!(load("[node.\"left\"]\nvisible = false\n").unwrap().lights.len(), 1);
    let said = load("[node.\"lift\"]\ngroup = \"key\"\n").unwrap_err().to_string();
    assert!(said.contains("did you mean `left`?"), "{said}");
}
