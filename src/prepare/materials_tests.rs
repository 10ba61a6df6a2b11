use std::sync::Arc;

use glam::{DAffine2, DVec3};

use crate::gpu::{Choice, Device, Options};
use crate::integrator::Settings;
use crate::prepare::features::Features;
use crate::prepare::prepare;
use crate::reference::independent::Independent;
use crate::reference::known::{lamp, material};
use crate::reference::render;
use crate::reference::replay::Replay;
use crate::reference::scenes;
use crate::report::inspect;
use crate::scene::*;

/// Materials of every kind before those that shapes have, whose numbers move: a metal, glass that absorbs, a lamp, a picture.
fn with_unused(scene: &Scene) -> Scene {
    let mut s = scene.clone();
    let image = s.images.len();
    s.images.push(Image { name: "grid".into(), width: 1, height: 1, pixels: Pixels::Rgba8(vec![9; 4].into()) });
    let (wrap, filter, encoding) = ([Wrap::Mirror; 2], Filter::Nearest, Encoding::Srgb);
    s.textures.push(Texture::Image { image, wrap, filter, minify: Minify::default(), encoding });
    let look_up = || Value::Texture { texture: s.textures.len() - 1, uv_set: 0, uv_transform: DAffine2::IDENTITY };
    let mut brushed = material("conductor", &[("roughness", look_up()), ("roughness_y", Value::scalar(0.1))]);
    brushed.normal_map = Some((look_up(), 1.0));
    let mut glass = material("dielectric", &[("roughness", Value::scalar(0.3))]);
    (glass.interior, glass.priority) = (Some(Medium { absorption: DVec3::ONE }), 7);
    let mut sign = lamp(DVec3::ONE);
    (sign.alpha, sign.group) = (Alpha::Mask { value: look_up(), cutoff: 0.5 }, Some("unused".to_owned()));
    let mut mixture = material("lambert", &[]);
    let part = |bsdf| Part { bsdf, inputs: mixture.inputs.clone(), share: Value::scalar(0.5) };
    mixture.parts = vec![part(mixture.bsdf), part(mixture.bsdf)];
    let unused = vec![brushed, glass, sign, mixture];
    s.instances.iter_mut().for_each(|i| i.material += unused.len());
    s.materials.splice(0..0, unused);
    s
}

#[test]
fn a_material_that_no_shape_has_is_not_in_the_kernel() {
    let device = Device::open(&Choice::Auto, &Options::default()).unwrap();
    let settings = Settings::default();
    for scene in [scenes::cornell(6), scenes::alpha_sheets(6), scenes::nested(6)] {
        let [a, b] = [scene.clone(), with_unused(&scene)].map(|s| prepare(&s, &settings).unwrap());
        assert_eq!(Features::of(&a, &settings), Features::of(&b, &settings), "{}", scene.name);
        let text = |p| inspect::glsl(&device, p, &settings).unwrap();
        assert_eq!(text(&a), text(&b), "{}", scene.name);
        assert_eq!((&a.texels, &a.media, &a.material_data), (&b.texels, &b.media, &b.material_data));
        // Their rows are all that is left, so that numbers stay the scene's.
        assert_eq!(b.materials.len(), a.materials.len() + 4);
        assert_eq!(a.group_count, b.group_count);
    }
}

#[test]
fn unused_materials_change_no_picture() {
    let settings = Settings::default();
    for scene in [scenes::textured(8), scenes::nested(8), scenes::lights::lamps(8)] {
        let more = with_unused(&scene);
        let [a, b] = [&scene, &more].map(|s| {
            let prepared = Arc::new(prepare(s, &settings).unwrap());
            let replay = render::film(Replay::new(prepared, &settings), settings, 1).mean_f32();
            (replay, render::film(Independent::new(s), settings, 1).mean_f32())
        });
        assert!(a == b, "{}", scene.name);
    }
}
