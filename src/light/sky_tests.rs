use super::*;
use crate::light::independent::SceneSky;
use crate::light::integrals::sphere_quadrature;
use crate::metric::stats::chi_square_test;
use crate::prepare::lights::{LightInput, LightTables, build};
use crate::scene::{Image, Pixels, Sky, SkyRadiance};

fn hash(i: u32) -> u32 {
    let x = (i ^ (i >> 16)).wrapping_mul(0x7feb_352d);
    let x = (x ^ (x >> 15)).wrapping_mul(0x846c_a68b);
    x ^ (x >> 16)
}

fn unit(i: u32) -> f64 {
    f64::from(hash(i) >> 8) / 16777216.0
}

/// Skies by name: (image, sky).
fn skies() -> Vec<(&'static str, Image, Sky)> {
    let image = |width: u32, height: u32, f: &dyn Fn(u32, u32) -> f32| {
        let texel = |k: u32| [1.0, 0.5, 0.25].map(|c| c * f(k % width, k / width));
        let pixels: Vec<f32> = (0..width * height).flat_map(texel).collect();
        Image { name: "test".into(), width, height, pixels: Pixels::RgbF32(pixels.into()) }
    };
    let sky = |rotation_rad: f64| Sky { radiance: SkyRadiance::Image(0), rotation_rad, scale: 2.0 };
    let noise = |i: u32, j: u32| hash(i * 977 + j) as f32 / 4e9;
    let sun = |i: u32, j: u32| if (i, j) == (20, 3) { 1e5 } else { 1.0 };
    vec![
        ("noise", image(16, 8, &noise), sky(0.0)),
        ("turned", image(13, 7, &noise), sky(1.234)),
        ("sun", image(32, 16, &sun), sky(-2.0)),
        ("pole", image(8, 8, &|_, j| if j == 0 { 1.0 } else { 0.0 }), sky(0.5)),
        ("one hot", image(16, 9, &|i, j| if (i, j) == (0, 8) { 1.0 } else { 0.0 }), sky(3.0)),
        ("one texel", image(1, 1, &|_, _| 1.0), sky(0.0)),
        ("column", image(1, 4, &|_, j| j as f32), sky(0.0)),
        ("row", image(6, 1, &|i, _| i as f32), sky(7.0)),
    ]
}

fn tables(image: &Image, sky: &Sky, compensate: bool) -> LightTables {
    let images = std::slice::from_ref(image);
    build(&LightInput { sky: Some((sky, images)), scene_radius: 1.0, compensate, ..LightInput::default() }).unwrap()
}

fn view(t: &LightTables) -> SkyView<'_> {
    SkyView { sky: &t.sky, texels: &t.sky_texels, alias: &t.sky_alias }
}

fn directions(count: u32) -> impl Iterator<Item = DVec3> {
    let axes = [DVec3::X, DVec3::Y, DVec3::Z, DVec3::NEG_X, DVec3::NEG_Y, DVec3::NEG_Z];
    axes.into_iter().chain((0..count).map(|i| {
        let (z, phi) = (2.0 * unit(2 * i) - 1.0, TAU * unit(2 * i + 1));
        let r = (1.0 - z * z).sqrt();
        DVec3::new(r * phi.cos(), z, r * phi.sin())
    }))
}

#[test]
fn the_lookup_is_the_independent_one() {
    for (name, image, sky) in skies() {
        let t = tables(&image, &sky, false);
        let own = SceneSky::new(&sky, std::slice::from_ref(&image)).unwrap();
        // At a pole itself a bilinear lat-long lookup has no single value.
        for d in directions(20_000).filter(|d| d.y.abs() < 1.0) {
            let (a, b) = (view(&t).radiance(d), own.radiance(d));
            // The record's rotation is f32: 1e-7 rad times the largest slope, one texel's value over its width.
            let bound = 1e-6 * (b.length() + if name == "sun" { 1e5 } else { 1.0 }) * f64::from(image.width);
            assert!((a - b).length() < bound, "{name} {d}: {a} {b}");
        }
    }
}

#[test]
fn the_convention_is_that_of_the_page() {
    // Centre -z, right half +x, top +y.
    let pixels: Vec<f32> = (0..64 * 32).flat_map(|k| [(k % 64) as f32, (k / 64) as f32, 0.0]).collect();
    let image = Image { name: "ramp".into(), width: 64, height: 32, pixels: Pixels::RgbF32(pixels.into()) };
    let mut sky = Sky { radiance: SkyRadiance::Image(0), rotation_rad: 0.0, scale: 1.0 };
    let at = |sky: &Sky, d: DVec3| view(&tables(&image, sky, false)).radiance(d);
    assert!((at(&sky, DVec3::NEG_Z) - DVec3::new(31.5, 15.5, 0.0)).length() < 1e-9);
    assert!((at(&sky, DVec3::X) - DVec3::new(47.5, 15.5, 0.0)).length() < 1e-9);
    assert!((at(&sky, DVec3::NEG_X) - DVec3::new(15.5, 15.5, 0.0)).length() < 1e-9);
    assert!(at(&sky, DVec3::Y).y == 0.0 && at(&sky, DVec3::NEG_Y).y == 31.0);
    // Turned by +90 degrees about +y, what was at -z is at -x.
    sky.rotation_rad = FRAC_PI_2;
    assert!((at(&sky, DVec3::NEG_X) - DVec3::new(31.5, 15.5, 0.0)).length() < 1e-4);
}

#[test]
fn the_density_integrates_to_one_and_covers_the_light() {
    for (name, image, sky) in skies() {
        for compensate in [false, true] {
            let t = tables(&image, &sky, compensate);
            let rows = 24 * image.height.max(image.width / 2).max(4) as usize;
            let total = sphere_quadrature(rows, |d| DVec3::splat(view(&t).pdf(d))).x;
            // Midpoints on the turned, stepped density; a sun's cell is cut at its edges.
            let bound = if name == "sun" { 3e-2 } else { 1e-2 };
            assert!((total - 1.0).abs() < bound, "{name} {compensate}: {total}");
            let exact: f64 =
                t.sky_texels.iter().enumerate().map(|(k, x)| f64::from(x.cell_pdf) * cell_area(&t, k)).sum();
            assert!((exact - 1.0).abs() < 1e-5, "{name} {compensate}: {exact}");
            let is_covered = |d: DVec3| view(&t).radiance(d) == DVec3::ZERO || view(&t).pdf(d) > 0.0;
            assert!(compensate || directions(20_000).all(is_covered), "{name}");
        }
    }
}

fn cell_area(t: &LightTables, cell: usize) -> f64 {
    let (w, h) = (t.sky.width as usize, t.sky.height as usize);
    crate::light::sky_table::cell_solid_angle(cell / w, w, h)
}

#[test]
fn samples_follow_the_density() {
    for (name, image, sky) in skies() {
        for compensate in [false, true] {
            let t = tables(&image, &sky, compensate);
            let v = view(&t);
            let count = 60_000u32;
            // Four parts a cell, equal in solid angle: half of u, half of cos(theta).
            let cells = (t.sky.width * t.sky.height) as usize;
            let mut observed = vec![0.0; 4 * cells];
            for i in 0..count {
                let [a, b, c, d] = [0, 1, 2, 3].map(|k| hash(4 * i + k));
                let s = v.sample(a, b, [c, d].map(|x| f64::from(x >> 8) / 16777216.0));
                assert!((s.wi.length() - 1.0).abs() < 1e-6 && s.pdf > 0.0, "{name}");
                assert_eq!(s.radiance, v.radiance(s.wi));
                let (x, y) = v.position(s.wi);
                let (column, row) =
                    ((x as usize).min(t.sky.width as usize - 1), (y as usize).min(t.sky.height as usize - 1));
                let edge = |j: usize| (PI * j as f64 / f64::from(t.sky.height)).cos();
                let is_late = (PI * y / f64::from(t.sky.height)).cos() < 0.5 * (edge(row) + edge(row + 1));
                let cell = row * t.sky.width as usize + column;
                observed[4 * cell + 2 * usize::from(is_late) + usize::from(x.fract() >= 0.5)] += 1.0;
                // At a cell's very edge the two may see different cells.
                let is_inside = (x - x.round()).abs() > 1e-6 && (y - y.round()).abs() > 1e-6;
                assert!(!is_inside || v.pdf(s.wi) == s.pdf, "{name} {} {}", v.pdf(s.wi), s.pdf);
            }
            let share =
                |k: usize| f64::from(count) * f64::from(t.sky_texels[k / 4].cell_pdf) * 0.25 * cell_area(&t, k / 4);
            let expected: Vec<f64> = (0..4 * cells).map(share).collect();
            let test = chi_square_test(&observed, &expected, 5.0);
            // 16 tests at 1e-3 together.
            assert!(test.p > 6e-5, "{name} {compensate}: {test:?}");
        }
    }
}

#[test]
fn light_sampled_both_ways_is_the_integral() {
    for (name, image, sky) in skies() {
        let t = tables(&image, &sky, false);
        let own = SceneSky::new(&sky, std::slice::from_ref(&image)).unwrap();
        let n = DVec3::new(0.36, 0.48, 0.8);
        let exact = crate::light::integrals::sky_irradiance(n, 600, |d| own.radiance(d));
        let count = 200_000;
        let mut sums = [DVec3::ZERO; 2];
        let mut squares = [0.0; 2];
        for i in 0..count {
            let [a, b, c, d] = [0, 1, 2, 3].map(|k| hash(4 * i + k));
            let u = [c, d].map(|x| f64::from(x) / 4294967296.0);
            let s = view(&t).sample(a, b, u);
            let (wi, pdf) = own.sample(u);
            let first = s.radiance * s.wi.dot(n).max(0.0) / s.pdf;
            let second = if pdf > 0.0 { own.radiance(wi) * wi.dot(n).max(0.0) / pdf } else { DVec3::ZERO };
            for (k, x) in [first, second].into_iter().enumerate() {
                sums[k] += x / f64::from(count);
                squares[k] += x.x * x.x / f64::from(count);
            }
        }
        for k in 0..2 {
            let deviation = ((squares[k] - sums[k].x * sums[k].x) / f64::from(count)).max(0.0).sqrt();
            let bound = 4.0 * deviation + 2e-4 * exact.x;
            assert!((sums[k].x - exact.x).abs() <= bound, "{name} {k}: {} {} +- {deviation}", sums[k].x, exact.x);
        }
    }
}

#[test]
fn compensation_takes_the_mean_off() {
    let (_, image, sky) = skies().swap_remove(2);
    let (plain, compensated) = (tables(&image, &sky, false), tables(&image, &sky, true));
    let far = DVec3::NEG_Y;
    assert!(view(&plain).pdf(far) > 0.0 && view(&compensated).pdf(far) == 0.0);
    let (_, uniform, sky) = skies().swap_remove(5);
    assert_eq!(tables(&uniform, &sky, true).sky_texels, tables(&uniform, &sky, false).sky_texels);
}

#[test]
fn a_uniform_sky_is_sampled_over_the_sphere() {
    let sky = Sky { radiance: SkyRadiance::Uniform(DVec3::new(1.0, 2.0, 3.0)), rotation_rad: 0.0, scale: 1.0 };
    let t = build(&LightInput { sky: Some((&sky, &[])), scene_radius: 1.0, ..LightInput::default() }).unwrap();
    let s = view(&t).sample(0, 0, [0.3, 0.7]);
    assert_eq!(s.radiance, DVec3::new(1.0, 2.0, 3.0));
    assert!((s.wi.length() - 1.0).abs() < 1e-12 && (s.pdf * 4.0 * PI - 1.0).abs() < 1e-12);
    assert_eq!(view(&t).pdf(DVec3::X), s.pdf);
}
