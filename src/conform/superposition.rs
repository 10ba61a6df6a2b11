//! Gate 7: light adds up, and light groups take it apart. The image under all lights is the sum of the images under each share of them (Veach 1997, section 4.2:
//! transport is linear), square by square within the noise of all four.

use super::images;
use super::report::{Gate, GateRow};
use super::subject::Subject;
use crate::error::Error;
use crate::film::Film;
use crate::film::aov::{self, Aovs, GROUPS};
use crate::film::slot::BLOCK_SAMPLES;
use crate::integrator::{Estimator, Settings};
use crate::metric::stats::{Moments, normal_quantile, sidak, welch_t};
use crate::scene::{Scene, groups};

/// False alarms of the row, at most.
const LEVEL: f64 = 1e-4;
/// Systematic rounding of an f32 mean, relative.
const ROUNDING: f64 = 2e-5;
/// Side of the squares in pixels.
const SIDE: usize = 8;

/// `scene` under its lamps dealt out to three scenes; the first has the sky and the emitting surfaces too.
fn shares(scene: &Scene) -> [Scene; 3] {
    std::array::from_fn(|k| {
        let mut share = scene.clone();
        let mut number = 0;
        share.lights.retain(|_| {
            number += 1;
            (number - 1) % 3 == k
        });
        if k > 0 {
            share.sky = None;
            share.materials.iter_mut().for_each(|m| m.emission = None);
        }
        share
    })
}

/// `scene` under the lights of one group alone.
fn alone(scene: &Scene, group: &str) -> Scene {
    let is_other = |name: &Option<String>| groups::name(name.as_deref()) != group;
    let mut alone = scene.clone();
    alone.lights.retain(|l| !is_other(&l.group));
    alone.materials.iter_mut().filter(|m| is_other(&m.group)).for_each(|m| m.emission = None);
    if is_other(&alone.sky_group) {
        alone.sky = None;
    }
    alone
}

fn square_count(film: &Film) -> usize {
    (film.width() as usize).div_ceil(SIDE) * (film.height() as usize).div_ceil(SIDE)
}

/// Number of the square that a pixel lies in.
fn square_of(pixel: usize, film: &Film) -> usize {
    let width = film.width() as usize;
    pixel / width / SIDE * width.div_ceil(SIDE) + pixel % width / SIDE
}

/// Sums over each square and channel of one block's film; of a light group, or of all light.
fn block_sums(film: &Film, part: Option<usize>) -> Vec<f64> {
    let index = aov::index_of(GROUPS);
    let mut sums = vec![0.0; square_count(film) * 3];
    for pixel in 0..film.pixel_count() {
        let square = square_of(pixel, film);
        let value = match part {
            Some(part) => film.part_mean(index, part, pixel).unwrap_or([f64::NAN; 3]),
            None => film.mean(pixel),
        };
        (0..3).for_each(|c| sums[3 * square + c] += value[c]);
    }
    sums
}

/// Each light group of one render against a render under its lights alone, square by square by Welch's t test of the blocks.
pub fn groups_row(subject: &Subject, scene: &Scene, spp: u32) -> Result<GateRow, Error> {
    let blocks = u64::from(spp.div_ceil(BLOCK_SAMPLES));
    let names = scene.light_groups();
    let aovs = Aovs::NONE.with(GROUPS).of_scene(scene).map_err(Error::Usage)?;
    let all = subject.films(scene, &Settings { aovs, ..images::settings(Estimator::Mis) }, blocks)?;
    let mut pairs: Vec<(usize, Moments, Moments)> = Vec::new();
    for (part, name) in names.iter().enumerate() {
        let settings = Settings { seed: 1 + part as u32, ..images::settings(Estimator::Mis) };
        let lone = subject.films(&alone(scene, name), &settings, blocks)?;
        let a: Vec<Vec<f64>> = all.iter().map(|film| block_sums(film, Some(part))).collect();
        let b: Vec<Vec<f64>> = lone.iter().map(|film| block_sums(film, None)).collect();
        let of = |means: &[Vec<f64>], k: usize| Moments::of(means.iter().map(|m| m[k]));
        pairs.extend((0..a[0].len()).map(|k| (part, of(&a, k), of(&b, k))));
    }
    let level = sidak(LEVEL, pairs.len());
    let (mut p, mut at) = (1.0, 0);
    for (part, a, b) in &pairs {
        let is_close = (a.mean - b.mean).abs() <= ROUNDING * a.mean.abs().max(b.mean.abs());
        let this = if is_close { 1.0 } else { welch_t(*a, *b).p };
        if this.is_nan() || this < p {
            (p, at) = (this, *part);
        }
    }
    Ok(GateRow::new(
        Gate::Images,
        format!("light groups {}", scene.name),
        p >= level,
        format!("{spp} spp: worst square in \"{}\", p = {p:.1e}", names.get(at).map_or("", String::as_str)),
        format!(
            "each of {} layers is the image of its lights alone: p >= {level:.1e} in {} tests",
            names.len(),
            pairs.len()
        ),
    ))
}

/// Sums over each square and channel: mean and variance of the mean.
fn squares(film: &Film) -> Vec<(f64, f64)> {
    let mut sums = vec![(0.0, 0.0); square_count(film) * 3];
    for pixel in 0..film.pixel_count() {
        let square = square_of(pixel, film);
        for channel in 0..3 {
            let sum = &mut sums[3 * square + channel];
            sum.0 += film.mean(pixel)[channel];
            sum.1 += film.variance_of_mean(pixel)[channel];
        }
    }
    sums
}

pub fn row(subject: &Subject, scene: &Scene, spp: u32) -> Result<GateRow, Error> {
    let blocks = u64::from(spp.div_ceil(BLOCK_SAMPLES));
    let film = |scene: &Scene, seed| -> Result<Film, Error> {
        subject.film(scene, &Settings { seed, ..images::settings(Estimator::Mis) }, blocks)
    };
    let all = squares(&film(scene, 0)?);
    let mut sum = vec![(0.0, 0.0); all.len()];
    for (seed, share) in (1..).zip(shares(scene)) {
        for (s, part) in sum.iter_mut().zip(squares(&film(&share, seed)?)) {
            (s.0, s.1) = (s.0 + part.0, s.1 + part.1);
        }
    }
    let z = normal_quantile(1.0 - 0.5 * sidak(LEVEL, all.len()));
    let of_bound = all.iter().zip(&sum).map(|(a, s)| {
        let (off, bound) = ((a.0 - s.0).abs(), z * (a.1 + s.1).sqrt() + ROUNDING * a.0.abs());
        if off == 0.0 { 0.0 } else { off / bound }
    });
    let worst = of_bound.fold(0.0, |worst: f64, x| if x.is_nan() || x > worst { x } else { worst });
    let total = |s: &[(f64, f64)]| s.iter().map(|x| x.0).sum::<f64>();
    Ok(GateRow::new(
        Gate::Images,
        format!("superposition {}", scene.name),
        worst <= 1.0,
        format!(
            "{spp} spp: worst square {worst:.2} of its bound; sums differ by {:+.3} %",
            100.0 * (total(&all) / total(&sum) - 1.0)
        ),
        format!("image(A + B + C) = image(A) + image(B) + image(C) in {} tests, {z:.1} standard errors", all.len()),
    ))
}
