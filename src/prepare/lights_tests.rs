use glam::DVec3;

use super::*;
use crate::light::{self, alias};
use crate::scene::{Image, Pixels, Sky, SkyRadiance};

fn triangle(size: f32, radiance: f64, two_sided: bool) -> Emitter {
    let v = [[0.0; 3], [size, 0.0, 0.0], [0.0, size, 0.0]];
    light::triangle::emitter(v, 7, 3, DVec3::splat(radiance), two_sided)
}

fn sky_image(width: u32, height: u32, pixels: Vec<f32>) -> Image {
    Image { name: "sky".into(), width, height, pixels: Pixels::RgbF32(pixels.into()) }
}

const IMAGE_SKY: Sky = Sky { radiance: SkyRadiance::Image(0), rotation_rad: 0.0, scale: 1.0 };

#[test]
fn lights_are_chosen_by_power() {
    let sphere = light::sphere::emitter([0.0; 3], 0.5, 0, 1, DVec3::ONE, false);
    let sky = Sky { radiance: SkyRadiance::Uniform(DVec3::splat(0.5)), rotation_rad: 0.0, scale: 2.0 };
    let input = LightInput {
        emitters: &[triangle(1.0, 1.0, false), triangle(1.0, 1.0, true), sphere],
        sky: Some((&sky, &[])),
        sky_group: 5,
        scene_radius: 2.0,
        compensate: true,
    };
    let t = build(&input).unwrap();
    // The sky's own power, pi 2^2 4 pi, is more than all others together: it counts as much as they do.
    let others = 0.5 * PI + PI + PI * PI;
    let powers = [0.5 * PI, PI, PI * PI, others];
    let sum: f64 = powers.iter().sum();
    assert_eq!(t.lights.len(), 4);
    for (light, power) in t.lights.iter().zip(powers) {
        assert!((f64::from(light.pmf) / (power / sum) - 1.0).abs() < 1e-6);
    }
    assert_eq!((t.rows, t.sky.light), (vec![0, 1, 2], 3));
    assert_eq!((t.sky.scale, t.sky.width, t.lights[3].shape), ([1.0; 3], 0, 5));
    assert!(alias::choose_record(&t.light_alias, 4, u32::MAX, 0) == 3);
}

#[test]
fn what_emits_nothing_has_no_row_and_what_emits_keeps_one() {
    let nan = triangle(f32::NAN, 1.0, false);
    let emitters = [
        triangle(1.0, 0.0, false),
        triangle(0.0, 1.0, false),
        nan,
        triangle(1.0, f64::NAN, false),
        triangle(1.0, -1.0, false),
        triangle(1.0, 1e-320, false),
        triangle(1.0, 1.0, false),
    ];
    let t = build(&LightInput { emitters: &emitters, ..LightInput::default() }).unwrap();
    assert_eq!(t.rows, [NONE, NONE, NONE, NONE, NONE, 0, 1]);
    assert!(t.lights[0].pmf > 0.0 && t.lights[0].face_and_material() == (7, 3));
    assert_eq!(t.sky.light, NONE);
    let none = build(&LightInput::default()).unwrap();
    assert!(none.lights.is_empty() && none.light_alias.is_empty());
}

impl LightRecord {
    fn face_and_material(&self) -> (u32, u32) {
        (self.shape, self.material)
    }
}

#[test]
fn a_black_sky_is_no_light() {
    let images = [sky_image(4, 2, vec![0.0; 24])];
    for sky in [IMAGE_SKY, Sky { radiance: SkyRadiance::Uniform(DVec3::ZERO), ..IMAGE_SKY }] {
        let t = build(&LightInput {
            sky: Some((&sky, &images)),
            scene_radius: 1.0,
            compensate: true,
            ..LightInput::default()
        })
        .unwrap();
        assert!(t.lights.is_empty() && t.sky.light == NONE && t.sky.width == 0 && t.sky.scale == [0.0; 3]);
    }
    let lit = [sky_image(4, 2, vec![1.0; 24])];
    let off = Sky { scale: f64::NAN, ..IMAGE_SKY };
    assert!(build(&LightInput { sky: Some((&off, &lit)), ..LightInput::default() }).unwrap().lights.is_empty());
}

#[test]
fn texels_that_are_no_radiance_count_as_black_and_are_noted() {
    let mut pixels = vec![1.0; 24];
    (pixels[0], pixels[4], pixels[8], pixels[20]) = (f32::NAN, -1.0, f32::INFINITY, 65504.0);
    let t =
        build(&LightInput { sky: Some((&IMAGE_SKY, &[sky_image(4, 2, pixels)])), ..LightInput::default() }).unwrap();
    assert_eq!(t.notes.len(), 2, "{:?}", t.notes);
    assert!(t.notes[0].contains("3 texels") && t.notes[1].contains("1 texels at 65504"));
    assert!(t.sky_texels.iter().all(|x| x.radiance.iter().all(|c| c.is_finite() && *c >= 0.0) && x.cell_pdf > 0.0));
    assert_eq!(t.lights[0].pmf, 1.0);
}

#[test]
fn images_that_lie_about_their_size_are_errors() {
    for image in [sky_image(4, 2, vec![0.0; 23]), sky_image(0, 0, vec![]), sky_image(4, 3, vec![1.0; 24])] {
        assert!(build(&LightInput { sky: Some((&IMAGE_SKY, &[image])), ..LightInput::default() }).is_err());
    }
    assert!(build(&LightInput { sky: Some((&IMAGE_SKY, &[])), ..LightInput::default() }).is_err());
}
