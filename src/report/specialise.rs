//! What leaving things out gains: the same scene with its own kernel and with everything compiled in, in alternating rounds.
//!
//! Rates of a noisy machine are only comparable inside one run, so both kernels take turns (ABBA) and the medians of their rounds
//! are divided. The clock holds tracing alone; compile time is a column of its own, cold (without any cache of ours).

use serde::Serialize;

use crate::error::Error;
use crate::film::Film;
use crate::film::source::SampleSource;
use crate::gpu::Device;
use crate::gpu::renderer::{KernelOptions, Renderer};
use crate::integrator::Settings;
use crate::prepare;
use crate::scene::Scene;

/// One scene, both ways; `_all` is everything-on.
#[derive(Clone, Debug, Serialize)]
#[allow(non_snake_case)] // throughput_MSps is the field's name
pub struct Row {
    pub bench: &'static str,
    pub scene: String,
    pub device: String,
    pub spirv_words: usize,
    pub spirv_words_all: usize,
    pub compile_s: f64,
    pub compile_s_all: f64,
    /// The driver compiles at the first dispatch, unless its own cache knows the kernel.
    pub first_dispatch_s: f64,
    pub first_dispatch_s_all: f64,
    pub device_bytes: u64,
    pub device_bytes_all: u64,
    pub throughput_MSps: f64,
    pub throughput_MSps_all: f64,
    /// Median rate specialised over median rate everything-on.
    pub ratio: f64,
    pub rounds: usize,
}

/// Seconds that a round takes about.
const ROUND_S: f64 = 0.7;

/// Measures `scene` in `rounds` alternating rounds of each kernel.
pub fn measure(device: &Device, scene: &Scene, settings: &Settings, rounds: usize) -> Result<Row, Error> {
    let prepared = prepare::prepare(scene, settings).map_err(|e| Error::Scene(format!("{}: {e}", scene.name)))?;
    let make = |everything| {
        Renderer::new(device, &prepared, settings, &KernelOptions { everything, no_cache: true, ..Default::default() })
    };
    let mut kernels = [make(false)?, make(true)?];
    let mut blocks = 1;
    let mut rates: [Vec<f64>; 2] = Default::default();
    // The first round of each only warms up and sizes the rounds.
    let warm = run(&mut kernels[0], 1)?;
    run(&mut kernels[1], 1)?;
    let again = run(&mut kernels[0], 1)?.min(warm);
    blocks = blocks.max((ROUND_S / again.max(1e-4)) as u64);
    for round in 0..rounds {
        let order = if round % 2 == 0 { [0, 1] } else { [1, 0] };
        for k in order {
            let seconds = run(&mut kernels[k], blocks)?;
            rates[k].push((blocks * 16) as f64 * f64::from(prepared.width * prepared.height) / seconds * 1e-6);
        }
    }
    let [special, all] = rates.map(median);
    let bytes = |r: &Renderer| r.stats.table_bytes.iter().map(|(_, b)| *b).sum::<u64>();
    let [s, e] = &kernels;
    Ok(Row {
        bench: "specialise",
        scene: scene.name.clone(),
        device: device.info().name.clone(),
        spirv_words: s.stats.spirv_words,
        spirv_words_all: e.stats.spirv_words,
        compile_s: s.stats.compile_s,
        compile_s_all: e.stats.compile_s,
        first_dispatch_s: s.stats.first_dispatch_s,
        first_dispatch_s_all: e.stats.first_dispatch_s,
        device_bytes: bytes(s),
        device_bytes_all: bytes(e),
        throughput_MSps: special,
        throughput_MSps_all: all,
        ratio: special / all,
        rounds,
    })
}

/// Seconds on the device for `blocks` blocks of every pixel.
fn run(renderer: &mut Renderer, blocks: u64) -> Result<f64, Error> {
    let (width, height) = renderer.resolution();
    let mut film = Film::new(width, height, renderer.aovs(), 0);
    Ok(renderer.render_blocks(0..blocks, &mut film, &|| false)?.device_time_s)
}

/// Middle value; the mean of the middle two of an even count.
pub fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let n = values.len();
    if n == 0 { f64::NAN } else { 0.5 * (values[(n - 1) / 2] + values[n / 2]) }
}

impl Row {
    pub const HEAD: &'static str =
        "scene             SPIR-V words       compile s        first dispatch s   table KiB      Msamples/s      ratio
                  own      all     own     all     own     all     own     all     own     all";

    pub fn text(&self) -> String {
        format!(
            "{:<14}{:>8}{:>8}{:>8.2}{:>8.2}{:>9.2}{:>9.2}{:>8}{:>8}{:>9.3}{:>9.3}{:>8.2}",
            self.scene,
            self.spirv_words,
            self.spirv_words_all,
            self.compile_s,
            self.compile_s_all,
            self.first_dispatch_s,
            self.first_dispatch_s_all,
            self.device_bytes / 1024,
            self.device_bytes_all / 1024,
            self.throughput_MSps,
            self.throughput_MSps_all,
            self.ratio
        )
    }
}
