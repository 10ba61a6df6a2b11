//! `converge SCENE...`: error against run time, as curves with bands: one folder with a page, plots, table and every snapshot.

use std::path::{Path, PathBuf};

use steradian::error::Error;
use steradian::film::Film;
use steradian::film::aov::Aovs;
use steradian::film::source::SampleSource;
use steradian::gpu::renderer::KernelOptions;
use steradian::integrator::{SamplerKind, Settings};
use steradian::output;
use steradian::report::converge::reference::{self, Reference};
use steradian::report::converge::{self, Plan, Study, Variant, curves};
use steradian::report::provenance::Provenance;
use steradian::report::replicates;
use steradian::scene::{self, Scene};

use super::interrupt::Interrupt;
use super::scene_args::replace_sky;
use super::source::{self, Options};
use super::{Exit, say};

#[derive(clap::Args)]
pub struct Args {
    /// Scene files
    #[arg(required = true, value_name = "SCENE")]
    scenes: Vec<PathBuf>,
    /// Folder for the page, plots, table and references
    #[arg(short, long = "output", value_name = "DIR")]
    output: PathBuf,
    /// Reference picture; else one is rendered, and kept in DIR/references
    #[arg(long, value_name = "FILE")]
    reference: Option<PathBuf>,
    /// Samples a pixel of a rendered reference [default: 32 times what the fastest variant takes in the budget]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(32..), conflicts_with = "reference")]
    reference_spp: Option<u64>,
    /// Variants: words joined by +, such as mis+independent, bsdf, mis+adaptive, mis+everything, mis+cpu
    #[arg(long, value_name = "V,V...", value_delimiter = ',', default_value = "mis,mis+independent,bsdf,light")]
    variants: Vec<String>,
    /// Seconds of a run, set-up included
    #[arg(long, value_name = "S", default_value_t = 5.0, value_parser = super::parse_positive)]
    budget: f64,
    /// Replicates of each variant, with seeds of their own
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=1000))]
    repeats: u32,
    /// Seed of the first replicate
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u32,
    /// Image size in pixels; else each scene's
    #[arg(long, value_name = "WxH", value_parser = super::parse_size)]
    size: Option<(u32, u32)>,
    /// Image height in pixels, each scene in its own shape
    #[arg(long, value_name = "N", conflicts_with = "size", value_parser = clap::value_parser!(u32).range(1..=65536))]
    height: Option<u32>,
    /// Path edges [default: the scene's, else 4096]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=65535))]
    max_depth: Option<u32>,
    /// Sky instead of the scenes': a lat-long .hdr or .exr
    #[arg(long, value_name = "FILE")]
    env: Option<PathBuf>,
    /// auto, cpu, an index of `steradian devices`, or part of a name
    #[arg(long, value_name = "D", default_value = "auto")]
    device: String,
    /// The summary as one JSON object a scene and variant on stdout
    #[arg(long)]
    json: bool,
}

pub fn run(args: &Args) -> anyhow::Result<Exit> {
    let base = Settings::default();
    let variants: Vec<Variant> = (args.variants.iter())
        .map(|name| Variant::parse(name, &base).map_err(|e| anyhow::anyhow!("--variants: {e}")))
        .collect::<Result<_, _>>()?;
    let twice = (args.variants.iter().enumerate()).find(|(i, name)| args.variants[..*i].contains(name));
    anyhow::ensure!(twice.is_none(), "--variants: '{}' is there twice; leave one out", twice.map_or("", |(_, n)| n));
    anyhow::ensure!(
        args.reference.is_none() || args.scenes.len() == 1,
        "--reference is a picture of one scene, and {} are given; run them one by one",
        args.scenes.len()
    );
    let references = args.output.join("references");
    std::fs::create_dir_all(&references).map_err(|e| Error::io("create", &references, e))?;
    output::check(&args.output.join("index.html"))?;
    // All scenes are read before any time is spent.
    let scenes: Vec<Scene> = args.scenes.iter().map(|path| load(args, path)).collect::<anyhow::Result<_>>()?;
    for (k, scene) in scenes.iter().enumerate() {
        anyhow::ensure!(
            scenes[..k].iter().all(|other| other.name != scene.name),
            "two scenes are called {}, and so would be their plots: leave one out, or rename a file",
            scene.name
        );
    }
    let interrupt = Interrupt::install()?;
    let mut studies: Vec<Study> = Vec::new();
    for scene in &scenes {
        scene.notes.iter().for_each(say);
        studies.push(study(args, scene, &variants, &references, &interrupt)?);
        // Written after each scene, so that an interrupt loses at most the scene at hand.
        converge::write(&args.output, &studies, &Provenance::here())?;
        if interrupt.is_set() {
            break;
        }
    }
    for study in &studies {
        for s in curves::summaries(study) {
            if args.json {
                println!("{}", serde_json::json!({ "scene": study.scene, "summary": s }));
            } else {
                let end = &s.at_budget;
                let exponent =
                    s.exponent.map_or("-".into(), |e| format!("{:.2} [{:.2}, {:.2}]", e.value, e.low, e.high));
                println!(
                    "{:<16}{:<20}{:>8.2} s{:>8} spp  relMSE {:.3e} [{:.3e}, {:.3e}]  FLIP {:.4}  exponent {exponent}",
                    study.scene, s.variant, end.seconds, end.spp, end.relmse, end.relmse_low, end.relmse_high, end.flip
                );
            }
        }
    }
    say(format_args!("wrote {}", args.output.join("index.html").display()));
    Ok(if interrupt.is_set() { Exit::Interrupted } else { Exit::Done })
}

fn load(args: &Args, path: &Path) -> anyhow::Result<Scene> {
    let mut scene = scene::format::load(path)?;
    if let Some((width, height)) = args.size {
        (scene.film.width, scene.film.height) = (width, height);
    }
    if let Some(height) = args.height {
        scene = replicates::resized(&scene, height);
    }
    if let Some(env) = &args.env {
        replace_sky(&mut scene, env)?;
    }
    scene::frame_camera(&mut scene);
    scene::ensure_light(&mut scene);
    // Names of files in the folder.
    scene.name = path.file_stem().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
    Film::check_memory(scene.film.width, scene.film.height, Aovs::NONE)?;
    Ok(scene)
}

fn study(
    args: &Args,
    scene: &Scene,
    variants: &[Variant],
    references: &Path,
    interrupt: &Interrupt,
) -> anyhow::Result<Study> {
    let max_depth = args.max_depth.or(scene.film.max_depth).unwrap_or(Settings::default().max_depth);
    let open = |variant: &Variant, seed: u32| -> Result<Box<dyn SampleSource + '_>, Error> {
        let settings = Settings { seed, max_depth, ..variant.settings };
        let kernel =
            KernelOptions { everything: variant.everything, by_list: variant.adaptive, ..KernelOptions::default() };
        let device = variant.device.as_deref().unwrap_or(&args.device);
        let opened = source::open(scene, &settings, &Options { device, kernel, ..Options::default() });
        Ok(opened.map_err(|e| Error::Scene(format!("{}, {}: {e:#}", scene.name, variant.name)))?.source)
    };
    let reference = match &args.reference {
        Some(path) => Reference::read(path)?,
        None => own_reference(args, scene, &variants[0], references, &open, interrupt)?,
    };
    let (width, height) = (reference.picture.width, reference.picture.height);
    anyhow::ensure!(
        (width, height) == (scene.film.width, scene.film.height),
        "the reference {} is {width}x{height} and {} is {}x{}: give --size, or another reference",
        reference.source,
        scene.name,
        scene.film.width,
        scene.film.height
    );
    let plan = Plan { variants: variants.to_vec(), repeats: args.repeats, budget_s: args.budget, seed: args.seed };
    let observe = |v: &Variant, repeat: u32| {
        say(format_args!("{}: {} of {}, {}, {} s", scene.name, repeat + 1, args.repeats, v.name, args.budget));
    };
    Ok(converge::run(&scene.name, &plan, reference, &open, &|| interrupt.is_set(), &observe)?)
}

type Opening<'a> = dyn Fn(&Variant, u32) -> Result<Box<dyn SampleSource + 'a>, Error> + 'a;

/// The kept reference of this scene, size and depth, or a new one of enough samples: of independent samples, whose blocks know
/// their noise without a doubt.
fn own_reference(
    args: &Args,
    scene: &Scene,
    first: &Variant,
    references: &Path,
    open: &Opening,
    interrupt: &Interrupt,
) -> anyhow::Result<Reference> {
    let max_depth = args.max_depth.or(scene.film.max_depth).unwrap_or(Settings::default().max_depth);
    let integrator = first.settings.integrator;
    // The file holds how well it is known.
    let aovs = Aovs::NONE.with("variance").with("samples");
    let settings = Settings { sampler: SamplerKind::Independent, integrator, max_depth, aovs, ..Settings::default() };
    let device = first.device.clone();
    let variant = Variant { name: "reference".into(), settings, everything: false, adaptive: false, device };
    let pixels = u64::from(scene.film.width) * u64::from(scene.film.height);
    let mut source = open(&variant, reference::SEED)?;
    let blocks = match args.reference_spp {
        Some(spp) => steradian::render::blocks_for(spp),
        None => {
            // A pilot: one block with the driver's compilation in it, then half a second of blocks.
            let mut film = Film::new(scene.film.width, scene.film.height, source.aovs(), 0);
            source.render_blocks(0..1, &mut film, &|| false)?;
            let begun = std::time::Instant::now();
            let mut done = 0u64;
            while done == 0 || begun.elapsed().as_secs_f64() < 0.5 {
                source.render_blocks(1 + done..2 + done, &mut film, &|| false)?;
                done += 1;
            }
            let seconds_a_block = begun.elapsed().as_secs_f64() / done as f64;
            // The rate is measured on a machine that may be slow just now: a quarter more.
            (1.25 * reference::FACTOR * args.budget / seconds_a_block).ceil() as u64
        }
    };
    let fingerprint = reference::fingerprint(scene, &settings)?;
    let path = references.join(format!("{}-{fingerprint}.exr", scene.name));
    if path.exists() {
        let kept = Reference::read(&path)?;
        // A kept one of nearly as many samples will do: pilots differ.
        if kept.spp.is_some_and(|spp| spp as f64 >= 0.7 * (blocks * 16) as f64) {
            return Ok(kept);
        }
    }
    say(format_args!(
        "{}: reference of {} spp, {:.1} Msamples",
        scene.name,
        blocks * 16,
        (blocks * 16 * pixels) as f64 * 1e-6
    ));
    let bar = super::progress::Bar::new();
    let stops = steradian::render::Stops {
        blocks: Some(blocks),
        time_s: None,
        error: None,
        started: std::time::Instant::now(),
    };
    let outcome = steradian::render::render(source.as_mut(), &stops, &|| interrupt.is_set(), &mut |p| bar.update(p))?;
    bar.finish();
    anyhow::ensure!(!interrupt.is_set(), "interrupted while rendering the reference of {}", scene.name);
    output::write_picture(&path, &outcome.film, &output::record::Record::default(), 0.0)?;
    Ok(Reference::of_film(&outcome.film, path.display().to_string()))
}
