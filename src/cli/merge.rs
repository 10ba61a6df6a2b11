//! `merge PARTS... -o F`: adds ranges of samples up to the picture of one run.

use std::path::PathBuf;
use std::time::Instant;

use steradian::film::slot::BLOCK_SAMPLES;
use steradian::metric::estimate;
use steradian::output::{self, part, record};

use super::{Exit, files, say};

#[derive(clap::Args)]
pub struct Args {
    /// Files of `render -o X.part` or --checkpoint, in any order
    #[arg(required = true, value_name = "PARTS")]
    parts: Vec<PathBuf>,
    /// File to write, by extension .exr, .png, .hdr, or .part to merge further; may be given several times
    #[arg(short, long, required = true, value_name = "FILE")]
    output: Vec<PathBuf>,
    /// Writes the record of all parts together as JSON
    #[arg(long, value_name = "FILE")]
    record: Option<PathBuf>,
}

pub fn run(args: &Args) -> anyhow::Result<Exit> {
    let begun = Instant::now();
    for path in &args.output {
        files::check_output(path)?;
    }
    if let Some(path) = &args.record {
        output::check(path)?;
    }
    let read = args.parts.iter().map(PathBuf::as_path);
    files::no_file_twice(read, args.output.iter().chain(&args.record).map(PathBuf::as_path))?;
    let mut whole = part::merge(&args.parts)?;
    let film = &whole.film;
    let notes_before = whole.header.record.notes.len();
    if film.first_block() > 0 {
        let first = whole.header.first_sample();
        whole.header.record.notes.push(format!("the parts begin at sample {first}: none before it is in the picture"));
    }
    if !film.is_adaptive() && film.min_block_count() < film.max_block_count() {
        whole
            .header
            .record
            .notes
            .push("the last part was interrupted: some pixels have fewer samples than others".into());
    }
    if let Some(wanted) = whole.header.wanted_blocks
        && film.blocks_done() < wanted
    {
        let [done, wanted] = [film.blocks_done(), wanted].map(|blocks| blocks * u64::from(BLOCK_SAMPLES));
        let note = format!("the last part is not finished: {done} of {wanted} samples a pixel are there");
        whole.header.record.notes.push(note);
    }
    let error = estimate::from_film(film);
    let record = &mut whole.header.record;
    record.set_error(error.as_ref());
    record.notes.iter().skip(notes_before).for_each(say);
    record.command = std::env::args().collect::<Vec<_>>().join(" ");
    record.film_bytes = film.bytes() as u64;
    record.spp = film.spp();
    record.set_rates(film.sample_count(), film.ray_count());
    record.ledger = film.ledger().clone();
    record.peak_host_bytes = record.peak_host_bytes.max(record::peak_host_bytes());
    record.wall_s += begun.elapsed().as_secs_f64();
    let record = whole.header.record.clone();
    let (parts, pictures): (Vec<_>, Vec<_>) = args.output.iter().cloned().partition(|path| part::is_part(path));
    let written = files::write_outputs(&parts, &pictures, film, &whole.header);
    let recorded = args.record.as_ref().map_or(Ok(()), |path| record.write(path));
    files::first_failure([written, recorded])?;
    println!("{} parts: {}", args.parts.len(), record.summary());
    args.output.iter().for_each(|path| println!("wrote {}", path.display()));
    Ok(Exit::Done)
}
