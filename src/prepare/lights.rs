//! The light tables: every emissive triangle and sphere and the sky, chosen in proportion to power, and the cells of the sky.
//!
//! Power: pi A L for a triangle, 4 pi^2 r^2 L for a sphere, twice that where both sides emit; pi R^2 times the integral of L for
//! a sky, R the radius of the scene's bounding sphere, but not more than all others together. L is the mean luminance of the
//! radiance. What emits nothing gets no row; what emits keeps a positive probability, however small its power.
//! Tests: lights_tests.rs.

use std::f64::consts::PI;

use glam::DVec3;

use crate::light::{alias::AliasTable, sky_table};
use crate::prepare::records::*;
use crate::scene;

/// A triangle that emits. Vertices as in its `TriangleRecord` (rebased, front counter-clockwise).
#[derive(Clone, Copy, Debug)]
pub struct EmissiveTriangle {
    pub v0: [f32; 3],
    pub v1: [f32; 3],
    pub v2: [f32; 3],
    pub material: u32,
    /// `TriangleRecord::face`.
    pub face: u32,
    /// Mean over the triangle, or over the texture; any channel > 0 where the emission is > 0 anywhere.
    pub mean_radiance: DVec3,
    pub two_sided: bool,
}

/// A sphere that emits, as in its `SphereRecord`.
#[derive(Clone, Copy, Debug)]
pub struct EmissiveSphere {
    pub center: [f32; 3],
    pub radius: f32,
    pub material: u32,
    /// Row of `Prepared::spheres`, which is leaf order.
    pub sphere: u32,
    pub mean_radiance: DVec3,
    pub two_sided: bool,
}

#[derive(Clone, Copy, Debug, Default)]
pub struct LightInput<'a> {
    pub triangles: &'a [EmissiveTriangle],
    pub spheres: &'a [EmissiveSphere],
    /// The sky and `Scene::images`.
    pub sky: Option<(&'a scene::Sky, &'a [scene::Image])>,
    /// Radius of the bounding sphere of the scene, metres; 1 is taken where it is 0 or not finite.
    pub scene_radius: f64,
    /// MIS compensation of the sky's table: with the estimator `mis` only, for light sampling alone would be biased by it.
    pub compensate: bool,
}

#[derive(Clone, Debug, Default)]
pub struct LightTables {
    pub lights: Vec<LightRecord>,
    pub light_alias: Vec<AliasRecord>,
    /// Black, without texels and without a light when the scene has no sky or a black one.
    pub sky: SkyRecord,
    pub sky_texels: Vec<SkyTexelRecord>,
    pub sky_alias: Vec<AliasRecord>,
    /// Row of `lights`, or NONE, of each `LightInput::triangles`.
    pub triangle_light: Vec<u32>,
    /// The same of each `LightInput::spheres`.
    pub sphere_light: Vec<u32>,
    /// What was repaired, one sentence each.
    pub notes: Vec<String>,
}

#[derive(Debug, thiserror::Error)]
pub enum LightError {
    #[error("sky: image {index} does not exist, the scene has {count}")]
    NoImage { index: usize, count: usize },
    #[error(
        "sky: image \"{name}\" is {width}x{height} but holds {texels} texels; it must have at least one and at most 2^31"
    )]
    ImageSize { name: String, width: u32, height: u32, texels: usize },
}

impl From<LightError> for crate::error::Error {
    fn from(e: LightError) -> Self {
        Self::Scene(e.to_string())
    }
}

pub fn build(input: &LightInput) -> Result<LightTables, LightError> {
    let mut tables = LightTables { sky: black_sky(), ..LightTables::default() };
    let mut powers = Vec::new();
    for t in input.triangles {
        let light = add_light(&mut tables.lights, &mut powers, triangle_power(t), || triangle_record(t));
        tables.triangle_light.push(light);
    }
    for s in input.spheres {
        let light = add_light(&mut tables.lights, &mut powers, sphere_power(s), || sphere_record(s));
        tables.sphere_light.push(light);
    }
    if let Some((sky, images)) = input.sky {
        let integral = add_sky(&mut tables, sky, images, input.compensate)?;
        let radius = if input.scene_radius > 0.0 && input.scene_radius.is_finite() { input.scene_radius } else { 1.0 };
        // Kept positive where the product underflows, see `positive`.
        let power = positive(PI * radius * radius * integral, integral > 0.0);
        // Not more than all the others together: its power grows with the square of the scene, and over a wide floor a lamp
        // would be chosen once in a thousand although it lights what is near it as much as the sky does.
        let others: f64 = powers.iter().sum();
        let power = if others > 0.0 { power.min(others) } else { power };
        let record = LightRecord { kind: LIGHT_SKY, material: NONE, shape: NONE, ..LightRecord::default() };
        tables.sky.light = add_light(&mut tables.lights, &mut powers, power, || record);
    }
    if let Some(table) = AliasTable::new(&powers) {
        for (light, &pmf) in tables.lights.iter_mut().zip(&table.pmf) {
            light.pmf = pmf as f32;
        }
        tables.light_alias = table.records();
    }
    Ok(tables)
}

/// Row of the new light, or NONE when it has no power.
fn add_light(
    lights: &mut Vec<LightRecord>,
    powers: &mut Vec<f64>,
    power: f64,
    record: impl Fn() -> LightRecord,
) -> u32 {
    if power.is_nan() || power <= 0.0 {
        return NONE;
    }
    lights.push(record());
    powers.push(power);
    lights.len() as u32 - 1
}

/// A light that emits must not lose its probability to underflow.
fn positive(power: f64, emits: bool) -> f64 {
    if emits && power == 0.0 { f64::MIN_POSITIVE } else { power }
}

fn mean_luminance(radiance: DVec3) -> f64 {
    // NaN and negative channels emit nothing.
    sky_table::luminance(radiance.to_array().map(|x| if x > 0.0 { x } else { 0.0 }))
}

fn triangle_power(t: &EmissiveTriangle) -> f64 {
    let [v0, v1, v2] = [t.v0, t.v1, t.v2].map(|v| DVec3::from(v.map(f64::from)));
    let area = 0.5 * (v1 - v0).cross(v2 - v0).length();
    let luminance = mean_luminance(t.mean_radiance);
    // A triangle without area, or with a vertex that is no number, cannot be hit.
    let emits = area > 0.0 && area.is_finite() && luminance > 0.0;
    let sides = if t.two_sided { 2.0 } else { 1.0 };
    if emits { positive(sides * PI * area * luminance, true) } else { 0.0 }
}

fn sphere_power(s: &EmissiveSphere) -> f64 {
    let r = f64::from(s.radius);
    let luminance = mean_luminance(s.mean_radiance);
    let emits = r > 0.0 && r.is_finite() && s.center.iter().all(|x| x.is_finite()) && luminance > 0.0;
    let sides = if s.two_sided { 2.0 } else { 1.0 };
    if emits { positive(sides * 4.0 * PI * PI * r * r * luminance, true) } else { 0.0 }
}

fn triangle_record(t: &EmissiveTriangle) -> LightRecord {
    LightRecord {
        a: t.v0,
        kind: LIGHT_TRIANGLE,
        b: t.v1,
        material: t.material,
        c: t.v2,
        shape: t.face,
        pmf: 0.0,
        reserved: [0; 3],
    }
}

fn sphere_record(s: &EmissiveSphere) -> LightRecord {
    LightRecord {
        a: s.center,
        kind: LIGHT_SPHERE,
        b: [s.radius, 0.0, 0.0],
        material: s.material,
        c: [0.0; 3],
        shape: s.sphere,
        pmf: 0.0,
        reserved: [0; 3],
    }
}

fn black_sky() -> SkyRecord {
    SkyRecord { rotation: [1.0, 0.0], light: NONE, ..SkyRecord::default() }
}

/// Fills the sky's record, texels and cells; returns the integral of its luminance over the sphere, W/m2.
fn add_sky(
    tables: &mut LightTables,
    sky: &scene::Sky,
    images: &[scene::Image],
    compensate: bool,
) -> Result<f64, LightError> {
    let scale = if sky.scale > 0.0 && sky.scale.is_finite() { sky.scale } else { 0.0 };
    let angle = if sky.rotation_rad.is_finite() { sky.rotation_rad } else { 0.0 };
    tables.sky.rotation = [angle.cos() as f32, angle.sin() as f32];
    match sky.radiance {
        scene::SkyRadiance::Uniform(radiance) => {
            let radiance = radiance.to_array().map(|x| if x > 0.0 && x.is_finite() { x * scale } else { 0.0 });
            tables.sky.scale = radiance.map(|x| x as f32);
            Ok(4.0 * PI * sky_table::luminance(radiance))
        }
        scene::SkyRadiance::Image(index) => {
            let image = images.get(index).ok_or(LightError::NoImage { index, count: images.len() })?;
            let mut texels = sky_texels(image, &mut tables.notes)?;
            let (width, height) = (image.width as usize, image.height as usize);
            let luminance = |i: usize, j: usize| sky_table::luminance(texels[j * width + i].radiance.map(f64::from));
            let Some(cells) = sky_table::build(width, height, luminance, compensate) else { return Ok(0.0) };
            if scale == 0.0 {
                return Ok(0.0);
            }
            for (texel, &pdf) in texels.iter_mut().zip(&cells.cell_pdf) {
                texel.cell_pdf = pdf as f32;
            }
            tables.sky_alias = cells.alias.records();
            tables.sky_texels = texels;
            tables.sky = SkyRecord { scale: [scale as f32; 3], width: image.width, height: image.height, ..tables.sky };
            Ok(scale * cells.luminance_integral)
        }
    }
}

/// Largest finite half float; a sky that holds it was probably cut off when it was written.
const HALF_MAX: f32 = 65504.0;

/// Linear texels, density still 0. Texels that are not finite or below 0 become black and are counted.
fn sky_texels(image: &scene::Image, notes: &mut Vec<String>) -> Result<Vec<SkyTexelRecord>, LightError> {
    let decoded: Vec<[f32; 3]> = match &image.pixels {
        scene::Pixels::RgbF32(data) => data.chunks_exact(3).map(|p| [p[0], p[1], p[2]]).collect(),
        scene::Pixels::Rgba8(data) => data.chunks_exact(4).map(|p| [p[0], p[1], p[2]].map(srgb_to_linear)).collect(),
    };
    let count = image.width as usize * image.height as usize;
    if count == 0 || count > 1 << 31 || decoded.len() != count {
        let (width, height, texels) = (image.width, image.height, decoded.len());
        return Err(LightError::ImageSize { name: image.name.clone(), width, height, texels });
    }
    let is_bad = |x: f32| !(x.is_finite() && x >= 0.0);
    let bad_count = decoded.iter().filter(|t| t.iter().any(|&x| is_bad(x))).count();
    let cut_count = decoded.iter().filter(|t| t.contains(&HALF_MAX)).count();
    if bad_count > 0 {
        notes.push(format!(
            "sky \"{}\": {bad_count} texels with a channel below 0 or not finite; that channel counts as 0",
            image.name
        ));
    }
    if cut_count > 0 {
        notes.push(format!(
            "sky \"{}\": {cut_count} texels at 65504, the largest half float; brighter light may have been cut off",
            image.name
        ));
    }
    let clean = |t: [f32; 3]| SkyTexelRecord { radiance: t.map(|x| if is_bad(x) { 0.0 } else { x }), cell_pdf: 0.0 };
    Ok(decoded.into_iter().map(clean).collect())
}

/// IEC 61966-2-1.
fn srgb_to_linear(byte: u8) -> f32 {
    let x = f64::from(byte) / 255.0;
    (if x <= 0.04045 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }) as f32
}

#[cfg(test)]
#[path = "lights_tests.rs"]
mod tests;
