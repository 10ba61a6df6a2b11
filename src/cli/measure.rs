//! `measure SCENE`: the scene's sensors as numbers with intervals and units.

use std::path::PathBuf;

use steradian::film::slot::BLOCK_SAMPLES;
use steradian::integrator::{Estimator, SamplerKind};
use steradian::measure::{self, Reading, Stops};
use steradian::scene::{self, Scene};

use super::interrupt::Interrupt;
use super::scene_args::{SkyArgs, TransportArgs};
use super::{Exit, say};

#[derive(clap::Args)]
pub struct Args {
    /// Scene file with [[sensor]]: .toml
    scene: PathBuf,
    /// Only the sensor of this name; may be given several times
    #[arg(long, value_name = "NAME")]
    sensor: Vec<String>,
    /// One JSON object a sensor and line; fields in docs/measure.md
    #[arg(long)]
    json: bool,
    /// Samples of each of the 32 repetitions, rounded up to whole blocks of 16 [default: 2048, or what --error needs]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    spp: Option<u32>,
    /// Stops when half the luminous value's interval is below this part of the value
    #[arg(long, value_name = "E", value_parser = super::parse_positive, allow_hyphen_values = true)]
    error: Option<f64>,
    /// auto, cpu, an index of `steradian devices`, or part of a name
    #[arg(long, value_name = "D", default_value = "auto")]
    device: String,
    #[command(flatten)]
    transport: TransportArgs,
    #[command(flatten)]
    sky: SkyArgs,
    #[command(flatten)]
    kernel: super::source::KernelArgs,
}

/// A line of the JSON: the reading, and what it was made with.
#[derive(serde::Serialize)]
struct Line<'a> {
    scene: String,
    #[serde(flatten)]
    reading: &'a Reading,
    seed: u32,
    estimator: Estimator,
    sampler: SamplerKind,
    max_depth: u32,
    device: String,
    device_kind: String,
    driver: String,
}

pub fn run(args: &Args) -> anyhow::Result<Exit> {
    let interrupt = Interrupt::install()?;
    let mut scene = scene::format::load(&args.scene)?;
    let sensors = chosen(args, &scene)?;
    args.sky.apply(&mut scene)?;
    scene::ensure_light(&mut scene);
    scene.notes.iter().for_each(say);
    let settings = args.transport.settings(&scene);
    let stops = Stops { blocks: blocks(args), error: args.error };
    let mut readings = Vec::new();
    let mut last_device = String::new();
    for (number, sensor) in sensors.iter().enumerate() {
        let area_m2 = sensor.area_m2(&scene);
        measure::place(&mut scene, sensor, measure::REPETITIONS);
        let options =
            super::source::Options { device: &args.device, kernel: args.kernel.options(), ..Default::default() };
        let mut opened = super::source::open(&scene, &settings, &options)
            .map_err(|e| anyhow::anyhow!("{}: sensor \"{}\": {e}", args.scene.display(), sensor.name))?;
        if number == 0 {
            opened.notes.iter().for_each(say);
        }
        let source = opened.source.as_mut();
        let Some(reading) = measure::read(source, sensor, area_m2, &stops, &|| interrupt.is_set())? else { break };
        let device = source.describe();
        report(&reading, args.error);
        if args.json {
            let line = Line {
                scene: args.scene.display().to_string(),
                reading: &reading,
                seed: settings.seed,
                estimator: settings.estimator,
                sampler: settings.sampler,
                max_depth: settings.max_depth,
                device: device.name.clone(),
                device_kind: device.kind.clone(),
                driver: device.driver.clone(),
            };
            println!("{}", serde_json::to_string(&line)?);
        }
        last_device = device.name;
        readings.push(reading);
        if interrupt.is_set() {
            break;
        }
    }
    if !args.json && !readings.is_empty() {
        print!("{}", measure::table(&readings));
        let samples: u64 = readings.iter().map(|r| r.samples).sum();
        let trace_s: f64 = readings.iter().map(|r| r.trace_s).sum();
        println!(
            "95 % intervals by Student's t over {} independent repetitions; {samples} samples in {trace_s:.2} s on {last_device}",
            measure::REPETITIONS
        );
    }
    Ok(if interrupt.is_set() { Exit::Interrupted } else { Exit::Done })
}

/// The sensors that are asked for, in the scene's order.
fn chosen(args: &Args, scene: &Scene) -> anyhow::Result<Vec<scene::Sensor>> {
    let path = args.scene.display();
    anyhow::ensure!(
        !scene.sensors.is_empty(),
        "{path}: the scene has no sensors; add [[sensor]] to it, see docs/measure.md"
    );
    let names = || scene.sensors.iter().map(|s| s.name.as_str());
    for wanted in &args.sensor {
        if !names().any(|n| n == wanted) {
            anyhow::bail!("{path}: no sensor is named \"{wanted}\"; {}", scene::format::toml::nearest(wanted, names()));
        }
    }
    let is_wanted = |s: &&scene::Sensor| args.sensor.is_empty() || args.sensor.contains(&s.name);
    Ok(scene.sensors.iter().filter(is_wanted).cloned().collect())
}

fn blocks(args: &Args) -> u64 {
    let spp = match (args.spp, args.error) {
        (Some(spp), _) => u64::from(spp),
        (None, Some(_)) => measure::MOST_SPP,
        (None, None) => measure::DEFAULT_SPP,
    };
    let blocks = spp.div_ceil(u64::from(BLOCK_SAMPLES));
    if args.spp.is_some() && blocks * u64::from(BLOCK_SAMPLES) != spp {
        say(format_args!(
            "{spp} samples are rounded up to {}: whole blocks of {BLOCK_SAMPLES}",
            blocks * u64::from(BLOCK_SAMPLES)
        ));
    }
    blocks
}

/// What should be known of a reading beside its number.
fn report(reading: &Reading, error: Option<f64>) {
    if let (Some(error), Some(false)) = (error, reading.error_met) {
        say(format_args!("sensor \"{}\": --error {error} is not met after {} samples", reading.name, reading.samples));
    }
    if reading.bad_samples > 0 {
        say(format_args!(
            "sensor \"{}\": {} samples were NaN, infinite or negative",
            reading.name, reading.bad_samples
        ));
    }
    if reading.cut_paths > 0 {
        say(format_args!("sensor \"{}\": {} paths were cut at the depth limit", reading.name, reading.cut_paths));
    }
}
