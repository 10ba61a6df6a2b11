//! What knowing the error costs: the host's share of a render's time, and the memory.
//!
//! Timed is all that the host does while a render runs, beside the device: summing blocks, their squares and odd blocks, the ledger, the
//! estimates on the way and the last one. What the error needs is a part of that: the share is an upper bound of what it costs.

use std::cell::Cell;
use std::ops::Range;
use std::time::Instant;

use serde::Serialize;

use crate::error::Error;
use crate::film::Film;
use crate::film::aov::Aovs;
use crate::film::dd::Dd;
use crate::film::source::{DeviceInfo, PassStats, SampleSource};
use crate::film::spans::Span;
use crate::metric::estimate;
use crate::render::{self, Stops};

/// Bytes a pixel that the squares of block sums and the sums of odd blocks take in the film, out of `Film::BYTES_A_PIXEL`.
pub const ERROR_BYTES: usize = size_of::<[Dd; 3]>() + size_of::<[f64; 3]>();
/// Bytes a pixel while an estimate is made: means with two variances, scales, and the terms of three measures.
pub const PASSING_BYTES: usize = size_of::<[[f64; 3]; 4]>() + 3 * size_of::<f64>();

#[derive(Clone, Debug, Serialize)]
pub struct Row {
    pub bench: &'static str,
    pub scene: String,
    pub width: u32,
    pub height: u32,
    pub spp: u64,
    pub seconds: f64,
    /// Time beside the device over all time.
    pub host_share: f64,
    /// Estimates made, and the time of one.
    pub estimates: u32,
    pub estimate_s: f64,
    /// Of all time.
    pub estimate_share: f64,
    pub film_bytes_a_pixel: usize,
    pub error_bytes_a_pixel: usize,
    pub passing_bytes_a_pixel: usize,
}

/// A source that knows how long its device was at work.
struct Clocked<'a> {
    inner: &'a mut dyn SampleSource,
    device_s: f64,
}

impl SampleSource for Clocked<'_> {
    fn resolution(&self) -> (u32, u32) {
        self.inner.resolution()
    }
    fn aovs(&self) -> Aovs {
        self.inner.aovs()
    }
    fn render_blocks(
        &mut self,
        blocks: Range<u64>,
        film: &mut Film,
        stop: &dyn Fn() -> bool,
    ) -> Result<PassStats, Error> {
        let stats = self.inner.render_blocks(blocks, film, stop)?;
        self.device_s += stats.device_time_s;
        Ok(stats)
    }
    fn render_spans(&mut self, spans: &[Span], film: &mut Film, stop: &dyn Fn() -> bool) -> Result<PassStats, Error> {
        let stats = self.inner.render_spans(spans, film, stop)?;
        self.device_s += stats.device_time_s;
        Ok(stats)
    }
    fn describe(&self) -> DeviceInfo {
        self.inner.describe()
    }
}

/// A render of `seconds`, kernel warm.
pub fn measure(scene: &str, source: &mut dyn SampleSource, seconds: f64) -> Result<Row, Error> {
    let (width, height) = source.resolution();
    source.render_blocks(0..1, &mut Film::new(width, height, source.aovs(), 0), &|| false)?;
    let mut clocked = Clocked { inner: source, device_s: 0.0 };
    let stops = Stops { blocks: None, time_s: Some(seconds), error: None, started: Instant::now() };
    let (last, count) = (Cell::new(None), Cell::new(1));
    let mut observe = |p: &render::Progress| {
        let value = p.error.map(|e| e.relmse.value);
        if value.is_some() && value != last.replace(value) {
            count.set(count.get() + 1);
        }
    };
    let begun = Instant::now();
    let outcome = render::render(&mut clocked, &stops, &|| false, &mut observe)?;
    let all_s = begun.elapsed().as_secs_f64();
    let estimate_s = {
        let begun = Instant::now();
        std::hint::black_box(estimate::from_film(&outcome.film));
        begun.elapsed().as_secs_f64()
    };
    Ok(Row {
        bench: "estimate",
        scene: scene.to_owned(),
        width,
        height,
        spp: outcome.film.spp(),
        seconds: all_s,
        host_share: (1.0 - clocked.device_s / all_s).max(0.0),
        estimates: count.get(),
        estimate_s,
        estimate_share: f64::from(count.get()) * estimate_s / all_s,
        film_bytes_a_pixel: Film::BYTES_A_PIXEL,
        error_bytes_a_pixel: ERROR_BYTES,
        passing_bytes_a_pixel: PASSING_BYTES,
    })
}

pub fn markdown(rows: &[Row]) -> String {
    let mut text = String::from(
        "| scene | size | s | host's share of the time | estimates | of them | bytes a pixel: film, of it for the error, passing |\n|---|---|---|---|---|---|---|\n",
    );
    for r in rows {
        text += &format!(
            "| {} | {}x{} | {:.1} | {:.2} % | {} of {:.1} ms | {:.2} % | {}, {}, {} |\n",
            r.scene,
            r.width,
            r.height,
            r.seconds,
            100.0 * r.host_share,
            r.estimates,
            1e3 * r.estimate_s,
            100.0 * r.estimate_share,
            r.film_bytes_a_pixel,
            r.error_bytes_a_pixel,
            r.passing_bytes_a_pixel
        );
    }
    text
}

pub fn csv(rows: &[Row]) -> String {
    let mut text = String::from("scene,width,height,spp,seconds,host_share,estimates,estimate_s,estimate_share\n");
    for r in rows {
        text += &format!(
            "{},{},{},{},{:.3},{:.5},{},{:.5},{:.5}\n",
            r.scene, r.width, r.height, r.spp, r.seconds, r.host_share, r.estimates, r.estimate_s, r.estimate_share
        );
    }
    text
}
