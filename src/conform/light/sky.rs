//! The sky: lookup, density and sampling against `SkyView` on the same records. A direction's place in the image is off by a few eps
//! of the image's size, so the radiance is held to the difference of the texels around it, the stepped density to the cells there.

use std::sync::{Arc, LazyLock};

use glam::DVec3;

use super::super::inputs::Inputs;
use super::super::probe::{EPS, Probe};
use super::{direction, ratio, vector};
use crate::light::sky::SkyView;
use crate::prepare::lights::{LightInput, LightTables, build};
use crate::prepare::records::{SkyRecord, SkyTexelRecord};
use crate::sampler::hash::pcg;
use crate::scene::{Image, Pixels, Sky, SkyRadiance};
use crate::shader::record::GpuRecord;

/// Noise with a sun of 1e5 : 1, turned, of an odd size; and a wide one, where a texel is 8e-4 rad.
static SKIES: LazyLock<[(&str, LightTables); 3]> =
    LazyLock::new(|| [("", tables(37, 19, 1.234)), (" 8k", tables(8192, 24, -0.4)), (" uniform", uniform())]);

fn tables(width: u32, height: u32, rotation_rad: f64) -> LightTables {
    let texel = |k: u32| {
        let noise = |c: u32| (pcg(3 * k + c) >> 8) as f32 / 16_777_216.0;
        let sun = if k == (height / 3) * width + width / 2 { 1e5 } else { 1.0 };
        [0, 1, 2].map(|c| sun * noise(c))
    };
    let pixels: Vec<f32> = (0..width * height).flat_map(texel).collect();
    let image = Image { name: "sky".into(), width, height, pixels: Pixels::RgbF32(Arc::new(pixels)) };
    lit(&Sky { radiance: SkyRadiance::Image(0), rotation_rad, scale: 1.5 }, &[image])
}

fn uniform() -> LightTables {
    lit(&Sky { radiance: SkyRadiance::Uniform(DVec3::new(1.0, 2.0, 3.0)), rotation_rad: 0.0, scale: 1.0 }, &[])
}

fn lit(sky: &Sky, images: &[Image]) -> LightTables {
    let input = LightInput { sky: Some((sky, images)), scene_radius: 1.0, ..LightInput::default() };
    build(&input).expect("the images above are as large as they say")
}

fn view(kind: usize) -> SkyView<'static> {
    let t = &SKIES[kind].1;
    SkyView { sky: &t.sky, texels: &t.sky_texels, alias: &t.sky_alias }
}

/// How far, in texels, rounding may move a place: eps of the angle in turns, times the size.
fn slack(sky: &SkyRecord) -> (f64, f64) {
    (12.0 * EPS * f64::from(sky.width.max(1)), 12.0 * EPS * f64::from(sky.height.max(1)))
}

/// Texels about a place, those of the bilinear corners and their neighbours.
fn around(v: &SkyView, d: DVec3) -> Vec<SkyTexelRecord> {
    let (x, y) = v.position(d);
    let (w, h) = (i64::from(v.sky.width), i64::from(v.sky.height));
    let (i, j) = ((x - 0.5).floor() as i64, (y - 0.5).floor() as i64);
    let at = |k: i64, l: i64| v.texels[((j + l).clamp(0, h - 1) * w + (i + k).rem_euclid(w)) as usize];
    (-1..3).flat_map(|l| (-1..3).map(move |k| (k, l))).map(|(k, l)| at(k, l)).collect()
}

fn radiance_error(v: &SkyView, d: DVec3, got: DVec3) -> f64 {
    let expected = v.radiance(d);
    if v.sky.width == 0 {
        return ratio((got - expected).length(), 2.0 * EPS * expected.length());
    }
    let scale = f64::from(v.sky.scale[0]);
    let texels: Vec<DVec3> = around(v, d).iter().map(|t| scale * DVec3::from(t.radiance.map(f64::from))).collect();
    let steepest = texels.iter().map(|a| (*a - texels[5]).length()).fold(0.0, f64::max) * 2.0;
    let (dx, dy) = slack(v.sky);
    ratio((got - expected).length(), 8.0 * EPS * expected.length() + (dx + dy) * steepest)
}

fn judge_lookup(kind: usize, x: &[f32], y: &[f32]) -> f64 {
    if y.iter().any(|c| !c.is_finite() || *c < 0.0) {
        return f64::INFINITY;
    }
    let (v, d) = (view(kind), vector(x));
    let is_density = if v.sky.width == 0 {
        (f64::from(y[3]) - v.pdf(d)).abs() < 2.0 * EPS
    } else {
        // Any of the cells within the slack, compared bit for bit.
        let ((px, py), (dx, dy)) = (v.position(d), slack(v.sky));
        let (w, h) = (f64::from(v.sky.width), f64::from(v.sky.height));
        [(-dx, -dy), (dx, -dy), (-dx, dy), (dx, dy)].iter().any(|(a, b)| {
            let column = ((px + a).rem_euclid(w) as u32).min(v.sky.width - 1);
            let row = ((py + b).clamp(0.0, h) as u32).min(v.sky.height - 1);
            v.texels[(row * v.sky.width + column) as usize].cell_pdf == y[3]
        })
    };
    if is_density { radiance_error(&v, d, vector(y)) } else { f64::INFINITY }
}

fn judge_sample(kind: usize, x: &[f32], y: &[f32]) -> f64 {
    if y.iter().any(|c| !c.is_finite() || *c < 0.0 && c.is_nan()) || y[6] <= 0.0 {
        return f64::INFINITY;
    }
    let v = view(kind);
    let expected = v.sample(x[0].to_bits(), x[1].to_bits(), [x[2].into(), x[3].into()]);
    let wi = vector(y);
    if (f64::from(y[6]) - expected.pdf).abs() > 2.0 * EPS * expected.pdf {
        return f64::INFINITY;
    }
    // phi is 2 pi (column + u)/W: about 2 pi eps, and sin(theta) has a square root of s(1 - s).
    let turn = ratio((wi - expected.wi).length(), 16.0 * EPS);
    turn.max(radiance_error(&v, wi, vector(&y[3..])))
}

/// Directions everywhere, and those at the image's seams: texel edges, the wrap, the poles.
fn directions(kind: usize, r: &mut Inputs) -> [f32; 3] {
    let sky = &SKIES[kind].1.sky;
    if sky.width == 0 || !r.once_in(4) {
        // At a pole itself the longitude is that of a rounding error.
        let d = direction(r);
        return if d.y.abs() == 1.0 { [1e-6, d.y as f32, 1e-6] } else { d.to_array().map(|c| c as f32) };
    }
    let phi = std::f64::consts::TAU * f64::from(2 * r.below(sky.width) + r.below(2)) / f64::from(2 * sky.width);
    let theta = std::f64::consts::PI * f64::from(2 * r.below(sky.height) + 1) / f64::from(2 * sky.height);
    [theta.sin() * phi.sin(), theta.cos(), -theta.sin() * phi.cos()].map(|c| c as f32)
}

/// Tables, records and files of a sky on a probe.
pub(super) fn with_sky(probe: Probe, kind: usize) -> Probe {
    let t = &SKIES[kind].1;
    let prelude = [
        SkyRecord::glsl_struct(),
        SkyRecord::glsl_loader("sky"),
        SkyTexelRecord::glsl_struct(),
        SkyTexelRecord::glsl_loader("sky_texels"),
    ];
    probe
        .define("SKY_IMAGE", u32::from(t.sky.width > 0))
        .define("HAS_LIGHT_SKY", 1)
        .prelude(&prelude.concat())
        .table("sky", bytemuck::cast_slice(&[t.sky]).to_vec())
        .table("sky_texels", bytemuck::cast_slice(&t.sky_texels).to_vec())
        .table("sky_alias", bytemuck::cast_slice(&t.sky_alias).to_vec())
        .files(&["light/alias.glsl", "light/sky.glsl"])
}

pub fn probes() -> Vec<Probe> {
    let mut probes = Vec::new();
    for (kind, name) in SKIES.iter().map(|s| s.0).enumerate() {
        let lookup =
            "vec3 d = vec3(x0, x1, x2); vec3 l = sky_radiance(d); y0 = l.x; y1 = l.y; y2 = l.z; y3 = sky_pdf(d);";
        let lookup = Probe::judged(
            &format!("sky_radiance and sky_pdf{name}"),
            lookup,
            4,
            move |r| directions(kind, r),
            move |x, y| judge_lookup(kind, x, y),
        )
        .because(
            "8 eps |L| + 12 eps (W + H) texels x difference of texels; density of a cell within that slack, to the bit",
        )
        .covers(&["sky_from_world", "sky_position", "sky_texel"]);
        probes.push(with_sky(lookup, kind));
        let sample = "SkySample s = sky_sample(n0, n1, vec2(x2, x3)); y0 = s.wi.x; y1 = s.wi.y; y2 = s.wi.z; \
            y3 = s.radiance.x; y4 = s.radiance.y; y5 = s.radiance.z; y6 = s.pdf;";
        let sample = Probe::judged(
            &format!("sky_sample{name}"),
            sample,
            7,
            |r| [f32::from_bits(r.word_or_edge()), f32::from_bits(r.word_or_edge()), r.unit(), r.unit()],
            move |x, y| judge_sample(kind, x, y),
        )
        .because("direction 16 eps, density to 2 eps, radiance as sky_radiance at the direction")
        .covers(&["sky_to_world", "sky_direction_in_cell", "alias_choose_sky"]);
        probes.push(with_sky(sample, kind));
    }
    probes
}

/// Cells and densities for the chi-square row: (width, height, cell_pdf, position of a direction).
pub(super) fn image() -> SkyView<'static> {
    view(0)
}
