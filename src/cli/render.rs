//! `render SCENE`: from a scene to files, with the run's record.

mod outputs;
mod record;

use std::path::{Path, PathBuf};
use std::time::Instant;

use steradian::error::Error;
use steradian::film::Film;
use steradian::film::aov::{Aovs, Names};
use steradian::film::slot::BLOCK_SAMPLES;
use steradian::film::source::SampleSource;
use steradian::gpu::renderer::KernelOptions;
use steradian::integrator::Settings;
use steradian::output::look::{Look, Tonemap};
use steradian::output::part::{Header, Identity};
use steradian::output::record::{HEAVY_TAILS, Stages, peak_host_bytes};
use steradian::output::{self, Format};
use steradian::render::bands::{Part, Totals};
use steradian::render::{self, Outcome, StoppedBy, Stops};
use steradian::scene::Scene;

use super::bands;
use super::interrupt::Interrupt;
use super::progress::Bar;
use super::scene_args::SceneArgs;
use super::{Exit, files, keep, say};
use outputs::Outputs;

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
    #[arg(long, value_name = "E", value_parser = super::parse_positive, allow_hyphen_values = true)]
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
    let outputs = Outputs::check(args)?;
    let interrupt = Interrupt::install_for_render()?;
    let mut seconds = Stages::default();

    // Load and resolve.
    let begun = Instant::now();
    let scene = args.scene.load()?;
    let aovs = outputs.layers(args, &scene)?;
    let of_film = scene.film.shutter.map_or(0.0, |s| s.exposure_ev());
    // As it was begun, where nothing else is said.
    let before = outputs.resumed.as_ref().map(|header| header.look);
    let look = Look {
        exposure_ev: args.exposure.map(|ev| ev + of_film).or(before.map(|l| l.exposure_ev)).unwrap_or(of_film),
        tonemap: args.tonemap.or(before.map(|l| l.tonemap)).unwrap_or_default(),
    };
    let window = scene.film.window();
    let in_bands = args.tiled || args.max_memory.is_some();
    if !in_bands {
        Film::check_memory(window.width, window.height, aovs)?;
    }
    let settings = args.scene.settings(&scene, aovs);
    seconds.load = begun.elapsed().as_secs_f64();
    let mut notes = scene.notes.clone();
    let (first_block, range) = args.keep.range(outputs.resumed.as_ref(), args.spp)?;
    anyhow::ensure!(
        outputs.resumed.is_none() || range.is_some() || args.spp.is_some() || args.time.or(args.error).is_some(),
        "{}: begun with --time or --error and no number of samples to go on to: give --spp, --time or --error",
        args.keep.name()
    );
    let mut stops = stops(args, &scene, range, started, &mut notes);
    stops.time_s = stops.time_s.map(|t| (t - closing_s(window.pixel_count(), &outputs, args, aovs)).max(0.0));

    // Trace.
    let kernel = KernelOptions { by_list: args.adaptive, ..args.kernel.options() };
    let options = super::source::Options { device: &args.device, kernel, fingerprint: outputs.keeps };
    let opened = super::source::open(&scene, &settings, &options)?;
    let mut source = opened.source;
    seconds.bvh = opened.bvh_s;
    seconds.load += opened.prepare_s;
    notes.extend(opened.notes);
    notes.extend(source.describe().notes);
    // Where the specialised kernel does not compile, one with everything in it takes its place.
    let kept = source.aovs();
    if (kept != aovs || args.kernel.everything())
        && let Some(before) = outputs.resumed.as_ref().and_then(Header::aovs).filter(|before| *before != kept)
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
    anyhow::ensure!(!(args.tiled && outputs.keeps), whole_only);
    let rows = if in_bands {
        bands::rows(
            args.tiled,
            args.max_memory,
            args.time.or(args.error),
            &outputs.pictures,
            &subject,
            source.as_ref(),
            &mut notes,
        )?
    } else {
        None
    };
    anyhow::ensure!(rows.is_none() || !outputs.keeps, whole_only);
    let mut device = source.describe();
    (seconds.compile, seconds.upload) = (device.compile_s, device.upload_s);
    let begun_totals = Totals::of_film(&Film::new(0, 0, kept, 0), None, 0.0, StoppedBy::Interrupt);
    let record = record::make(args, &scene.film, &settings, &begun_totals, &device, seconds, Vec::new());
    let identity = Identity::new(&scene, opened.fingerprint, &Settings { aovs: kept, ..settings }, &device);
    // A run that ends by time or error leaves the target as it was.
    let wanted_blocks = stops.blocks.or(range);
    let mut header = Header { identity, window, first_block, wanted_blocks, look, names: names.clone(), record };
    let (film, earlier) = args.keep.film(&header, args.adaptive, &mut notes)?.unzip();
    if let (Some(film), Some(wanted)) = (&film, stops.blocks)
        && film.blocks_done() >= wanted
    {
        notes.push("it has as many samples as are asked for: none is rendered".into());
    }
    if first_block > 0 && !outputs.pictures.is_empty() {
        let first = first_block * u64::from(BLOCK_SAMPLES);
        notes.push(format!("the pictures hold samples from {first} on and none before"));
    }
    notes.iter().for_each(say);
    let bar = Bar::new();
    let poll = || interrupt.poll();
    let (totals, pictures) = match rows {
        Some(rows) => {
            let pictures = output::bands::Bands::begin(&outputs.pictures, &subject)?;
            trace_bands(source.as_mut(), &subject, rows, pictures, &stops, &poll, &bar)?
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
            let keeper = keep::Keeper::begin(&args.keep, &header, started);
            trace_film(source.as_mut(), film, keeper, &stops, &poll, &bar)?
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
    // What came up on the way.
    let heavy = totals.is_heavy_tailed.then(|| HEAVY_TAILS.to_owned());
    for note in device.notes.iter().cloned().chain(heavy) {
        if !notes.contains(&note) {
            say(&note);
            notes.push(note);
        }
    }
    (seconds.compile, seconds.upload, seconds.trace) = (device.compile_s, device.upload_s, totals.trace_s);
    let mut record = record::make(args, &scene.film, &settings, &totals, &device, seconds, notes);
    let earlier_s = earlier.as_ref().map_or(0.0, |e| e.wall_s);
    if let Some(earlier) = &earlier {
        record.add_run(earlier);
        record.set_rates(totals.samples, totals.rays);
    }
    record.wall_s = earlier_s + started.elapsed().as_secs_f64();
    let begun = Instant::now();
    let Outputs { pictures: pictured, parts, .. } = outputs;
    let parts: Vec<PathBuf> = args.keep.place().map(Path::to_owned).into_iter().chain(parts).collect();
    let result = match pictures {
        Pictures::Begun(pictures) => pictures.finish(&record),
        Pictures::Film(outcome) => {
            header.record = record.clone();
            files::write_outputs(&parts, &pictured, &outcome.film, &header)
        }
    };
    record.seconds.write += begun.elapsed().as_secs_f64();
    record.wall_s = earlier_s + started.elapsed().as_secs_f64();
    record.peak_host_bytes = peak_host_bytes();
    if let Some(limit) = args.max_memory.filter(|limit| record.peak_host_bytes > *limit) {
        say(format_args!(
            "{} MiB were in use at most, more than --max-memory of {} MiB",
            record.peak_host_bytes >> 20,
            limit >> 20
        ));
    }
    files::first_failure([result, args.record.as_ref().map_or(Ok(()), |path| record.write(path))])?;
    println!("{}", record.summary());
    parts.iter().chain(&pictured).for_each(|path| println!("wrote {}", path.display()));
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

/// Band by band; each is written when it is done.
fn trace_bands(
    source: &mut dyn SampleSource,
    subject: &output::bands::Subject,
    rows: u32,
    mut pictures: output::bands::Bands,
    stops: &Stops,
    poll: &dyn Fn() -> bool,
    bar: &Bar,
) -> Result<(Totals, Pictures), Error> {
    let mut observe = |p: &render::Progress| bar.update(p);
    let mut take = |part: Part| match part {
        Part::Rows(mut film) => {
            film.set_names(subject.names.clone());
            pictures.write(&film)
        }
        Part::Blank(mut row, count) => {
            row.set_names(subject.names.clone());
            pictures.write_blank(&row, count)
        }
    };
    let totals = render::bands::render_bands(source, subject.window, rows, stops, poll, &mut observe, &mut take)?;
    Ok((totals, Pictures::Begun(pictures)))
}

/// The whole film at once, kept between passes where that is asked for.
fn trace_film(
    source: &mut dyn SampleSource,
    film: Film,
    mut keeper: Option<keep::Keeper>,
    stops: &Stops,
    poll: &dyn Fn() -> bool,
    bar: &Bar,
) -> Result<(Totals, Pictures), Error> {
    let mut is_said = false;
    let mut observe = |p: &render::Progress, film: &Film| {
        bar.update(p);
        if p.waits_for_tails() && !std::mem::replace(&mut is_said, true) {
            say("--error: the estimate is low enough, and its tails are too heavy to trust it: the render goes on");
        }
        keeper.iter_mut().for_each(|keeper| keeper.tick(film));
        Ok(())
    };
    let outcome = render::render_film(source, film, stops, poll, &mut observe)?;
    Ok((Totals::of(&outcome), Pictures::Film(Box::new(outcome))))
}

/// Names behind the numbers of the id AOVs.
fn names(scene: &Scene, origin: glam::DVec3) -> Names {
    let objects = scene.instances.iter().map(|i| i.name.clone()).collect();
    let materials = scene.materials.iter().map(|m| m.name.clone()).collect();
    Names { objects, materials, groups: scene.light_groups(), origin }
}

/// Seconds that the last estimate of the error and the files will take, kept back from `--time`. Nanoseconds a pixel on one 2 GHz core, and a
/// nanosecond a byte that is checked and brought to the disk; no promise: an image of 640x480 takes a tenth of a second.
fn closing_s(pixel_count: usize, outputs: &Outputs, args: &Args, aovs: Aovs) -> f64 {
    let of_format = |path: &PathBuf| match Format::of(path) {
        Ok(Format::Exr) if aovs != Aovs::NONE => 400.0,
        Ok(_) => 80.0,
        Err(_) => 0.0,
    };
    let parts = outputs.parts.len() + usize::from(args.keep.place().is_some());
    let of_parts = (parts * Film::bytes_a_pixel(aovs)) as f64;
    pixel_count as f64 * 1e-9 * (150.0 + of_parts + outputs.pictures.iter().map(of_format).sum::<f64>())
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
