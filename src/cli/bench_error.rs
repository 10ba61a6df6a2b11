//! The benches of `bench` that ask how good the renderer's numbers are: coverage, exponents, mis-bound, estimate. Each prints a table, and
//! with `-o DIR` writes it there as CSV and Markdown, with what it was made by.

use std::path::Path;

use steradian::error::Error;
use steradian::film::slot::BLOCK_SAMPLES;
use steradian::film::source::DeviceInfo;
use steradian::gpu::Device;
use steradian::gpu::renderer::{KernelOptions, Renderer};
use steradian::integrator::{Estimator, SamplerKind};
use steradian::output::write_atomically;
use steradian::prepare;
use steradian::report::provenance::Provenance;
use steradian::report::replicates::{self, resized};
use steradian::report::{coverage, exponents, mis_bound, overhead};
use steradian::scene::{self, Scene, format::toml};

use super::bench::Args;
use super::say;

/// Names that run only when asked for by their whole name: they take minutes.
pub const NAMES: [&str; 4] = ["coverage", "exponents", "mis-bound", "estimate"];

macro_rules! embedded {
    ($name:literal) => {
        ($name, include_str!(concat!("../../scenes/", $name, ".toml")))
    };
}

type Text = (&'static str, &'static str);
const CORNELL: Text = embedded!("cornell");
const VEACH: Text = embedded!("veach");
const METALS: Text = embedded!("metals");
const CAUSTIC: Text = embedded!("caustic");
const DISC_LAMP: Text = embedded!("disc_lamp");
const SPHERE_LAMP: Text = embedded!("sphere_lamp");

/// Image heights, pixels.
const COVERAGE_HEIGHT: u32 = 48;
const EXPONENT_HEIGHT: u32 = 32;
const COVERAGE_SPP: u64 = 64;
const COVERAGE_SEEDS: u32 = 1000;
/// Groups of four replicates.
const EXPONENT_GROUPS: u32 = 8;
const EXPONENT_SPP: u64 = 4096;
const MIS_BLOCKS: u64 = 16;
const ESTIMATE_S: f64 = 10.0;

/// Runs the bench that `args.filter` names; false when a check did not hold.
pub fn run(args: &Args, device: &Device) -> anyhow::Result<bool> {
    match args.filter.as_str() {
        "coverage" => run_coverage(args, device),
        "exponents" => run_exponents(args, device),
        "mis-bound" => run_mis_bound(args, device),
        _ => run_estimate(args, device),
    }
}

/// The scenes that were named, else `texts`, named by their files.
fn scenes(args: &Args, texts: &[Text]) -> anyhow::Result<Vec<Scene>> {
    let mut list = Vec::new();
    for path in &args.scenes {
        let mut scene = scene::load(path)?;
        scene.name = path.file_stem().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
        list.push(scene);
    }
    if list.is_empty() {
        for (name, text) in texts {
            let mut scene = toml::parse(text, &Path::new("scenes").join(name).with_extension("toml"))?;
            scene.name = (*name).to_owned();
            list.push(scene);
        }
    }
    for scene in &mut list {
        scene::frame_camera(scene);
        scene::ensure_light(scene);
    }
    Ok(list)
}

/// Prints the table and writes it, and its data.
fn publish(
    args: &Args,
    name: &str,
    (device, seeds): (&DeviceInfo, &str),
    markdown: &str,
    csv: &str,
) -> anyhow::Result<()> {
    if !args.json {
        print!("{markdown}");
    }
    if let Some(folder) = &args.output {
        std::fs::create_dir_all(folder).map_err(|e| Error::io("create", folder, e))?;
        let table = format!("{name}.csv");
        let made = Provenance::here().markdown(device, seeds, &table);
        write_atomically(&folder.join(format!("{name}.md")), format!("{markdown}\n{made}").as_bytes())?;
        write_atomically(&folder.join(&table), csv.as_bytes())?;
    }
    Ok(())
}

fn run_coverage(args: &Args, device: &Device) -> anyhow::Result<bool> {
    let seeds = args.seeds.unwrap_or(COVERAGE_SEEDS);
    let mut rows = Vec::new();
    let mut info = DeviceInfo::default();
    for scene in scenes(args, &[CORNELL, VEACH, METALS, CAUSTIC])? {
        let small = resized(&scene, COVERAGE_HEIGHT);
        say(format_args!("{}: {seeds} seeds of each sampler", scene.name));
        let observe = |done: usize| {
            if done.is_multiple_of(250) {
                say(format_args!("{}: {done} renders", scene.name));
            }
        };
        let (found, of) = coverage::measure(device, &small, COVERAGE_SPP, seeds, &observe)?;
        info = of;
        for row in &found {
            if args.json {
                println!("{}", serde_json::to_string(row)?);
            }
        }
        rows.extend(found);
    }
    let seeds = format!("1 to {seeds}");
    publish(args, "coverage", (&info, &seeds), &coverage::markdown(&rows), &coverage::csv(&rows))?;
    Ok(true)
}

fn run_exponents(args: &Args, device: &Device) -> anyhow::Result<bool> {
    // A smooth integrand is one of the light sampling alone: a ray that may or may not hit a lamp is an edge.
    let all = [
        (DISC_LAMP, Estimator::Light),
        (SPHERE_LAMP, Estimator::Light),
        (CORNELL, Estimator::Mis),
        (VEACH, Estimator::Mis),
    ];
    let groups = args.seeds.map_or(EXPONENT_GROUPS, |seeds| seeds.div_ceil(4)).max(2);
    let mut rows = Vec::new();
    let mut info = DeviceInfo::default();
    let mut run_one = |scene: &Scene, estimator: Estimator| -> anyhow::Result<()> {
        for sampler in SamplerKind::ALL {
            say(format_args!("{}: {sampler:?}, {} replicates", scene.name, 4 * groups));
            let (row, of) =
                exponents::measure(device, &resized(scene, EXPONENT_HEIGHT), estimator, sampler, groups, EXPONENT_SPP)?;
            info = of;
            if args.json {
                println!("{}", serde_json::to_string(&row)?);
            }
            rows.push(row);
        }
        Ok(())
    };
    if args.scenes.is_empty() {
        for (text, estimator) in all {
            run_one(&scenes(args, &[text])?[0], estimator)?;
        }
    } else {
        for scene in scenes(args, &[])? {
            run_one(&scene, Estimator::Mis)?;
        }
    }
    let seeds = format!("1 to {}", 4 * groups);
    let table = format!("![relMSE against samples](exponents.svg)\n\n{}", exponents::markdown(&rows));
    publish(args, "exponents", (&info, &seeds), &table, &exponents::csv(&rows))?;
    if let Some(folder) = &args.output {
        let path = folder.join("exponents.svg");
        let foot = Provenance::here().lines(&info, &seeds, "exponents.csv");
        let drawn = exponents::svg(&rows, &foot);
        if let Some(svg) = drawn.map_err(|e| Error::file(&path, format!("cannot draw the plot: {e}")))? {
            write_atomically(&path, svg.as_bytes())?;
        }
    }
    Ok(true)
}

fn run_mis_bound(args: &Args, device: &Device) -> anyhow::Result<bool> {
    let rounds = u32::try_from(args.rounds()).unwrap_or(u32::MAX).max(2);
    let mut reports = Vec::new();
    let mut info = DeviceInfo::default();
    for scene in scenes(args, &[VEACH])? {
        say(format_args!(
            "{}: {rounds} rounds of {} spp of each technique",
            scene.name,
            MIS_BLOCKS * u64::from(BLOCK_SAMPLES)
        ));
        let (report, of) = mis_bound::measure(device, &scene, MIS_BLOCKS, rounds)?;
        info = of;
        if args.json {
            println!("{}", serde_json::to_string(&report)?);
        }
        reports.push(report);
    }
    let seeds = format!("1 to {rounds}");
    publish(args, "mis-bound", (&info, &seeds), &mis_bound::markdown(&reports), &mis_bound::csv(&reports))?;
    let holds = reports.iter().all(|report| report.holds);
    if !holds {
        say("mis-bound: a surface is outside the bound, or a single technique is better at equal time");
    }
    Ok(holds)
}

fn run_estimate(args: &Args, device: &Device) -> anyhow::Result<bool> {
    let mut rows = Vec::new();
    let mut info = DeviceInfo::default();
    for mut scene in scenes(args, &[CORNELL, VEACH, METALS])? {
        if args.scenes.is_empty() {
            (scene.film.width, scene.film.height) = (640, 480);
        }
        let settings = replicates::settings(&scene);
        let prepared = prepare::prepare(&scene, &settings)?;
        let mut renderer = Renderer::new(device, &prepared, &settings, &KernelOptions::default())?;
        say(format_args!("{}: {ESTIMATE_S} s", scene.name));
        let row = overhead::measure(&scene.name, &mut renderer, ESTIMATE_S)?;
        info = steradian::film::source::SampleSource::describe(&renderer);
        if args.json {
            println!("{}", serde_json::to_string(&row)?);
        }
        rows.push(row);
    }
    publish(args, "estimate", (&info, "0"), &overhead::markdown(&rows), &overhead::csv(&rows))?;
    Ok(true)
}
