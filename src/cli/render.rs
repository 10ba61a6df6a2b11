//! `render SCENE`: from a scene to files, with the run's record.

use std::path::{Path, PathBuf};
use std::time::Instant;

use steradian::error::Error;
use steradian::film::Film;
use steradian::film::aov::{Aovs, GROUPS, Names};
use steradian::film::slot::BLOCK_SAMPLES;
use steradian::film::source::DeviceInfo;
use steradian::gpu::renderer::KernelOptions;
use steradian::integrator::Settings;
use steradian::output::look::{Look, Tonemap};
use steradian::output::part::{self, Header, Identity};
use steradian::output::record::{self, Record, Stages};
use steradian::output::{self, Format};
use steradian::render::bands::{Part, Totals};
use steradian::render::{self, Outcome, StoppedBy, Stops};
use steradian::scene::{self, Scene};

use super::bands;
use super::interrupt::Interrupt;
use super::progress::Bar;
use super::scene_args::SceneArgs;
use super::{Exit, files, keep, say};

/// Samples a pixel when neither flags nor scene say when to stop.
const DEFAULT_SPP: u32 = 256;

#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    scene: SceneArgs,
    /// File to write, by extension .exr, .png, .hdr, or .part for samples to merge; may be given several times [default: SCENE's
    /// name as .png]
    #[arg(short, long, value_name = "FILE")]
    output: Vec<PathBuf>,
    /// Samples a pixel, rounded up to whole blocks of 16
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    spp: Option<u32>,
    /// Seconds since the start of the program; with --spp, whichever comes first
    #[arg(long, value_name = "S", value_parser = super::parse_positive)]
    time: Option<f64>,
    /// Stops when relMSE, independent of exposure, is at most this by the upper end of the render's own 95 % interval; not while that
    /// interval's tails are too heavy to trust it
    #[arg(long, value_name = "E", value_parser = super::parse_positive)]
    error: Option<f64>,
    /// auto, cpu, an index of `steradian devices`, or part of a name
    #[arg(long, value_name = "D", default_value = "auto")]
    device: String,
    #[command(flatten)]
    kernel: super::source::KernelArgs,
    /// Stops of exposure for .png, besides what the scene's shutter, ISO and f-number say
    #[arg(long, value_name = "EV", allow_negative_numbers = true, value_parser = super::parse_finite)]
    exposure: Option<f64>,
    /// How .png files show what is brighter than white: clipped, or by Khronos PBR Neutral [default: none]
    #[arg(long, value_name = "T")]
    tonemap: Option<Tonemap>,
    /// Finishes the image band by band, top to bottom, in little memory; ends by --spp only
    #[arg(long)]
    tiled: bool,
    /// Most bytes of memory to use, with K, M or G; an image whose film does not fit is finished band by band
    #[arg(long, value_name = "B", value_parser = super::parse_bytes)]
    max_memory: Option<u64>,
    /// What an .exr holds beside radiance: names with commas, all or none [default: albedo,normal,depth,variance,samples]
    #[arg(long, value_name = "LIST", value_parser = Aovs::parse)]
    aov: Option<Aovs>,
    /// Takes more samples where the error is; --spp is then their mean
    #[arg(long, conflicts_with_all = ["tiled", "max_memory"])]
    adaptive: bool,
    #[command(flatten)]
    keep: keep::KeepArgs,
    /// Writes the run's record as JSON
    #[arg(long, value_name = "FILE")]
    record: Option<PathBuf>,
}

pub fn run(args: &Args, started: Instant) -> anyhow::Result<Exit> {
    let outputs = if args.output.is_empty() { vec![default_output(&args.scene.scene)] } else { args.output.clone() };
    for path in &outputs {
        check_output(path)?;
    }
    if let Some(path) = &args.record {
        output::check(path)?;
    }
    let of_scene = [Some(args.scene.scene.as_path()), args.scene.sky.env.as_deref()];
    // A checkpoint may take the place of the one that was read.
    let other = args.keep.resume.as_deref().filter(|_| args.keep.checkpoint.is_some());
    let checkpoint = args.keep.place().filter(|path| other.is_none_or(|from| files::place(from) != files::place(path)));
    let written = outputs.iter().chain(&args.record).map(PathBuf::as_path).chain(checkpoint);
    files::no_file_twice(of_scene.into_iter().chain([other]).flatten(), written)?;
    let resumed = args.keep.resumed()?;
    let (parts, outputs): (Vec<_>, Vec<_>) = outputs.into_iter().partition(|path| part::is_part(path));
    let keeps = args.keep.is_used() || !parts.is_empty();
    anyhow::ensure!(
        !(args.adaptive && args.keep.samples.is_some()),
        "--adaptive: how many samples a pixel gets follows from those before, so that no range stands alone: leave out --samples, or --adaptive"
    );
    let interrupt = Interrupt::install_for_render()?;
    let mut seconds = Stages::default();

    // Load and resolve.
    let begun = Instant::now();
    let scene = args.scene.load()?;
    let has = |format| outputs.iter().any(|path| Format::of(path).is_ok_and(|f| f == format));
    let has_part = !parts.is_empty() || args.keep.place().is_some();
    for (flag, is_given) in [("--exposure", args.exposure.is_some()), ("--tonemap", args.tonemap.is_some())] {
        anyhow::ensure!(
            !is_given || has(Format::Png) || has_part,
            "{flag} is for .png files, and none is written; others hold radiance"
        );
    }
    let aovs = match (&args.aov, &resumed) {
        (Some(chosen), _) if has(Format::Exr) || has_part || *chosen == Aovs::NONE => *chosen,
        (Some(_), _) => anyhow::bail!("--aov is for .exr files, and none is written"),
        (None, Some(header)) => header.aovs().unwrap_or_default(),
        (None, None) if has(Format::Exr) || !parts.is_empty() => Aovs::usual(),
        (None, None) => Aovs::NONE,
    };
    // A kernel with everything in it makes every layer, and the scene's tables must have what they show. More groups than slots hold are left out.
    let aovs = match args.kernel.everything() {
        true => Aovs::ALL.of_scene(&scene).unwrap_or(Aovs::ALL.without(GROUPS)),
        false => aovs.of_scene(&scene).map_err(anyhow::Error::msg)?,
    };
    let of_film = scene.film.shutter.map_or(0.0, |s| s.exposure_ev());
    let look = Look { exposure_ev: args.exposure.unwrap_or(0.0) + of_film, tonemap: args.tonemap.unwrap_or_default() };
    let window = scene.film.window();
    let in_bands = args.tiled || args.max_memory.is_some();
    if !in_bands {
        Film::check_memory(window.width, window.height, aovs)?;
    }
    let settings = args.scene.settings(&scene, aovs);
    seconds.load = begun.elapsed().as_secs_f64();
    let mut notes = scene.notes.clone();
    let (first_block, range) = args.keep.range(resumed.as_ref(), args.spp)?;
    anyhow::ensure!(
        resumed.is_none() || range.is_some() || args.spp.is_some() || args.time.or(args.error).is_some(),
        "{}: begun with --time or --error and no number of samples to go on to: give --spp, --time or --error",
        args.keep.name()
    );
    let mut stops = stops(args, &scene, range, started, &mut notes);
    stops.time_s = stops.time_s.map(|t| (t - closing_s(window.pixel_count(), &outputs, aovs)).max(0.0));

    // Trace.
    let kernel = KernelOptions { by_list: args.adaptive, ..args.kernel.options() };
    let options = super::source::Options { device: &args.device, kernel, fingerprint: keeps };
    let opened = super::source::open(&scene, &settings, &options)?;
    let mut source = opened.source;
    seconds.bvh = opened.bvh_s;
    seconds.load += opened.prepare_s;
    notes.extend(opened.notes);
    notes.extend(source.describe().notes);
    // Where the specialised kernel does not compile, one with everything in it takes its place.
    let kept = source.aovs();
    if (kept != aovs || args.kernel.everything())
        && let Some(before) = resumed.as_ref().and_then(Header::aovs).filter(|before| *before != kept)
    {
        anyhow::bail!(
            "{}: begun with --aov {}, and a kernel with everything in it keeps every layer; leave out --everything, or render anew without --resume",
            args.keep.name(),
            before.list()
        );
    }
    if kept != aovs && !in_bands {
        Film::check_memory(window.width, window.height, kept)?;
    }
    let names = names(&scene, opened.origin);
    let whole = (scene.film.width, scene.film.height);
    let said = std::env::args().chain(notes.iter().cloned()).map(|text| text.len() + 1).sum();
    let subject = output::bands::Subject { window, whole, aovs: kept, names: &names, look, said };
    let whole_only = "checkpoints, parts and ranges keep the whole film: leave out --tiled, or give more --max-memory";
    anyhow::ensure!(!(args.tiled && keeps), whole_only);
    let rows = if in_bands {
        bands::rows(
            args.tiled,
            args.max_memory,
            args.time.or(args.error),
            &outputs,
            &subject,
            source.as_ref(),
            &mut notes,
        )?
    } else {
        None
    };
    anyhow::ensure!(rows.is_none() || !keeps, whole_only);
    let mut device = source.describe();
    (seconds.compile, seconds.upload) = (device.compile_s, device.upload_s);
    let begun_totals = Totals::of_film(&Film::new(0, 0, kept, 0), None, 0.0, StoppedBy::Interrupt);
    let record = make_record(args, &scene.film, &settings, &begun_totals, &device, seconds, Vec::new());
    let identity = Identity::new(&scene, opened.fingerprint, &Settings { aovs: kept, ..settings }, &device);
    // A run that ends by time or error leaves the target as it was.
    let wanted_blocks = stops.blocks.or(range);
    let mut header = Header { identity, window, first_block, wanted_blocks, look, names: names.clone(), record };
    let (film, earlier) = args.keep.film(&header, args.adaptive, &mut notes)?.unzip();
    if let (Some(film), Some(wanted)) = (&film, stops.blocks)
        && film.spp() / u64::from(BLOCK_SAMPLES) >= wanted
    {
        notes.push("it has as many samples as are asked for: none is rendered".into());
    }
    if first_block > 0 && !outputs.is_empty() {
        let first = first_block * u64::from(BLOCK_SAMPLES);
        notes.push(format!("the pictures hold samples from {first} on and none before"));
    }
    notes.iter().for_each(say);
    let bar = Bar::new();
    let poll = || interrupt.poll();
    let (totals, pictures) = match rows {
        Some(rows) => {
            let mut observe = |p: &render::Progress| bar.update(p);
            let mut pictures = output::bands::Bands::begin(&outputs, &subject)?;
            let mut take = |part: Part| match part {
                Part::Rows(mut film) => {
                    film.set_names(names.clone());
                    pictures.write(&film)
                }
                Part::Blank(mut row, count) => {
                    row.set_names(names.clone());
                    pictures.write_blank(&row, count)
                }
            };
            let totals =
                render::bands::render_bands(source.as_mut(), window, rows, &stops, &poll, &mut observe, &mut take)?;
            (totals, Pictures::Begun(pictures))
        }
        None => {
            let mut film = film.unwrap_or_else(|| {
                let mut film = Film::over(window, kept, first_block);
                if args.adaptive {
                    film.begin_adaptive();
                }
                film
            });
            film.set_names(names.clone());
            header.record.notes = notes.clone();
            if let Some(earlier) = &earlier {
                header.record.add_run(earlier);
            }
            let mut keeper = keep::Keeper::begin(&args.keep, &header, started);
            let mut is_said = false;
            let mut observe = |p: &render::Progress, film: &Film| {
                bar.update(p);
                if p.waits_for_tails() && !std::mem::replace(&mut is_said, true) {
                    say(
                        "--error: the estimate is low enough, and its tails are too heavy to trust it: the render goes on",
                    );
                }
                keeper.iter_mut().for_each(|keeper| keeper.tick(film));
                Ok(())
            };
            let outcome = render::render_film(source.as_mut(), film, &stops, &poll, &mut observe)?;
            (Totals::of(&outcome), Pictures::Film(Box::new(outcome)))
        }
    };
    bar.finish();
    if totals.samples == 0 {
        say("interrupted before the first samples: nothing is written");
        return Ok(Exit::Interrupted);
    }
    if totals.min_block_count == 0 {
        say("interrupted before every pixel had samples: those without are black");
    }

    // Write.
    device = source.describe();
    drop(source);
    (seconds.compile, seconds.upload, seconds.trace) = (device.compile_s, device.upload_s, totals.trace_s);
    let mut record = make_record(args, &scene.film, &settings, &totals, &device, seconds, notes);
    let earlier_s = earlier.as_ref().map_or(0.0, |e| e.wall_s);
    if let Some(earlier) = &earlier {
        record.add_run(earlier);
        record.set_rates(totals.samples, totals.rays);
    }
    record.wall_s = earlier_s + started.elapsed().as_secs_f64();
    let begun = Instant::now();
    let written: Vec<PathBuf>;
    let result = match pictures {
        Pictures::Begun(pictures) => {
            written = outputs;
            pictures.finish(&record)
        }
        Pictures::Film(outcome) => {
            let kept = args.keep.place().map(Path::to_owned);
            let parts: Vec<PathBuf> = kept.into_iter().chain(parts).collect();
            header.record = record.clone();
            let result = write_outputs(&parts, &outputs, &outcome.film, &header);
            written = [parts, outputs].concat();
            result
        }
    };
    record.seconds.write += begun.elapsed().as_secs_f64();
    record.wall_s = earlier_s + started.elapsed().as_secs_f64();
    record.peak_host_bytes = record::peak_host_bytes();
    if let Some(limit) = args.max_memory.filter(|limit| record.peak_host_bytes > *limit) {
        say(format_args!(
            "{} MiB were in use at most, more than --max-memory of {} MiB",
            record.peak_host_bytes >> 20,
            limit >> 20
        ));
    }
    first_failure([result, args.record.as_ref().map_or(Ok(()), |path| record.write(path))])?;
    println!("{}", record.summary());
    written.iter().for_each(|path| println!("wrote {}", path.display()));
    if totals.stopped_by != StoppedBy::Interrupt {
        return Ok(Exit::Done);
    }
    if let Some(path) = args.keep.place() {
        say(format_args!("go on with --resume {}", path.display()));
    }
    Ok(Exit::Interrupted)
}

/// What is left to write when the samples are taken.
enum Pictures {
    /// Rows are in their files.
    Begun(output::bands::Bands),
    Film(Box<Outcome>),
}

/// Names behind the numbers of the id AOVs.
fn names(scene: &Scene, origin: glam::DVec3) -> Names {
    let objects = scene.instances.iter().map(|i| i.name.clone()).collect();
    let materials = scene.materials.iter().map(|m| m.name.clone()).collect();
    Names { objects, materials, groups: scene.light_groups(), origin }
}

/// Fails where an output could not be written, or its extension is none that is known.
pub fn check_output(path: &Path) -> Result<(), Error> {
    if part::is_part(path) {
        return part::check(path);
    }
    Format::of(path).map_err(|_| Error::file(path, "not a known format: use .exr, .png, .hdr or .part"))?;
    output::check(path)
}

/// Writes the parts, then the pictures. One that fails does not keep the others from being written: the first error is returned,
/// further ones are said.
pub fn write_outputs(parts: &[PathBuf], pictures: &[PathBuf], film: &Film, header: &Header) -> Result<(), Error> {
    let parts = parts.iter().map(|path| part::write(path, header, film));
    let pictures = pictures.iter().map(|path| output::write_picture(path, film, &header.record, header.look));
    first_failure(parts.chain(pictures))
}

/// The first error; further ones are said. All results are taken.
pub fn first_failure(results: impl IntoIterator<Item = Result<(), Error>>) -> Result<(), Error> {
    let mut failures = results.into_iter().filter_map(Result::err);
    let first = failures.next();
    failures.for_each(say);
    first.map_or(Ok(()), Err)
}

/// Seconds that the last estimate of the error and the files will take, kept back from `--time`. Nanoseconds a pixel on one 2 GHz core, no
/// promise: an image of 640x480 takes a tenth of a second.
fn closing_s(pixel_count: usize, outputs: &[PathBuf], aovs: Aovs) -> f64 {
    let of_format = |path: &PathBuf| match Format::of(path) {
        Ok(Format::Exr) if aovs != Aovs::NONE => 400.0,
        Ok(_) => 80.0,
        Err(_) => 0.0,
    };
    pixel_count as f64 * 1e-9 * (150.0 + outputs.iter().map(of_format).sum::<f64>())
}

/// `helmet.png` for `models/helmet.gltf`, in the current folder.
fn default_output(scene: &Path) -> PathBuf {
    PathBuf::from(scene.file_stem().unwrap_or("render".as_ref())).with_extension("png")
}

/// Flags first, then the range of --samples or of what is gone on from; with none of them the scene's spp, else 256.
fn stops(args: &Args, scene: &Scene, range: Option<u64>, started: Instant, notes: &mut Vec<String>) -> Stops {
    let spp = match (args.spp, args.time.or(args.error)) {
        (None, None) if range.is_some() => return Stops { blocks: range, time_s: None, error: None, started },
        (None, None) => Some(scene.film.spp.unwrap_or(DEFAULT_SPP)),
        (spp, _) => spp,
    };
    let blocks = spp.map(|n| render::blocks_for(n as u64));
    if let (Some(spp), Some(blocks)) = (spp, blocks) {
        let rounded = blocks * BLOCK_SAMPLES as u64;
        if rounded != spp as u64 {
            notes.push(format!("{spp} samples a pixel are rounded up to {rounded}: whole blocks of {BLOCK_SAMPLES}"));
        }
    }
    Stops { blocks, time_s: args.time, error: args.error, started }
}

fn make_record(
    args: &Args,
    film_of_scene: &scene::Film,
    settings: &Settings,
    totals: &Totals,
    device: &DeviceInfo,
    seconds: Stages,
    mut notes: Vec<String>,
) -> Record {
    if totals.is_heavy_tailed {
        notes.push(record::HEAVY_TAILS.into());
        say(record::HEAVY_TAILS);
    }
    let mut record = Record {
        program: concat!("steradian ", env!("CARGO_PKG_VERSION")).into(),
        command: std::env::args().collect::<Vec<_>>().join(" "),
        scene: args.scene.scene.display().to_string(),
        width: film_of_scene.width,
        height: film_of_scene.height,
        crop: film_of_scene.crop,
        filter: Some(film_of_scene.filter),
        seed: settings.seed,
        integrator: keyword(settings.integrator),
        estimator: keyword(settings.estimator),
        sampler: keyword(settings.sampler),
        max_depth: settings.max_depth,
        spp: match totals.spread {
            Some(_) => totals.samples / film_of_scene.window().pixel_count() as u64,
            None => u64::from(totals.min_block_count * BLOCK_SAMPLES),
        },
        adaptive: totals.spread,
        stopped_by: totals.stopped_by.name().into(),
        wall_s: 0.0,
        seconds,
        relmse_est: totals.error,
        relmse_est_exposure: totals.whole.map(|e| e.relmse_exposure),
        relmse_est_heavy_tails: totals.is_heavy_tailed,
        relmse_est_trimmed: totals.whole.map(|e| e.relmse_trimmed),
        peak_host_bytes: record::peak_host_bytes(),
        peak_device_bytes: device.peak_bytes,
        film_bytes: totals.film_bytes as u64,
        device: device.name.clone(),
        device_kind: device.kind.clone(),
        driver: device.driver.clone(),
        kernel_hash: device.kernel_hash.clone(),
        ledger: totals.ledger.clone(),
        notes,
        ..Record::default()
    };
    record.set_rates(totals.samples, totals.rays);
    record
}

/// The word that the command line knows a choice by.
fn keyword(value: impl clap::ValueEnum) -> String {
    value.to_possible_value().map_or(String::new(), |v| v.get_name().into())
}
