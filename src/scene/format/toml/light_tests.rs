use std::f64::consts::PI;

use super::*;
use crate::scene::format::toml::parse;
use crate::scene::{Scene, SkyRadiance};

fn read(text: &str) -> Result<Scene, String> {
    parse(text, std::path::Path::new("test.toml")).map_err(|e| e.to_string())
}

fn lamp(text: &str) -> Lamp {
    read(&format!("[[light]]\n{text}")).unwrap().lights[0].lamp
}

fn intensity(text: &str) -> DVec3 {
    match lamp(text) {
        Lamp::Point(p) => p.intensity,
        Lamp::Spot(s) => s.intensity,
        Lamp::Directional(d) => d.irradiance,
        Lamp::Sun(s) => s.irradiance,
    }
}

fn near(a: DVec3, b: DVec3) -> bool {
    (a - b).length() <= 1e-12 * b.length()
}

#[test]
fn units_become_watts() {
    let point = |strength: &str| intensity(&format!("type = \"point\"\nposition = [0, 0, 0]\n{strength}"));
    assert!(near(point("power = 5"), DVec3::splat(5.0 / (4.0 * PI))));
    assert!(near(point("power = [4, 2, 1]"), DVec3::new(4.0, 2.0, 1.0) / (4.0 * PI)));
    assert_eq!(point("intensity = [4, 2, 1]"), DVec3::new(4.0, 2.0, 1.0));
    // 800 lm are 63.66 cd.
    assert!((point("power_lm = 800").x * 683.0 - 63.661_977).abs() < 1e-6);
    assert!((point("intensity_cd = 63.66").x * 683.0 - 63.66).abs() < 1e-12);
    // A colour keeps the luminous flux.
    for color in ["color = [1, 0.2, 0]", "color = [0, 0, 9]", "temperature_k = 2700", "temperature_k = 6504"] {
        let rgb = point(&format!("power_lm = 800\n{color}"));
        assert!((luminance(rgb) * 683.0 - 63.661_977).abs() < 1e-6 && rgb.min_element() >= 0.0, "{color}");
    }
    let directional = |rest: &str| intensity(&format!("type = \"directional\"\ndirection = [0, -2, 0]\n{rest}"));
    assert!(near(directional("irradiance_lx = 683"), DVec3::ONE));
    assert!(near(directional("irradiance = 3\nangular_diameter_deg = 0.533"), DVec3::splat(3.0)));
    let Lamp::Sun(sun) =
        lamp("type = \"directional\"\ndirection = [0, -2, 0]\nirradiance = 1\nangular_diameter_deg = 2")
    else {
        panic!("a diameter makes it a sun")
    };
    assert_eq!((sun.to_light, sun.half_angle_rad), (DVec3::Y, 1f64.to_radians()));
}

#[test]
fn a_spot_of_some_power_has_that_power() {
    for falloff in [
        "falloff = \"hard\"\ncone_deg = 30",
        "falloff = \"cosine\"",
        "falloff = \"cosine\"\nexponent = 20",
        "cone_deg = 40\ninner_cone_deg = 10",
    ] {
        let text = format!("type = \"spot\"\nposition = [0, 2, 0]\ntarget = [0, 0, 0]\npower = 7\n{falloff}");
        let Lamp::Spot(spot) = lamp(&text) else { panic!("{text}") };
        assert_eq!(spot.axis, DVec3::NEG_Y);
        let power = spot.falloff.solid_angle() * spot.intensity.x;
        assert!((power - 7.0).abs() < 1e-12, "{falloff} {power}");
    }
}

#[test]
fn lamps_with_a_surface_take_power_and_nits() {
    let lamp = |material: &str, shape: &str| {
        let scene =
            read(&format!("[[material]]\nname = \"m\"\nalbedo = 0\n{material}\n[[shape]]\nmaterial = \"m\"\n{shape}"))
                .unwrap();
        let Some(Value::Constant(c)) = scene.materials[scene.instances[0].material].emission else { panic!("no lamp") };
        DVec3::new(c[0], c[1], c[2])
    };
    let ball = "type = \"sphere\"\nradius = 0.5\n";
    // Phi = pi L A.
    assert!(near(lamp("", &format!("{ball}power = 3")), DVec3::splat(3.0 / (PI * PI))));
    let red = lamp("emission = [2, 1, 1]", &format!("{ball}power_lm = 683"));
    assert!((luminance(red) * PI * PI - 1.0).abs() < 1e-12 && (red.x / red.y - 2.0).abs() < 1e-12);
    let sheet = "type = \"rectangle\"\nu = [2, 0, 0]\nv = [0, 0, -1]\npower = 8";
    assert!(near(lamp("emission = 1\nemission_two_sided = true", sheet), DVec3::splat(8.0 / (PI * 8.0 * 2.0))));
    assert!(near(lamp("", "type = \"box\"\npower = 24"), DVec3::splat(1.0 / PI)));
    assert!(near(lamp("", "type = \"disc\"\nradius = 2\npower = 4"), DVec3::splat(1.0 / (PI * PI))));
    assert!(near(lamp("emission_nt = [683, 1366, 0]", ball), DVec3::new(1.0, 2.0, 0.0)));
}

#[test]
fn skies_in_nits_and_lux() {
    let sky = |text: &str| read(&format!("[sky]\n{text}")).unwrap().sky.unwrap();
    let uniform = |s: &crate::scene::Sky| match s.radiance {
        SkyRadiance::Uniform(radiance) => radiance * s.scale,
        SkyRadiance::Image(_) => panic!("uniform"),
    };
    assert!(near(uniform(&sky("radiance_nt = 1366")), DVec3::splat(2.0)));
    // 10000 lx on the ground from a uniform sky: L = E/pi.
    assert!(near(uniform(&sky("radiance = 5\nilluminance_lx = 10000")), DVec3::splat(10000.0 / 683.0 / PI)));
}

/// The texels' own weights against the quadrature of the bilinear sky that is rendered.
#[test]
fn the_illuminance_of_a_picture_is_that_of_the_sky_it_makes() {
    let (width, height) = (64u32, 32u32);
    let texel = |k: u32| {
        let (i, j) = (k % width, k / width);
        [1.0 + 0.3 * (i as f32 / 10.0).sin(), 1.0 + j as f32 * 0.05, if (i, j) == (9, 6) { 300.0 } else { 0.5 }]
    };
    let pixels: Vec<f32> = (0..width * height).flat_map(texel).collect();
    let pixels = crate::scene::Pixels::RgbF32(pixels.into());
    let images = [crate::scene::Image { name: "sky".into(), width, height, pixels }];
    let sky = crate::scene::Sky { radiance: SkyRadiance::Image(0), rotation_rad: 0.3, scale: 1.7 };
    let input = crate::prepare::lights::LightInput {
        sky: Some((&sky, &images)),
        scene_radius: 1.0,
        ..crate::prepare::lights::LightInput::default()
    };
    let t = crate::prepare::lights::build(&input).unwrap();
    let view = crate::light::sky::SkyView { sky: &t.sky, texels: &t.sky_texels, alias: &t.sky_alias };
    let exact = luminance(crate::light::integrals::sky_irradiance(DVec3::Y, 512, |d| view.radiance(d)));
    let stated = sky.horizontal_irradiance(&images);
    assert!((stated / exact - 1.0).abs() < 5e-3, "{stated} {exact}");
}

#[test]
fn what_is_wrong_is_said() {
    let point = "type = \"point\"\nposition = [0, 1, 0]\n";
    let spot = "type = \"spot\"\nposition = [0, 1, 0]\ndirection = [0, -1, 0]\nintensity = 1\n";
    let sun = "type = \"directional\"\ndirection = [0, -1, 0]\n";
    for (text, wanted) in [
        ("type = \"lamp\"".to_owned(), "without a known type"),
        ("type = \"point\"\npower = 1".to_owned(), "has no `position`"),
        (point.to_owned(), "has no `power` or `intensity`"),
        (format!("{point}power = 1\nintensity = 1"), "`intensity` in [[light]] type = \"point\" stands beside `power`"),
        (format!("{point}power = -1"), "must not be negative"),
        (format!("{point}power = nan"), "must be a finite number"),
        (format!("{point}power_lm = [1, 2, 3]"), "`color` gives its colour"),
        (format!("{point}power = [1, 2, 3]\ncolor = [1, 1, 1]"), "has a colour of its own"),
        (format!("{point}power = 1\ncolor = [0, 0, 0]"), "must not be negative or black"),
        (format!("{point}power = 1\ncolor = [1, 1, 1]\ntemperature_k = 3000"), "stands beside `color`"),
        (format!("{point}power = 1\ntemperature_k = 3"), "500 to 100000 K"),
        (format!("{point}power = 1\ncone_deg = 3"), "unknown key `cone_deg`"),
        (spot.to_owned(), "has no `cone_deg`"),
        (format!("{spot}cone_deg = 181"), "not above 180 degrees"),
        (format!("{spot}cone_deg = 0"), "above 0"),
        (format!("{spot}cone_deg = 20\ninner_cone_deg = 20"), "below `cone_deg`"),
        (format!("{spot}falloff = \"hard\"\ncone_deg = 20\ninner_cone_deg = 2"), "no key of falloff = \"hard\""),
        (format!("{spot}falloff = \"cosine\"\nexponent = -1"), "from 0 to 10000"),
        (format!("{spot}falloff = \"soft\""), "\"hard\", \"cosine\" or \"smooth\""),
        (format!("{spot}cone_deg = 20\ntarget = [0, 0, 0]"), "stands beside `direction`"),
        (spot.replace("direction = [0, -1, 0]", "target = [0, 1, 0]\ncone_deg = 9"), "is where the light stands"),
        (
            spot.replace("[0, -1, 0]", "[0, 0, 0]\ncone_deg = 9"),
            "`direction` in [[light]] type = \"spot\" must not be zero",
        ),
        (format!("{sun}power = 1"), "unknown key `power`"),
        (sun.to_owned(), "has no `irradiance`"),
        (format!("{sun}irradiance = 1\nangular_diameter_deg = 200"), "from 0 to 180 degrees"),
    ] {
        let said = read(&format!("[[light]]\n{text}")).unwrap_err();
        assert!(said.contains(wanted) && said.lines().count() == 1, "{text}\nsaid: {said}\nwanted: {wanted}");
    }
    for (text, wanted) in [
        ("[light]\ntype = \"point\"", "write [[light]] in two brackets"),
        ("[sky]\nradiance = 1\nunit = \"nt\"", "write `radiance_nt` instead"),
        ("[sky]\nradiance = 1\nradiance_nt = 1", "stands beside `radiance`"),
        ("[sky]\nradiance = 0\nilluminance_lx = 5", "whose upper half is black"),
        ("[sky]\nradiance = 1\nscale = 2\nilluminance_lx = 5", "nor stand beside `scale`"),
        ("[[material]]\nname = \"m\"\nemission = 1\nemission_nt = 1", "stands beside `emission`"),
        (
            "[[texture]]\nname = \"t\"\ntype = \"checker\"\n[[material]]\nname = \"m\"\nemission = { texture = \"t\" }\n\
             [[shape]]\ntype = \"sphere\"\nmaterial = \"m\"\npower = 3",
            "comes from a texture",
        ),
        ("[[shape]]\ntype = \"sphere\"\npower = 3\npower_lm = 2", "stands beside `power`"),
    ] {
        let said = read(text).unwrap_err();
        assert!(said.contains(wanted), "{text}\nsaid: {said}\nwanted: {wanted}");
    }
}
