//! Samples and rays a second of one scene, kernel warm: the figure that other renderers print.

use serde::Serialize;

use super::specialise::median;
use crate::error::Error;
use crate::film::Film;
use crate::film::source::SampleSource;
use crate::gpu::Device;
use crate::gpu::renderer::{KernelOptions, Renderer};
use crate::integrator::Settings;
use crate::prepare::{self, Prepared};
use crate::scene::Scene;
use crate::shader::compile::Edit;

/// Median and range over rounds.
#[derive(Clone, Debug, Serialize)]
#[allow(non_snake_case)] // throughput_MSps and throughput_Mrays_ps are the field's names
pub struct Row {
    pub bench: &'static str,
    pub scene: String,
    pub device: String,
    pub width: u32,
    pub height: u32,
    pub throughput_MSps: f64,
    pub throughput_MSps_range: [f64; 2],
    pub throughput_Mrays_ps: f64,
    pub rounds: usize,
}

/// Seconds that a round takes about.
const ROUND_S: f64 = 1.0;

/// A scene on a device, ready to be timed.
struct Timed {
    renderer: Renderer,
    width: u32,
    height: u32,
}

impl Timed {
    fn new(device: &Device, prepared: &Prepared, settings: &Settings, edits: Vec<Edit>) -> Result<Self, Error> {
        let options = KernelOptions { edits, ..KernelOptions::default() };
        let renderer = Renderer::new(device, prepared, settings, &options)?;
        Ok(Self { renderer, width: prepared.width, height: prepared.height })
    }

    /// Seconds on the device, and rays.
    fn round(&mut self, blocks: u64) -> Result<(f64, f64), Error> {
        let mut film = Film::new(self.width, self.height, self.renderer.aovs(), 0);
        let pass = self.renderer.render_blocks(0..blocks, &mut film, &|| false)?;
        Ok((pass.device_time_s, pass.rays as f64))
    }

    /// After a first round that holds the driver's compilation: blocks of a round of `ROUND_S`.
    fn blocks(&mut self) -> Result<u64, Error> {
        self.round(1)?;
        Ok(((ROUND_S / self.round(1)?.0.max(1e-4)) as u64).max(1))
    }
}

/// The kernel as it is beside one whose text is changed, in alternating rounds.
#[derive(Clone, Debug, Serialize)]
pub struct Comparison {
    pub bench: &'static str,
    pub scene: String,
    /// Median of the rounds' own quotients: time of the kernel as it is over that of the changed one. Above 1 the change is faster.
    pub ratio: f64,
    pub ratio_range: [f64; 2],
    pub rounds: usize,
}

pub fn compare(
    device: &Device,
    scene: &Scene,
    settings: &Settings,
    rounds: usize,
    edits: Vec<Edit>,
) -> Result<Comparison, Error> {
    let prepared = prepare::prepare(scene, settings).map_err(|e| Error::Scene(format!("{}: {e}", scene.name)))?;
    let mut own = Timed::new(device, &prepared, settings, Vec::new())?;
    let mut changed = Timed::new(device, &prepared, settings, edits)?;
    let blocks = own.blocks()?;
    changed.blocks()?;
    let mut ratios = Vec::new();
    for _ in 0..rounds {
        let before = own.round(blocks)?.0;
        ratios.push(before / changed.round(blocks)?.0);
    }
    let ratio_range =
        [ratios.iter().copied().fold(f64::INFINITY, f64::min), ratios.iter().copied().fold(0.0, f64::max)];
    Ok(Comparison { bench: "try", scene: scene.name.clone(), ratio: median(ratios), ratio_range, rounds })
}

pub fn measure(device: &Device, scene: &Scene, settings: &Settings, rounds: usize) -> Result<Row, Error> {
    let prepared = prepare::prepare(scene, settings).map_err(|e| Error::Scene(format!("{}: {e}", scene.name)))?;
    let mut timed = Timed::new(device, &prepared, settings, Vec::new())?;
    let samples = |blocks: u64| (blocks * 16) as f64 * f64::from(prepared.width) * f64::from(prepared.height);
    let blocks = timed.blocks()?;
    let mut rates = Vec::new();
    let mut rays = Vec::new();
    for _ in 0..rounds {
        let (seconds, count) = timed.round(blocks)?;
        rates.push(samples(blocks) / seconds * 1e-6);
        rays.push(count / seconds * 1e-6);
    }
    let range = [rates.iter().copied().fold(f64::INFINITY, f64::min), rates.iter().copied().fold(0.0, f64::max)];
    Ok(Row {
        bench: "samples",
        scene: scene.name.clone(),
        device: device.info().name.clone(),
        width: prepared.width,
        height: prepared.height,
        throughput_MSps: median(rates),
        throughput_MSps_range: range,
        throughput_Mrays_ps: median(rays),
        rounds,
    })
}

impl Row {
    pub fn text(&self) -> String {
        format!(
            "{}: {:.3} Msamples/s [{:.3}, {:.3}], {:.2} Mrays/s on {} ({}x{}, {} rounds)",
            self.scene,
            self.throughput_MSps,
            self.throughput_MSps_range[0],
            self.throughput_MSps_range[1],
            self.throughput_Mrays_ps,
            self.device,
            self.width,
            self.height,
            self.rounds
        )
    }
}
