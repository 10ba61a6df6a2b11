//! Images larger than memory: a band of rows takes all its samples, is handed on and forgotten, then the next.
//!
//! Each pixel has the very samples that it has in one film, so that the pictures are equal bit for bit. There is no progress over the
//! whole image: such a render ends by samples a pixel, and an interrupt leaves the bands below without any.

use std::time::Instant;

use super::{Outcome, Progress, StoppedBy, Stops, render_window};
use crate::error::Error;
use crate::film::adaptive::Spread;
use crate::film::ledger::Ledger;
use crate::film::source::SampleSource;
use crate::film::{Film, Tile};
use crate::metric::estimate::{Banded, Estimate, FilmError};

/// What is known of a render when its film is gone.
#[derive(Clone, Debug)]
pub struct Totals {
    pub samples: u64,
    pub rays: u64,
    pub ledger: Ledger,
    /// Fewest blocks of any pixel.
    pub min_block_count: u32,
    /// Largest film held at one time.
    pub film_bytes: usize,
    /// Estimated relMSE of the image.
    pub error: Option<Estimate>,
    /// The interval of that is not to be trusted: `FilmError::is_heavy_tailed`.
    pub is_heavy_tailed: bool,
    /// All that is known of the error, where the film was whole: the other measures need the image's mean and its worst pixels.
    pub whole: Option<FilmError>,
    /// Of an adaptive render.
    pub spread: Option<Spread>,
    pub trace_s: f64,
    pub stopped_by: StoppedBy,
}

impl Totals {
    pub fn of(outcome: &Outcome) -> Self {
        Self::of_film(&outcome.film, outcome.error, outcome.trace_s, outcome.stopped_by)
    }

    /// Of a film that is traced for `trace_s` seconds so far.
    pub fn of_film(film: &Film, error: Option<FilmError>, trace_s: f64, stopped_by: StoppedBy) -> Self {
        Self {
            spread: film.spread(),
            samples: film.sample_count(),
            rays: film.ray_count(),
            ledger: film.ledger().clone(),
            min_block_count: film.min_block_count(),
            film_bytes: film.bytes(),
            error: error.map(|e| e.relmse),
            is_heavy_tailed: error.is_some_and(|e| e.is_heavy_tailed),
            whole: error,
            trace_s,
            stopped_by,
        }
    }
}

/// What comes next of a picture, from top to bottom.
pub enum Part {
    Rows(Film),
    /// So many rows without samples, the last: the film of one of them.
    Blank(Film, u32),
}

/// Renders `window` in bands of at most `rows` rows and gives each to `take`. `stops.blocks` must be there and is the only stop.
pub fn render_bands(
    source: &mut dyn SampleSource,
    window: Tile,
    rows: u32,
    stops: &Stops,
    interrupted: &dyn Fn() -> bool,
    observe: &mut dyn FnMut(&Progress),
    take: &mut dyn FnMut(Part) -> Result<(), Error>,
) -> Result<Totals, Error> {
    let begun = Instant::now();
    let mut totals = Totals {
        samples: 0,
        rays: 0,
        ledger: Ledger::default(),
        min_block_count: u32::MAX,
        film_bytes: 0,
        error: None,
        is_heavy_tailed: false,
        whole: None,
        spread: None,
        trace_s: 0.0,
        stopped_by: StoppedBy::Spp,
    };
    let mut error = Banded::new(window.pixel_count());
    let wanted = stops.blocks.unwrap_or(1);
    let mut y = window.y;
    let bottom = window.y + window.height;
    while y < bottom {
        let band = Tile { y, height: rows.min(bottom - y), ..window };
        if totals.stopped_by == StoppedBy::Interrupt {
            totals.min_block_count = 0;
            take(Part::Blank(Film::over(Tile { height: 1, ..band }, source.aovs(), 0), bottom - y))?;
            break;
        }
        // The bar moves by rows, and within a band by blocks.
        let (done, all) = (u64::from(y - window.y), u64::from(window.height));
        let mut over_all = |p: &Progress| {
            let blocks = (done * wanted + p.blocks_done * u64::from(band.height)) / all;
            observe(&Progress { blocks_done: blocks, error: None, ..*p });
        };
        let outcome = render_window(source, band, stops, interrupted, &mut over_all)?;
        totals.stopped_by = outcome.stopped_by;
        let film = outcome.film;
        error.add(&film);
        totals.samples += film.sample_count();
        totals.rays += film.ray_count();
        totals.ledger.join(film.ledger());
        totals.min_block_count = totals.min_block_count.min(film.min_block_count());
        totals.film_bytes = totals.film_bytes.max(film.bytes());
        take(Part::Rows(film))?;
        y += band.height;
    }
    if let Some((estimate, is_heavy_tailed)) = error.estimate() {
        (totals.error, totals.is_heavy_tailed) = (Some(estimate), is_heavy_tailed);
    }
    totals.trace_s = begun.elapsed().as_secs_f64();
    Ok(totals)
}

/// Rows of a band whose film takes at most `bytes`; None when one row does not fit.
pub fn rows_within(bytes: u64, window: Tile, source: &dyn SampleSource) -> Option<u32> {
    let a_row = u64::from(window.width) * Film::bytes_a_pixel(source.aovs()) as u64;
    let rows = (bytes / a_row.max(1)).min(u64::from(window.height)) as u32;
    (rows > 0).then_some(rows)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::aov::Aovs;
    use crate::integrator::Settings;
    use crate::reference::independent::Independent;
    use crate::reference::{render, scenes};
    use crate::render::render_window;

    #[test]
    fn bands_hold_what_the_whole_film_holds() {
        let scene = scenes::cornell(11);
        let settings = Settings { aovs: Aovs::usual(), ..Settings::default() };
        let mut source = render::Renderer::new(Independent::new(&scene), settings);
        let stops = Stops { blocks: Some(3), time_s: None, error: None, started: Instant::now() };
        let window = Tile { x: 1, y: 2, width: 9, height: 8 };
        let whole = render_window(&mut source, window, &stops, &|| false, &mut |_| {}).unwrap();
        let mut means: Vec<[f32; 3]> = Vec::new();
        let mut fractions = Vec::new();
        let mut take = |part: Part| {
            if let Part::Rows(film) = part {
                means.extend(film.mean_f32());
            }
            Ok(())
        };
        let mut observe = |p: &Progress| fractions.push(p.fraction());
        let totals = render_bands(&mut source, window, 3, &stops, &|| false, &mut observe, &mut take).unwrap();
        assert_eq!(means, whole.film.mean_f32());
        assert_eq!((totals.samples, totals.rays), (whole.film.sample_count(), whole.film.ray_count()));
        assert_eq!((totals.min_block_count, totals.film_bytes), (3, 27 * Film::bytes_a_pixel(Aovs::usual())));
        assert!(fractions.windows(2).all(|w| w[0] <= w[1]) && fractions.last() == Some(&1.0), "{fractions:?}");
        // Interrupted after the first band: one film of it, and the rest in one.
        let polls = std::cell::Cell::new(0);
        let interrupted = || polls.replace(polls.get() + 1) >= 4;
        let mut parts = Vec::new();
        let mut take = |part: Part| {
            parts.push(match part {
                Part::Rows(film) => (film.height(), film.sample_count() > 0),
                Part::Blank(film, rows) => (rows, film.sample_count() > 0),
            });
            Ok(())
        };
        let ended = render_bands(&mut source, window, 2, &stops, &interrupted, &mut |_| {}, &mut take).unwrap();
        assert_eq!((ended.stopped_by, ended.min_block_count), (StoppedBy::Interrupt, 0));
        assert_eq!(parts.iter().map(|p| p.0).sum::<u32>(), 8, "{parts:?}");
        assert!(parts[0].1 && !parts.last().unwrap().1 && parts.len() <= 3, "{parts:?}");
        // The scale of a pixel's error looks at its neighbours, which a band's edge cuts off.
        let (a, b) = (totals.error.unwrap(), whole.error.unwrap().relmse);
        assert!((a.value / b.value - 1.0).abs() < 0.2 && a.low <= a.value && a.value <= a.high, "{a:?} {b:?}");
    }
}
