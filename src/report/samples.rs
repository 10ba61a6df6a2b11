//! Samples and rays a second of one scene, kernel warm: the figure that other renderers print.

use serde::Serialize;

use super::specialise::median;
use crate::error::Error;
use crate::film::Film;
use crate::film::source::SampleSource;
use crate::gpu::Device;
use crate::gpu::renderer::{KernelOptions, Renderer};
use crate::integrator::Settings;
use crate::prepare;
use crate::scene::Scene;

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

pub fn measure(device: &Device, scene: &Scene, settings: &Settings, rounds: usize) -> Result<Row, Error> {
    let prepared = prepare::prepare(scene, settings).map_err(|e| Error::Scene(format!("{}: {e}", scene.name)))?;
    let mut renderer = Renderer::new(device, &prepared, settings, &KernelOptions::default())?;
    let samples = |blocks: u64| (blocks * 16) as f64 * f64::from(prepared.width) * f64::from(prepared.height);
    let mut round = |blocks: u64| -> Result<(f64, f64), Error> {
        let mut film = Film::new(prepared.width, prepared.height, false, 0);
        let pass = renderer.render_blocks(0..blocks, &mut film, &|| false)?;
        Ok((pass.device_time_s, pass.rays as f64))
    };
    round(1)?;
    let blocks = ((ROUND_S / round(1)?.0.max(1e-4)) as u64).max(1);
    let mut rates = Vec::new();
    let mut rays = Vec::new();
    for _ in 0..rounds {
        let (seconds, count) = round(blocks)?;
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
