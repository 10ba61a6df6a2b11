//! AOVs of the device against both modes of the oracle.
//!
//! Gate 6: one block a pixel on the same integers; what the first surface says agrees to rounding, sums of parts are the whole, ids
//! are equal. Gate 7: means over the image of independent samples, block by block, by Welch's t test; coverage object by object.

use std::sync::Arc;

use super::images;
use super::report::{Gate, GateRow};
use super::subject::Subject;
use crate::error::Error;
use crate::film::Film;
use crate::film::aov::layout::Entry;
use crate::film::aov::{AOVS, Aovs, GROUPS, Layout, Source, index_of};
use crate::film::slot::BLOCK_SAMPLES;
use crate::integrator::{Estimator, Settings};
use crate::metric::stats::{Moments, sidak, welch_t};
use crate::prepare;
use crate::reference::independent::Independent;
use crate::reference::render;
use crate::reference::replay::Replay;
use crate::scene::Scene;

/// Chance of a false alarm of a row of gate 7.
const LEVEL: f64 = 1e-4;
/// Blocks on each side in gate 7.
const BLOCKS: u64 = 16;
/// Largest share of pixels whose block holds a parted sample: 1 - (1 - 0.01)^16, as gate 6 allows single samples.
const PARTED_SHARE: f64 = 0.15;

/// Every AOV, and the settings that ask for them.
fn all(scene: &Scene, settings: Settings) -> Result<Settings, Error> {
    Ok(Settings { aovs: Aovs::ALL.of_scene(scene).map_err(Error::Usage)?, ..settings })
}

/// What an entry of the slots is called.
fn name(e: &Entry) -> String {
    let aov = &AOVS[e.index];
    if let Source::Groups = aov.source { format!("light group {}", e.part) } else { aov.name.to_owned() }
}

/// Gate 6.
pub fn replay(subject: &Subject, scene: &Scene) -> Result<GateRow, Error> {
    let settings = all(scene, Settings::default())?;
    let seen = subject.film(scene, &settings, 1)?;
    let prepared = prepare::prepare(scene, &settings).map_err(|e| Error::Scene(e.to_string()))?;
    let wanted = render::film(Replay::new(Arc::new(prepared), &settings), settings, 1);
    let pixels = seen.pixel_count();
    let (mut worst, mut worst_name) = (0, String::new());
    for e in &Layout::of(settings.aovs).entries {
        let scale =
            (0..pixels).filter_map(|p| wanted.part_mean(e.index, e.part, p)).flatten().filter(|v| v.is_finite());
        let floor = 1e-3 * scale.fold(1e-6f64, |a, v| a.max(v.abs()));
        let parted = (0..pixels).filter(|&p| is_parted(&seen, &wanted, e, p, floor)).count();
        if parted >= worst {
            (worst, worst_name) = (parted, name(e));
        }
    }
    let whole = wrong_sums(&seen);
    let share = worst as f64 / pixels as f64;
    Ok(GateRow::new(
        Gate::Replay,
        format!("aov replay {}", scene.name),
        share <= PARTED_SHARE && whole == 0,
        format!("most parted: {worst_name}, {worst} of {pixels} pixels; {whole} pixels whose parts are not the whole"),
        format!("parted <= {PARTED_SHARE}; direct + indirect = radiance = sum of light groups, coverages sum to 1"),
    ))
}

fn is_parted(a: &Film, b: &Film, e: &Entry, pixel: usize, floor: f64) -> bool {
    let sorted = |film: &Film| {
        let mut ids: Vec<(u32, u32)> = film.ids(e.index, pixel).collect();
        ids.sort_unstable();
        ids
    };
    match (a.part_mean(e.index, e.part, pixel), b.part_mean(e.index, e.part, pixel)) {
        (Some(x), Some(y)) => (0..3).any(|c| {
            let is_same = x[c] == y[c] || (x[c] - y[c]).abs() <= 2e-3 * x[c].abs().max(y[c].abs()) + floor;
            !is_same
        }),
        _ => sorted(a) != sorted(b),
    }
}

/// Relative rounding of a sum in f32 of what brings no negative light: 50 additions a sample, 16 samples, half an ulp each.
const SUM_ROUNDING: f64 = 66.0 / (1 << 24) as f64;

/// Pixels whose direct and indirect light, or whose light groups, are not all of it, or whose ids are not as many as its samples.
fn wrong_sums(film: &Film) -> usize {
    let (direct, indirect) = (index_of("direct"), index_of("indirect"));
    let groups = 0..film.aovs().group_count() as usize;
    let is_wrong = |pixel: usize| {
        let radiance = film.mean(pixel);
        let adds_up = |parts: &[[f64; 3]]| {
            (0..3).all(|c| {
                let (sum, size) = parts.iter().fold((0.0, 0.0), |(sum, size), p| (sum + p[c], size + p[c].abs()));
                (sum - radiance[c]).abs() <= SUM_ROUNDING * (size + radiance[c].abs())
            })
        };
        let part = |index: usize, part: usize| film.part_mean(index, part, pixel).unwrap_or([f64::NAN; 3]);
        let by_group: Vec<[f64; 3]> = groups.clone().map(|g| part(index_of(GROUPS), g)).collect();
        let is_whole = adds_up(&[part(direct, 0), part(indirect, 0)]) && adds_up(&by_group);
        let samples = film.block_count(pixel) * BLOCK_SAMPLES;
        let counted = [index_of("object"), index_of("material")].iter().all(|&k| {
            let total: u32 = film.ids(k, pixel).map(|(_, count)| count).sum();
            total == samples
        });
        !is_whole || !counted
    };
    (0..film.pixel_count()).filter(|&p| is_wrong(p)).count()
}

/// Gate 7.
pub fn image(subject: &Subject, scene: &Scene) -> Result<GateRow, Error> {
    let settings = all(scene, images::settings(Estimator::Mis))?;
    let world = Independent::new(scene);
    let layout = Layout::of(settings.aovs);
    let device = subject.films(scene, &settings, BLOCKS)?;
    let mut oracle = render::Renderer::new(world, settings);
    let oracle = (0..BLOCKS).map(|k| {
        let mut film = Film::new(scene.film.width, scene.film.height, settings.aovs, k);
        use crate::film::source::SampleSource;
        oracle.render_blocks(k..k + 1, &mut film, &|| false).map(|_| film)
    });
    let oracle: Vec<Film> = oracle.collect::<Result<_, _>>()?;
    let origin = prepare::prepare(scene, &settings).map_err(|e| Error::Scene(e.to_string()))?.origin;
    let mut tests: Vec<(String, Vec<f64>, Vec<f64>)> = Vec::new();
    for e in &layout.entries {
        let aov = &AOVS[e.index];
        for c in 0..e.width {
            // Positions of the records are those of the world less its origin.
            let shift = if aov.name == "position" { origin[c] } else { 0.0 };
            let mean = |film: &Film, shift: f64| sum_over_pixels(film, e, c, shift);
            let (a, b) = (device.iter().map(|f| mean(f, shift)), oracle.iter().map(|f| mean(f, 0.0)));
            tests.push((format!("{}.{}", name(e), aov.channels[c]), a.collect(), b.collect()));
        }
        if e.width == 0 {
            let count = if aov.name == "object" { scene.instances.len() } else { scene.materials.len() };
            for id in 0..count as u32 {
                let share = |film: &Film| {
                    let of_pixel =
                        |p: usize| film.ids(e.index, p).filter(|i| i.0 == id).map(|i| f64::from(i.1)).sum::<f64>();
                    (0..film.pixel_count()).map(of_pixel).sum::<f64>() / film.sample_count() as f64
                };
                tests.push((
                    format!("{} {id}", aov.name),
                    device.iter().map(share).collect(),
                    oracle.iter().map(share).collect(),
                ));
            }
        }
    }
    let level = sidak(LEVEL, tests.len());
    let (mut p, mut at) = (1.0, String::new());
    for (name, a, b) in &tests {
        let (ma, mb) = (Moments::of(a.iter().copied()), Moments::of(b.iter().copied()));
        let is_close = (ma.mean - mb.mean).abs() <= 2e-5 * ma.mean.abs().max(mb.mean.abs()).max(1e-3);
        let this = if is_close { 1.0 } else { welch_t(ma, mb).p };
        if this.is_nan() || this <= p {
            (p, at) = (this, format!("{name}: {:.6} for {:.6}", ma.mean, mb.mean));
        }
    }
    Ok(GateRow::new(
        Gate::Images,
        format!("aov image {}", scene.name),
        p >= level,
        format!("worst {at}, p = {p:.1e}"),
        format!("p >= {level:.1e} in {} tests of {BLOCKS} blocks", tests.len()),
    ))
}

/// Mean over the pixels, of what is a mean over the hits weighed by how often something was hit.
fn sum_over_pixels(film: &Film, e: &Entry, channel: usize, shift: f64) -> f64 {
    let is_of_hits = matches!(AOVS[e.index].source, Source::Surface { .. });
    let value = |p: usize| match if is_of_hits { film.hit_share(p) } else { 1.0 } {
        share if share > 0.0 => film.part_mean(e.index, e.part, p).map_or(0.0, |v| (v[channel] + shift) * share),
        _ => 0.0,
    };
    (0..film.pixel_count()).map(value).sum::<f64>() / film.pixel_count() as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::scenes;

    /// The direct layer is the picture of paths of two edges, number for number: the same samples, and roulette starts later.
    #[test]
    fn direct_light_is_the_picture_of_two_edges() {
        for scene in [scenes::cornell(12), scenes::alpha_sheets(12), scenes::materials(12)] {
            let settings = all(&scene, Settings::default()).unwrap();
            let all = render::film(Independent::new(&scene), settings, 2);
            let two =
                render::film(Independent::new(&scene), Settings { max_depth: 2, aovs: Aovs::NONE, ..settings }, 2);
            let index = index_of("direct");
            for p in 0..all.pixel_count() {
                assert_eq!(all.aov_mean(index, p).unwrap(), two.mean(p), "{} {p}", scene.name);
            }
            assert_eq!(wrong_sums(&all), 0, "{}", scene.name);
        }
    }

    /// In both worlds of the oracle: f64 until a slot is written, so that a block's sums differ by their own rounding.
    #[test]
    fn light_groups_add_up_in_the_oracle() {
        for scene in [scenes::lights::lamps(10), scenes::lights::glowing(10), scenes::alpha_sheets(10)] {
            for estimator in [Estimator::Mis, Estimator::Light] {
                let settings = all(&scene, Settings { estimator, ..Settings::default() }).unwrap();
                let prepared = Arc::new(prepare::prepare(&scene, &settings).unwrap());
                let films = [
                    render::film(Independent::new(&scene), settings, 2),
                    render::film(Replay::new(prepared, &settings), settings, 2),
                ];
                let index = index_of(GROUPS);
                let groups = scene.light_groups();
                assert!(groups.len() > 1, "{}", scene.name);
                for film in films {
                    let mut seen = vec![0.0; groups.len()];
                    for p in 0..film.pixel_count() {
                        let parts: Vec<_> = (0..groups.len()).map(|g| film.part_mean(index, g, p).unwrap()).collect();
                        for c in 0..3 {
                            let (sum, r) = (parts.iter().map(|x| x[c]).sum::<f64>(), film.mean(p)[c]);
                            assert!((sum - r).abs() <= 1.2e-7 * r, "{} {p}: {sum} for {r}", scene.name);
                        }
                        seen.iter_mut().zip(&parts).for_each(|(s, x)| *s += x[0]);
                    }
                    assert!(seen.iter().all(|s| *s > 0.0), "{} {groups:?} {seen:?}", scene.name);
                }
            }
        }
    }

    /// By hand: `cargo test --lib conform::aov -- --ignored --nocapture`.
    #[test]
    #[ignore = "prints the rows of the AOVs on the first Vulkan device"]
    fn print_rows() {
        let device = crate::gpu::Device::open(&crate::gpu::Choice::Auto, &crate::gpu::Options::default()).unwrap();
        let subject = Subject::new(&device);
        for scene in scenes::all(32) {
            for r in [replay(&subject, &scene).unwrap(), image(&subject, &scene).unwrap()] {
                println!("{:?} gate {} {}: {}  [{}]", r.verdict, r.gate.number(), r.name, r.evidence, r.bound);
            }
        }
    }
}
