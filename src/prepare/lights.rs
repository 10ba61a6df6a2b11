//! The light tables: every emitter and the sky, chosen in proportion to power, and the cells of the sky.
//!
//! Each kind says its own power (src/light); here the sky's: pi R^2 times the integral of L, R the radius of the scene's bounding
//! sphere. Lights infinitely far away count for not more than the others together. L is luminance. What emits nothing gets no row; what emits keeps a positive
//! probability, however small its power. Tests: lights_tests.rs.

use std::f64::consts::PI;

use glam::DVec3;

use crate::light::{Emitter, LIGHT_SKY, alias::AliasTable, kept_positive, sky_table};
use crate::prepare::records::*;
use crate::scene::{self, Scene, groups};

#[derive(Clone, Copy, Debug, Default)]
pub struct LightInput<'a> {
    pub emitters: &'a [Emitter],
    /// The sky and `Scene::images`.
    pub sky: Option<(&'a scene::Sky, &'a [scene::Image])>,
    pub sky_group: u32,
    /// Radius of the bounding sphere of the scene, metres, above 0.
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
    /// Row of `lights`, or NONE, of each `LightInput::emitters`.
    pub rows: Vec<u32>,
    /// What was repaired, one sentence each.
    pub notes: Vec<String>,
}

#[derive(Debug, thiserror::Error)]
pub enum LightError {
    #[error(
        "the light '{name}' is too bright, too far or not finite: as f32 it reads {record}; choose other units or move it"
    )]
    Range { name: String, record: String },
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
    let is_power = |p: f64| if p > 0.0 { p } else { 0.0 };
    // What is infinitely far away counts for not more than all the others together: its power grows with the square of the scene,
    // and over a wide floor a lamp would be chosen once in a thousand although it lights what is near it as much as the sky does.
    let near: f64 = input.emitters.iter().filter(|e| !e.is_distant).map(|e| is_power(e.power)).sum();
    let limited = |power: f64| if near > 0.0 { power.min(near) } else { power };
    for emitter in input.emitters {
        let power = if emitter.is_distant { limited(emitter.power) } else { emitter.power };
        let row = add_light(&mut tables.lights, &mut powers, &Emitter { power, ..*emitter });
        tables.rows.push(row);
    }
    if let Some((sky, images)) = input.sky {
        let integral = add_sky(&mut tables, sky, images, input.compensate)?;
        let radius = input.scene_radius;
        let power = limited(kept_positive(PI * radius * radius * integral, integral > 0.0));
        let record = LightRecord { kind: LIGHT_SKY, material: NONE, shape: input.sky_group, ..LightRecord::default() };
        tables.sky.light = add_light(&mut tables.lights, &mut powers, &Emitter { record, power, is_distant: true });
    }
    if let Some(table) = AliasTable::new(&powers) {
        for (light, &pmf) in tables.lights.iter_mut().zip(&table.pmf) {
            light.pmf = pmf as f32;
        }
        tables.light_alias = table.records();
    }
    Ok(tables)
}

/// The lights of the scene that no surface carries. One without power is noted; `build` gives it no row.
pub fn lamps(scene: &Scene, origin: DVec3, radius: f64, notes: &mut Vec<String>) -> Result<Vec<Emitter>, LightError> {
    let mut emitters = Vec::new();
    let groups = scene.light_groups();
    for light in &scene.lights {
        let mut emitter = light.lamp.emitter(origin, radius);
        emitter.record.shape = groups::number(&groups, light.group.as_deref());
        let LightRecord { a, b, c, falloff, .. } = emitter.record;
        if [a, b, c, falloff].iter().flatten().any(|x| !x.is_finite()) || !emitter.power.is_finite() {
            let record = format!("{a:?}, {b:?}, {c:?}, {falloff:?}");
            return Err(LightError::Range { name: light.name.clone(), record });
        }
        if c.iter().all(|x| *x <= 0.0) {
            notes.push(format!("the light '{}' has no power and was left out", light.name));
            emitter.power = 0.0;
        } else {
            emitter.power = kept_positive(emitter.power, true);
        }
        emitters.push(emitter);
    }
    Ok(emitters)
}

/// Row of the new light, or NONE when it has no power.
fn add_light(lights: &mut Vec<LightRecord>, powers: &mut Vec<f64>, emitter: &Emitter) -> u32 {
    if emitter.power.is_nan() || emitter.power <= 0.0 {
        return NONE;
    }
    lights.push(emitter.record);
    powers.push(emitter.power);
    lights.len() as u32 - 1
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
        // `image_file::read_sky` gives floats; no other image becomes a sky.
        scene::Pixels::Rgba16(_) => Vec::new(),
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
