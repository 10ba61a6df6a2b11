//! Error against run time: variants of a render, repeated with independent seeds, judged by a reference while they run.
//!
//! A run renders levels of 1, 2, 4, ... blocks of 16 samples until its time budget, and one last snapshot that fills it. The clock
//! holds the set-up (prepare, BVH, compile, upload) and every pass with the host's summing; judging a snapshot is not in it. Rounds
//! alternate the variants forwards and backwards (ABBA), so that a machine that slows down hurts all alike. Replicates differ in
//! the seed and share nothing. Statistics are in `curves`, the reference in `reference`, plots and page in `plot` and `page`.

pub mod curves;
pub mod page;
mod plot;
pub mod reference;
mod table;
pub mod variant;

pub use page::write;
pub use variant::Variant;

use std::time::Instant;

use crate::error::Error;
use crate::film::Film;
use crate::film::adaptive;
use crate::film::slot::BLOCK_SAMPLES;
use crate::film::source::{DeviceInfo, SampleSource};
use crate::metric::error::{self, Errors};
use crate::metric::estimate::{self, FilmError};
use crate::output::image::Picture;
use reference::Reference;

/// What is asked of `run`.
#[derive(Clone, Debug)]
pub struct Plan {
    pub variants: Vec<Variant>,
    pub repeats: u32,
    /// Seconds of a run, set-up included.
    pub budget_s: f64,
    /// Seed of the first replicate; each takes the next.
    pub seed: u32,
}

/// One run at one moment.
#[derive(Clone, Debug)]
pub struct Snapshot {
    pub spp: u64,
    /// Set-up and passes so far.
    pub seconds: f64,
    pub errors: Errors,
    /// The render's own estimate; None below two blocks.
    pub estimate: Option<FilmError>,
}

/// One replicate of one variant.
#[derive(Clone, Debug)]
pub struct Run {
    /// Place in `Plan::variants`.
    pub variant: usize,
    pub repeat: u32,
    pub seed: u32,
    pub setup_s: f64,
    /// Levels in ascending spp; the last one fills the budget.
    pub snapshots: Vec<Snapshot>,
}

/// Mean and spread over the replicates of one variant at one level, pixel by pixel.
#[derive(Clone, Debug)]
pub struct Level {
    pub spp: u64,
    pub count: u32,
    sum: Vec<[f64; 3]>,
    square: Vec<[f64; 3]>,
}

/// Everything that was seen of one scene.
#[derive(Clone, Debug)]
pub struct Study {
    pub scene: String,
    pub plan: Plan,
    pub reference: Reference,
    pub runs: Vec<Run>,
    /// By variant, then level.
    pub levels: Vec<Vec<Level>>,
    /// By variant: the first replicate at the end of its budget.
    pub pictures: Vec<Picture>,
    /// By variant.
    pub devices: Vec<DeviceInfo>,
}

/// Makes the source of a variant with a seed; the time it takes is the run's set-up.
pub type Open<'a> = dyn Fn(&Variant, u32) -> Result<Box<dyn SampleSource + 'a>, Error> + 'a;

/// Runs every replicate. `observe` is told before each run.
pub fn run(
    scene: &str,
    plan: &Plan,
    reference: Reference,
    open: &Open,
    interrupted: &dyn Fn() -> bool,
    observe: &dyn Fn(&Variant, u32),
) -> Result<Study, Error> {
    let count = plan.variants.len();
    let mut study = Study {
        scene: scene.to_owned(),
        plan: plan.clone(),
        reference,
        runs: Vec::new(),
        levels: vec![Vec::new(); count],
        pictures: vec![Picture { width: 0, height: 0, pixels: Vec::new() }; count],
        devices: vec![DeviceInfo::default(); count],
    };
    for repeat in 0..plan.repeats {
        for step in 0..count {
            if interrupted() {
                return Ok(study);
            }
            let variant = if repeat % 2 == 0 { step } else { count - 1 - step };
            observe(&plan.variants[variant], repeat);
            one_run(&mut study, variant, repeat, open, interrupted)?;
        }
    }
    Ok(study)
}

fn one_run(
    study: &mut Study,
    variant: usize,
    repeat: u32,
    open: &Open,
    interrupted: &dyn Fn() -> bool,
) -> Result<(), Error> {
    let seed = study.plan.seed.wrapping_add(repeat);
    let begun = Instant::now();
    let mut source = open(&study.plan.variants[variant], seed)?;
    let setup_s = begun.elapsed().as_secs_f64();
    let (width, height) = source.resolution();
    let mut film = Film::new(width, height, source.aovs(), 0);
    if study.plan.variants[variant].adaptive {
        film.begin_adaptive();
    }
    let mut run = Run { variant, repeat, seed, setup_s, snapshots: Vec::new() };
    let (mut done, mut clock, mut seconds_a_block) = (0u64, setup_s, 0.0);
    // The first level always runs; then doublings that fit, then what is left of the budget. The first pass may hold the driver's
    // compilation: it says nothing of the rate.
    loop {
        let affordable = match done {
            0 => 1,
            1 => u64::from(clock < study.plan.budget_s),
            _ => ((study.plan.budget_s - clock) / seconds_a_block).max(0.0) as u64,
        };
        let count = done.max(1).min(affordable);
        if count == 0 || interrupted() {
            break;
        }
        let is_level = count == done.max(1);
        let pass = Instant::now();
        match film.is_adaptive() {
            true => adaptive::advance(source.as_mut(), &mut film, done + count, &|| false)?,
            false => source.render_blocks(done..done + count, &mut film, &|| false)?,
        };
        let pass_s = pass.elapsed().as_secs_f64();
        (clock, done, seconds_a_block) = (clock + pass_s, done + count, pass_s / count as f64);
        let picture = Picture::of_film(&film);
        run.snapshots.push(Snapshot {
            spp: done * u64::from(BLOCK_SAMPLES),
            seconds: clock,
            errors: error::compare(&picture.pixels, &study.reference.picture.pixels, width as usize),
            estimate: estimate::from_film(&film),
        });
        if is_level {
            add_to_level(&mut study.levels[variant], done * u64::from(BLOCK_SAMPLES), &picture);
        }
        if repeat == 0 {
            study.pictures[variant] = picture;
        }
        if !is_level {
            break;
        }
    }
    study.devices[variant] = source.describe();
    study.runs.push(run);
    Ok(())
}

/// Adds a replicate's picture to the level of `spp`.
fn add_to_level(levels: &mut Vec<Level>, spp: u64, picture: &Picture) {
    let place = levels.iter().position(|l| l.spp == spp).unwrap_or_else(|| {
        let zero = vec![[0.0; 3]; picture.pixels.len()];
        levels.push(Level { spp, count: 0, sum: zero.clone(), square: zero });
        levels.len() - 1
    });
    let level = &mut levels[place];
    level.count += 1;
    for ((sum, square), pixel) in level.sum.iter_mut().zip(&mut level.square).zip(&picture.pixels) {
        for c in 0..3 {
            let value = f64::from(pixel[c]);
            sum[c] += value;
            square[c] += value * value;
        }
    }
}
