//! The progressive loop over a `SampleSource`: passes of whole blocks until a stop, with an error estimate on the way.
//!
//! A pass is sized to a time budget: half a second at first (so that progress and Ctrl-C are prompt), a tenth of the time
//! traced so far later (so that the host's share stays small), at most 4 s. `--spp` is exact; `--time` counts from process
//! start: every pixel gets one block at least, and the last pass is cut between two tiles where the clock says so (`Deadline`), so
//! that some pixels have a block more than others, as after an interrupt. `--error` looks
//! at the upper end of the estimate's interval: a render that stops on its own estimate prefers low ones, and the value alone would
//! promise too much. While the estimate's tails are too heavy for its interval it does not stop. On an interrupt the source stops after whole blocks, and what is there is kept.

pub mod bands;
mod level;

use std::cell::Cell;
use std::time::{Duration, Instant};

use crate::error::Error;
use crate::film::adaptive;
use crate::film::slot::BLOCK_SAMPLES;
use crate::film::source::SampleSource;
use crate::film::{Film, Tile};
use crate::metric::estimate::{self, FilmError};

/// Seconds of a pass: at first, as a share of the time so far, and at most.
const FIRST_BUDGET_S: f64 = 0.5;
const BUDGET_SHARE: f64 = 0.1;
const LAST_BUDGET_S: f64 = 4.0;
/// The error is estimated again when this much more time has passed since it was last: it costs a walk over the film.
const ESTIMATE_GROWTH: f64 = 1.3;
/// And takes at most this share of the time.
const ESTIMATE_SHARE: f64 = 0.02;
/// No render stops on its error before this many blocks: with fewer a pixel's variance is a guess, and what is rare was not yet met.
const ERROR_MIN_BLOCKS: u64 = 4;

/// Where progress stands while only the estimate's tails keep a render from its end.
const BY_TAILS: f64 = 0.99;

/// When to stop: whichever comes first.
#[derive(Clone, Copy, Debug)]
pub struct Stops {
    /// Blocks of 16 samples a pixel.
    pub blocks: Option<u64>,
    /// Seconds since `started`.
    pub time_s: Option<f64>,
    /// relMSE (epsilon (0.1 mean)^2) that the upper end of the estimate's 95 % interval must reach, with tails that let it be trusted.
    pub error: Option<f64>,
    /// Start of the process, as far as known.
    pub started: Instant,
}

/// Whole blocks that hold at least `spp` samples.
pub fn blocks_for(spp: u64) -> u64 {
    spp.div_ceil(BLOCK_SAMPLES as u64).max(1)
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StoppedBy {
    Spp,
    Time,
    Error,
    Interrupt,
}

impl StoppedBy {
    pub fn name(self) -> &'static str {
        match self {
            Self::Spp => "spp",
            Self::Time => "time",
            Self::Error => "error",
            Self::Interrupt => "interrupt",
        }
    }
}

/// What is known between two passes.
#[derive(Clone, Copy, Debug)]
pub struct Progress {
    pub blocks_done: u64,
    pub blocks_wanted: Option<u64>,
    /// Since `Stops::started`.
    pub elapsed_s: f64,
    pub time_wanted_s: Option<f64>,
    pub error_wanted: Option<f64>,
    /// The latest estimate; it may be a few passes old.
    pub error: Option<FilmError>,
}

impl Progress {
    /// Share of the work done, by the stop that is nearest.
    pub fn fraction(&self) -> f64 {
        let by_blocks = self.blocks_wanted.map_or(0.0, |w| self.blocks_done as f64 / w as f64);
        let by_time = self.time_wanted_s.map_or(0.0, |w| self.elapsed_s / w);
        // The error falls as one over the samples.
        let by_error = self.error_wanted.zip(self.error).map_or(0.0, |(w, e)| match self.waits_for_tails() {
            true => BY_TAILS,
            false => w / e.relmse_exposure.high.max(w),
        });
        by_blocks.max(by_time).max(by_error).clamp(0.0, 1.0)
    }

    /// The interval is below the wanted error, and its tails are too heavy to trust it: the render goes on.
    pub fn waits_for_tails(&self) -> bool {
        let wanted = self.error_wanted.zip(self.error);
        wanted.is_some_and(|(w, e)| e.relmse_exposure.high <= w && e.is_heavy_tailed)
            && self.blocks_done >= ERROR_MIN_BLOCKS
    }
}

/// A finished render.
#[derive(Debug)]
pub struct Outcome {
    pub film: Film,
    pub stopped_by: StoppedBy,
    /// Seconds in the loop, and rays traced in it.
    pub trace_s: f64,
    pub rays: u64,
    pub error: Option<FilmError>,
}

/// Renders all of the source's image until a stop: see `render_window`.
pub fn render(
    source: &mut dyn SampleSource,
    stops: &Stops,
    interrupted: &dyn Fn() -> bool,
    observe: &mut dyn FnMut(&Progress),
) -> Result<Outcome, Error> {
    let (width, height) = source.resolution();
    render_window(source, Tile::image(width, height), stops, interrupted, observe)
}

/// Renders `window` of the source's image until a stop: see `render_film`.
pub fn render_window(
    source: &mut dyn SampleSource,
    window: Tile,
    stops: &Stops,
    interrupted: &dyn Fn() -> bool,
    observe: &mut dyn FnMut(&Progress),
) -> Result<Outcome, Error> {
    Film::check_memory(window.width, window.height, source.aovs())?;
    let film = Film::over(window, source.aovs(), 0);
    render_film(source, film, stops, interrupted, &mut |progress, _| {
        observe(progress);
        Ok(())
    })
}

/// Adds blocks to `film`, which may have some already, until a stop: of its blocks together, and of the time since `stops.started`.
/// A film whose pixels differ in blocks, as an interrupt leaves it, is made level first. Where sampling is adaptive
/// (`Film::begin_adaptive`), blocks are those of a pixel on average. `interrupted` is polled between blocks;
/// `observe` is called after each pass with the film as it is then, and its error ends the render.
pub fn render_film(
    source: &mut dyn SampleSource,
    film: Film,
    stops: &Stops,
    interrupted: &dyn Fn() -> bool,
    observe: &mut dyn FnMut(&Progress, &Film) -> Result<(), Error>,
) -> Result<Outcome, Error> {
    render_by(&Instant::now, source, film, stops, interrupted, observe)
}

/// `render_film` by a clock, which tests set.
fn render_by(
    now: &dyn Fn() -> Instant,
    source: &mut dyn SampleSource,
    mut film: Film,
    stops: &Stops,
    interrupted: &dyn Fn() -> bool,
    observe: &mut dyn FnMut(&Progress, &Film) -> Result<(), Error>,
) -> Result<Outcome, Error> {
    if film.aovs() != source.aovs() {
        let (kept, made) = (film.aovs().list(), source.aovs().list());
        return Err(Error::Usage(format!("a film that keeps {kept} takes no samples with {made}")));
    }
    let since = |then: Instant| now().duration_since(then).as_secs_f64();
    let begun = now();
    let mut rays = if film.is_adaptive() { 0 } else { level::level(source, &mut film, interrupted)? };
    let first = film.first_block();
    let mut done = film.blocks_done();
    let mut pace = Pace::default();
    let deadline = Deadline::new(now, stops);
    let mut next_estimate_s = 0.0;
    // The latest estimate, and the blocks that it was made from.
    let mut error: Option<FilmError> = estimate::from_film(&film);
    let mut estimated_at = done;
    let stopped_by = loop {
        if interrupted() {
            break StoppedBy::Interrupt;
        }
        let left = stops.blocks.map_or(u64::MAX, |wanted| wanted.saturating_sub(done));
        if left == 0 {
            break StoppedBy::Spp;
        }
        if done > 0 && deadline.is_due() {
            break StoppedBy::Time;
        }
        let time_left_s = stops.time_s.map_or(f64::INFINITY, |t| t - since(stops.started));
        let affordable = pace.affordable(time_left_s);
        if let (Some(wanted), Some(e)) = (stops.error, error)
            && done >= ERROR_MIN_BLOCKS
            && e.relmse_exposure.high <= wanted
            && !e.is_heavy_tailed
        {
            break StoppedBy::Error;
        }
        let count = pace.pass_blocks(since(begun)).min(left).min(affordable);
        let count = count.min(blocks_to_error(stops, error, estimated_at, done));
        let pass_begun = now();
        deadline.begin_pass();
        // The first block is taken whatever the clock says.
        let stop = || interrupted() || (deadline.tile_ended() && done > 0);
        let pass = match film.is_adaptive() {
            true => adaptive::advance(source, &mut film, done + count, &stop),
            false => source.render_blocks(first + done..first + done + count, &mut film, &stop),
        };
        rays += pass?.rays;
        // Not every source asks after its last tile.
        deadline.tile_ended();
        pace.learn(count, since(pass_begun));
        done = film.blocks_done();
        let trace_s = since(begun);
        let is_near = blocks_to_error(stops, error, estimated_at, done) <= count;
        if trace_s >= next_estimate_s || is_near {
            error = estimate::from_film(&film).or(error);
            estimated_at = done;
            let took_s = since(begun) - trace_s;
            next_estimate_s = (trace_s * ESTIMATE_GROWTH).max(trace_s + took_s / ESTIMATE_SHARE);
        }
        let progress = Progress {
            blocks_done: done,
            blocks_wanted: stops.blocks,
            elapsed_s: since(stops.started),
            time_wanted_s: stops.time_s,
            error_wanted: stops.error,
            error,
        };
        observe(&progress, &film)?;
    };
    let trace_s = since(begun);
    let error = estimate::from_film(&film);
    Ok(Outcome { film, stopped_by, trace_s, rays, error })
}

/// Blocks after which the error should be the wanted one, falling as one over the samples; at least 1. No limit when none is wanted.
/// When tails get light nobody knows: it is looked again after some growth, not after every block.
fn blocks_to_error(stops: &Stops, error: Option<FilmError>, estimated_at: u64, done: u64) -> u64 {
    match (stops.error, error) {
        (Some(wanted), Some(e)) => {
            let growth = if e.is_heavy_tailed { ESTIMATE_GROWTH } else { 0.0 };
            let needed = (estimated_at as f64 * growth.max(e.relmse_exposure.high / wanted)).ceil() as u64;
            needed.saturating_sub(done).max(1)
        }
        (Some(_), None) => ERROR_MIN_BLOCKS,
        (None, _) => u64::MAX,
    }
}

/// Seconds a block, as measured; the first pass holds the driver's compilation and only bounds it from above.
#[derive(Default)]
struct Pace {
    passes: u32,
    last_count: u64,
    seconds_a_block: f64,
}

impl Pace {
    fn learn(&mut self, count: u64, seconds: f64) {
        let measured = seconds / count as f64;
        // From the third pass on a running mean: one slow pass must not end a timed render early.
        self.seconds_a_block = if self.passes < 2 { measured } else { 0.5 * (self.seconds_a_block + measured) };
        self.last_count = count;
        self.passes += 1;
    }

    /// Blocks for the next pass, at most twice the last.
    fn pass_blocks(&self, trace_s: f64) -> u64 {
        if self.passes == 0 {
            return 1;
        }
        let budget_s = (BUDGET_SHARE * trace_s).clamp(FIRST_BUDGET_S, LAST_BUDGET_S);
        ((budget_s / self.seconds_a_block) as u64).clamp(1, 2 * self.last_count)
    }

    /// Blocks that are begun in `time_left_s`, one at least; the clock cuts the last.
    fn affordable(&self, time_left_s: f64) -> u64 {
        if self.passes == 0 { 1 } else { ((time_left_s / self.seconds_a_block).ceil() as u64).max(1) }
    }
}

/// When the time is up: from where one more tile, as long as the last one, would end later than the wish is away now.
struct Deadline<'a> {
    now: &'a dyn Fn() -> Instant,
    end: Option<Instant>,
    /// When the last tile ended or the pass began, and how long the last tile took.
    last: Cell<(Instant, Duration)>,
    /// It was due once. A source that has stopped for it has left out blocks, so that it stays due, whatever later tiles took.
    is_over: Cell<bool>,
}

impl<'a> Deadline<'a> {
    fn new(now: &'a dyn Fn() -> Instant, stops: &Stops) -> Self {
        let after = stops.time_s.and_then(|t| Duration::try_from_secs_f64(t.max(0.0)).ok());
        let end = after.and_then(|after| stops.started.checked_add(after));
        Self { now, end, last: Cell::new((now(), Duration::ZERO)), is_over: Cell::new(false) }
    }

    fn begin_pass(&self) {
        self.last.set(((self.now)(), self.last.get().1));
    }

    /// Whether there is no time for another.
    fn tile_ended(&self) -> bool {
        let now = (self.now)();
        let (before, last) = self.last.get();
        let took = now.duration_since(before);
        // Sources also ask before their first tile, where next to no time has passed; tiles are sized alike, so that a sixteenth
        // of one is none.
        self.last.set((now, if took < last / 16 { last } else { took }));
        self.is_due()
    }

    fn is_due(&self) -> bool {
        let is_due = self.end.is_some_and(|end| (self.now)() + self.last.get().1 / 2 >= end);
        self.is_over.set(self.is_over.get() || is_due);
        self.is_over.get()
    }
}

#[cfg(test)]
mod tests;
