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
    /// Processors that the process had while it rendered, median; a busy machine gives fewer than it has.
    pub cores: Option<f64>,
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

    fn round(&mut self, blocks: u64) -> Result<Round, Error> {
        let mut film = Film::new(self.width, self.height, self.renderer.aovs(), 0);
        let before = process_cpu_s();
        let pass = self.renderer.render_blocks(0..blocks, &mut film, &|| false)?;
        let cpu_s = process_cpu_s().zip(before).map(|(after, before)| after - before);
        Ok(Round { seconds: pass.device_time_s, cpu_s, rays: pass.rays as f64 })
    }

    /// After a first round that holds the driver's compilation: blocks of a round of `ROUND_S`.
    fn blocks(&mut self) -> Result<u64, Error> {
        self.round(1)?;
        Ok(((ROUND_S / self.round(1)?.seconds.max(1e-4)) as u64).max(1))
    }
}

struct Round {
    /// On the device, by the clock.
    seconds: f64,
    /// Of all threads of this process, which a software device's are; None where the system does not tell.
    cpu_s: Option<f64>,
    rays: f64,
}

/// Time that the process has had on processors, seconds, in steps of 10 ms (Linux: fields 14 and 15 of /proc/self/stat).
fn process_cpu_s() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/self/stat").ok()?;
    // The name in parentheses may hold spaces.
    let fields: Vec<&str> = text.rsplit(')').next()?.split_ascii_whitespace().collect();
    let ticks: u64 = fields.get(11)?.parse::<u64>().ok()? + fields.get(12)?.parse::<u64>().ok()?;
    Some(ticks as f64 / 100.0)
}

/// The kernel as it is beside one whose text is changed, in alternating rounds.
#[derive(Clone, Debug, Serialize)]
pub struct Comparison {
    pub bench: &'static str,
    pub scene: String,
    /// Median of the rounds' own quotients: time of the kernel as it is over that of the changed one. Above 1 the change is faster.
    pub ratio: f64,
    pub ratio_range: [f64; 2],
    /// The same of the time that the process had on processors, which does not count what others took.
    pub ratio_cpu: Option<f64>,
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
    let (mut ratios, mut of_cpu) = (Vec::new(), Vec::new());
    for _ in 0..rounds {
        let (own, changed) = (own.round(blocks)?, changed.round(blocks)?);
        ratios.push(own.seconds / changed.seconds);
        of_cpu.extend(own.cpu_s.zip(changed.cpu_s).map(|(own, changed)| own / changed));
    }
    let ratio_cpu = (of_cpu.len() == rounds).then(|| median(of_cpu));
    let ratio_range =
        [ratios.iter().copied().fold(f64::INFINITY, f64::min), ratios.iter().copied().fold(0.0, f64::max)];
    Ok(Comparison { bench: "try", scene: scene.name.clone(), ratio: median(ratios), ratio_range, ratio_cpu, rounds })
}

pub fn measure(device: &Device, scene: &Scene, settings: &Settings, rounds: usize) -> Result<Row, Error> {
    let prepared = prepare::prepare(scene, settings).map_err(|e| Error::Scene(format!("{}: {e}", scene.name)))?;
    let mut timed = Timed::new(device, &prepared, settings, Vec::new())?;
    let samples = |blocks: u64| (blocks * 16) as f64 * f64::from(prepared.width) * f64::from(prepared.height);
    let blocks = timed.blocks()?;
    let mut rates = Vec::new();
    let mut rays = Vec::new();
    let mut cores = Vec::new();
    for _ in 0..rounds {
        let round = timed.round(blocks)?;
        rates.push(samples(blocks) / round.seconds * 1e-6);
        rays.push(round.rays / round.seconds * 1e-6);
        cores.extend(round.cpu_s.map(|cpu_s| cpu_s / round.seconds));
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
        cores: (cores.len() == rounds).then(|| median(cores)),
        rounds,
    })
}

impl Row {
    pub fn text(&self) -> String {
        let cores = self.cores.map_or(String::new(), |c| format!(" with {c:.2} cores"));
        format!(
            "{}: {:.3} Msamples/s [{:.3}, {:.3}], {:.2} Mrays/s on {}{cores} ({}x{}, {} rounds)",
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
