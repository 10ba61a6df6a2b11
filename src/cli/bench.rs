//! `bench`: rates of a device on generated scenes; JSON lines, or a table for people. What it says of the error is in `bench_error`.

use std::path::{Path, PathBuf};

use steradian::gpu::{self, Choice, Selected};
use steradian::integrator::Settings;
use steradian::reference::scenes;
use steradian::report::{bench_instances, bench_rays, samples, specialise};
use steradian::scene::{self, format::toml};
use steradian::shader::{compile::Edit, source};

use super::{Exit, bench_error, say};

#[derive(clap::Args)]
pub struct Args {
    /// Scene files for `samples`, at their own size and depth [default: the Cornell box of scenes/peer_a.toml], and for the benches of
    /// errors [default: scenes of the repository]
    #[arg(value_name = "SCENE")]
    pub scenes: Vec<PathBuf>,
    /// auto, an index of `steradian devices`, or part of a name
    #[arg(long, value_name = "D", default_value = "auto")]
    device: String,
    /// Only benches whose name contains this: build, rays, instances, samples, specialise; or one of coverage, exponents, mis-bound,
    /// estimate, which run only when named
    #[arg(long, value_name = "S", default_value = "")]
    pub filter: String,
    /// Alternating rounds of each measurement, but for coverage, exponents and estimate [default: 5]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    rounds: Option<u64>,
    /// For `samples`: shader files that replace those of the same path, timed beside the kernel as it is
    #[arg(long = "try", value_name = "DIR")]
    tried: Option<PathBuf>,
    /// For coverage and exponents: replicates [default: 1000, 32]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=1_000_000))]
    pub seeds: Option<u32>,
    /// For coverage, exponents, mis-bound, estimate: folder for their tables
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// One JSON object a line
    #[arg(long)]
    pub json: bool,
}

impl Args {
    pub fn rounds(&self) -> u64 {
        self.rounds.unwrap_or(5)
    }
}

const BENCHES: [&str; 5] = ["build", "rays", "instances", "samples", "specialise"];

/// Image side of the generated scenes, pixels.
const SIZE: u32 = 128;

/// The Cornell box that other renderers were timed on.
const PEER_A: &str = include_str!("../../scenes/peer_a.toml");

pub fn run(args: &Args) -> anyhow::Result<Exit> {
    let is_wanted = |name: &str| name.contains(&args.filter);
    let is_of_error = bench_error::NAMES.contains(&args.filter.as_str());
    anyhow::ensure!(
        is_of_error || BENCHES.into_iter().any(is_wanted),
        "--filter: no bench contains \"{}\"; there are {}, and by their whole names {}",
        args.filter,
        BENCHES.join(", "),
        bench_error::NAMES.join(", ")
    );
    anyhow::ensure!(
        is_of_error || (args.seeds.is_none() && args.output.is_none()),
        "--seeds and --output are for the benches {}; name one with --filter",
        bench_error::NAMES.join(", ")
    );
    anyhow::ensure!(
        (is_of_error && args.tried.is_none())
            || is_wanted("samples")
            || (args.scenes.is_empty() && args.tried.is_none()),
        "scene files and --try are for the bench `samples`, which --filter {} leaves out",
        args.filter
    );
    anyhow::ensure!(
        !is_of_error || args.rounds.is_none() || args.filter == "mis-bound",
        "--rounds: the bench {} has none; leave it out",
        args.filter
    );
    anyhow::ensure!(
        args.seeds.is_none() || ["coverage", "exponents"].contains(&args.filter.as_str()),
        "--seeds is for the benches coverage and exponents, and --filter is {}; leave it out",
        args.filter
    );
    let Selected::Vulkan(device) = gpu::select(&Choice::from(args.device.as_str()), &gpu::Options::default())? else {
        anyhow::bail!("bench measures Vulkan devices, and there is none: run ./x once, which installs software Vulkan");
    };
    if is_of_error {
        return Ok(if bench_error::run(args, &device)? { Exit::Done } else { Exit::CheckFailed });
    }
    let rounds = args.rounds() as usize;
    if is_wanted("build") {
        println!("{}", serde_json::to_string(&bench_rays::build(rounds))?);
    }
    if is_wanted("rays") {
        for row in bench_rays::rays(&device, rounds)? {
            println!("{}", serde_json::to_string(&row)?);
        }
    }
    if is_wanted("instances") {
        for row in bench_instances::run(&device, rounds)? {
            println!("{}", serde_json::to_string(&row)?);
        }
    }
    if is_wanted("samples") {
        let mut timed = args.scenes.iter().map(|path| scene::load(path)).collect::<Result<Vec<_>, _>>()?;
        if timed.is_empty() {
            timed.push(toml::parse(PEER_A, Path::new("scenes/peer_a.toml"))?);
        }
        for mut scene in timed {
            scene::frame_camera(&mut scene);
            scene::ensure_light(&mut scene);
            let settings = Settings { max_depth: scene.film.max_depth.unwrap_or(8), ..Settings::default() };
            if let Some(folder) = &args.tried {
                let row = samples::compare(&device, &scene, &settings, rounds, edits(folder)?)?;
                println!("{}", serde_json::to_string(&row)?);
                continue;
            }
            let row = samples::measure(&device, &scene, &settings, rounds)?;
            if args.json {
                println!("{}", serde_json::to_string(&row)?);
            } else {
                println!("{}", row.text());
            }
        }
    }
    if is_wanted("specialise") {
        if !args.json {
            println!("{}", specialise::Row::HEAD);
        }
        for scene in scenes::all(SIZE) {
            say(format_args!("{}: {rounds} rounds of both kernels", scene.name));
            let row = specialise::measure(&device, &scene, &Settings::default(), rounds)?;
            if args.json {
                println!("{}", serde_json::to_string(&row)?);
            } else {
                println!("{}", row.text());
            }
        }
    }
    Ok(Exit::Done)
}

/// Every embedded shader file that `folder` holds too, as a change of its whole text.
fn edits(folder: &Path) -> anyhow::Result<Vec<Edit>> {
    let mut edits = Vec::new();
    for file in source::paths() {
        let path = folder.join(file);
        if path.is_file() {
            let text = std::fs::read_to_string(&path)?;
            let from = source::get(file).expect("paths() lists what get() has");
            edits.push(Edit { file, from, to: text.leak() });
        }
    }
    if edits.is_empty() {
        anyhow::bail!("--try: {} holds no file of a path under shaders/, such as bvh/closest.glsl", folder.display());
    }
    Ok(edits)
}
