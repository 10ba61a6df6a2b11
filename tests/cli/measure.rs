//! `measure`: values against the answers that the scenes state, JSON, and what is refused.

use serde_json::Value;

use super::{refuses, run, scene};

/// Rows of the JSON on the CPU.
fn rows(path: &str, more: &[&str]) -> Vec<Value> {
    let mut arguments = vec!["measure", path, "--json", "--device", "cpu"];
    arguments.extend(more);
    let ran = run(&arguments);
    assert_eq!(ran.code, 0, "{}", ran.stderr);
    ran.stdout.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

/// Within 1.6 half widths: three standard errors.
#[track_caller]
fn holds(row: &Value, wanted: f64) {
    let (value, half_width) = (row["value"][1].as_f64().unwrap(), row["half_width"][1].as_f64().unwrap());
    // The answers are stated to six digits.
    assert!((value - wanted).abs() <= 1.6 * half_width + 1e-5 * wanted, "{wanted} {row}");
}

#[test]
fn answers_of_the_lecture_s_scenes() {
    let power = 2.467_401;
    for (name, answers) in [
        ("meters", &[100.0, std::f64::consts::PI, 1.110_721, 6.579_736 / 4.0, 6.579_736][..]),
        ("cosine", &[1.0, 0.866_025, 0.5, 0.173_648, 0.017_452_4, 0.001_745_33]),
        ("falloff", &[1.0, 0.25, 0.0625, 3.116_101, 1.740_840, 0.039_474_0, 0.002_497_92]),
        ("radiance", &[2.0; 5]),
        ("power", &[power, power, power / (4.0 * std::f64::consts::PI)]),
        // 800 lm: I = 800/(4 pi) cd, in watts over 683.
        ("intensity", &[0.093_209_34, 1.171_303]),
        ("beam", &[1.0, 0.5, 0.173_648, 1.0]),
        ("disc_lamp", &[3.110_488, std::f64::consts::FRAC_PI_2, 0.628_319, 0.031_104_88]),
        ("fresnel", &[0.020_373_2, 0.04, 0.172_394_9, 0.073_964_5]),
        ("critical", &[0.518_613, 0.0, 0.671_062, 0.0, 2.224_296, 0.0]),
        ("magnifier", &[30.0, 27.692_31, 0.050_408_0, 7.616_3]),
    ] {
        let path = scene(&format!("lecture/{name}.toml")).display().to_string();
        let rows = rows(&path, &["--spp", "256"]);
        assert!(rows.len() >= answers.len(), "{name}");
        rows.iter().zip(answers).for_each(|(row, wanted)| holds(row, *wanted));
    }
}

#[test]
fn json_holds_what_its_page_says_and_no_more() {
    let path = scene("lecture/power.toml").display().to_string();
    let page = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/docs/measure.md")).unwrap();
    let rows = rows(&path, &["--spp", "16", "--error", "0.5", "--sensor", "arriving in the ball"]);
    assert_eq!(rows.len(), 1);
    let fields = rows[0].as_object().unwrap();
    for field in fields.keys() {
        assert!(page.contains(&format!("`{field}`")), "{field} is not in docs/measure.md");
    }
    for (field, wanted) in [("unit", "W"), ("luminous_unit", "lm"), ("quantity", "flux"), ("device_kind", "cpu")] {
        assert_eq!(fields[field], wanted);
    }
    assert!((fields["area_m2"].as_f64().unwrap() - 4.0 * std::f64::consts::PI).abs() < 1e-9);
    let luminous = fields["luminous"].as_f64().unwrap() / fields["value"][1].as_f64().unwrap();
    assert!((luminous / 683.0 - 1.0).abs() < 1e-9, "a grey flux of 1 W is 683 lm: {luminous}");
}

#[test]
fn the_table_is_for_people_and_repeats_with_its_seed() {
    let path = scene("lecture/cosine.toml").display().to_string();
    let text = |seed: &str| run(&["measure", &path, "--device", "cpu", "--spp", "20", "--seed", seed]);
    let ran = text("1");
    assert_eq!(ran.code, 0, "{}", ran.stderr);
    assert!(ran.stderr.contains("20 samples are rounded up to 32"), "{}", ran.stderr);
    assert!(ran.stdout.contains("W/m2") && ran.stdout.contains("lx") && ran.stdout.contains("±"), "{}", ran.stdout);
    let numbers = |text: &str| text.lines().take(7).map(str::to_owned).collect::<Vec<_>>();
    assert_eq!(numbers(&ran.stdout), numbers(&text("1").stdout));
    assert_ne!(numbers(&ran.stdout), numbers(&text("2").stdout));
}

#[test]
fn what_cannot_be_measured_is_one_sentence() {
    let dir = tempfile::tempdir().unwrap();
    let written = |sensor: &str| {
        let path = dir.path().join("s.toml");
        let shapes = "[[shape]]\ntype = \"sphere\"\nname = \"globe\"\n\
                      [[shape]]\ntype = \"mesh\"\nname = \"line\"\npositions = [[0, 0, 0], [1, 0, 0], [2, 0, 0]]\ntriangles = [[0, 1, 2]]\n";
        std::fs::write(&path, format!("{shapes}{sensor}")).unwrap();
        path.display().to_string()
    };
    refuses(&["measure", &written("")], &["s.toml", "no sensors", "[[sensor]]"]);
    let point = "[[sensor]]\nname = \"a\"\ntype = \"irradiance\"\nposition = [0, 3, 0]\n";
    let cases: [(&str, &[&str]); 13] = [
        ("[[sensor]]\nname = \"a\"\n", &["type"]),
        ("[[sensor]]\nname = \"a\"\ntype = \"radience\"\n", &["type", "radiance"]),
        ("[[sensor]]\ntype = \"flux\"\nshape = \"globe\"\n", &["name"]),
        ("[[sensor]]\nname = \"a\"\ntype = \"flux\"\nshape = \"glob\"\n", &["shape", "glob", "did you mean `globe`"]),
        ("[[sensor]]\nname = \"a\"\ntype = \"flux\"\nshape = \"line\"\n", &["shape", "line", "area"]),
        ("[[sensor]]\nname = \"a\"\ntype = \"flux\"\nshape = \"globe\"\nside = \"top\"\n", &["side", "front", "back"]),
        ("[[sensor]]\nname = \"a\"\ntype = \"flux\"\nnormal = [0, 1, 0]\n", &["normal", "flux"]),
        ("[[sensor]]\nname = \"a\"\ntype = \"radiance\"\nposition = [0, 0, 3]\n", &["direction"]),
        (
            "[[sensor]]\nname = \"a\"\ntype = \"radiance\"\nposition = [0, 0, nan]\ndirection = [0, 0, 1]\n",
            &["position", "finite"],
        ),
        (&format!("{point}normal = [0, 0, 0]\n"), &["normal", "must not be zero"]),
        (&format!("{point}normal = [0, inf, 0]\n"), &["normal", "finite"]),
        (&format!("{point}normal = [0, 1, 0]\nshape = \"globe\"\n"), &["position", "shape"]),
        (&format!("{point}normal = [0, 1, 0]\n{point}normal = [0, 1, 0]\n"), &["name", "taken"]),
    ];
    for (sensor, words) in cases {
        let mut all = vec!["s.toml"];
        all.extend(words);
        refuses(&["measure", &written(sensor)], &all);
    }
    let sound = written(&format!("{point}normal = [0, 1e-200, 0]\n"));
    refuses(&["measure", &sound, "--sensor", "b"], &["\"b\"", "known are: a"]);
    refuses(&["measure", &sound, "--error", "0"], &["--error", "above 0"]);
    refuses(&["measure", &sound, "--spp", "0"], &["--spp"]);
    // Inside geometry is a place like any other.
    let inside = written("[[sensor]]\nname = \"a\"\ntype = \"irradiance\"\nposition = [0, 0, 0]\nnormal = [0, 1, 0]\n");
    let ran = run(&["measure", &inside, "--device", "cpu", "--spp", "16"]);
    assert_eq!(ran.code, 0, "{}", ran.stderr);
}
