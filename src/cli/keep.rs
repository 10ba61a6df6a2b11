//! Ranges of samples, checkpoints and going on from one: flags of `render`.

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::Instant;

use steradian::film::Film;
use steradian::film::slot::BLOCK_SAMPLES;
use steradian::film::store::MAX_BLOCKS;
use steradian::output::part::{self, Difference, Header};
use steradian::output::record::{self, Record};

use super::files::place;
use super::say;

const BLOCK: u64 = BLOCK_SAMPLES as u64;
/// Seconds between checkpoints.
const EVERY_S: f64 = 30.0;

#[derive(clap::Args)]
pub struct KeepArgs {
    /// Renders samples A to B of every pixel, B excluded, in whole blocks of 16; `-o X.part` keeps them for `merge`
    #[arg(long, value_name = "A..B", value_parser = parse_samples, allow_hyphen_values = true, conflicts_with_all = ["spp", "time", "error"])]
    pub samples: Option<Range<u64>>,
    /// Keeps the render in this file as it goes, to go on from with --resume
    #[arg(long, value_name = "FILE")]
    pub checkpoint: Option<PathBuf>,
    /// Seconds between checkpoints [default: 30]
    #[arg(long, value_name = "S", value_parser = super::parse_positive)]
    pub checkpoint_every: Option<f64>,
    /// Goes on from a checkpoint or part with the same scene and flags, and keeps it there unless --checkpoint names another file
    #[arg(long, value_name = "FILE")]
    pub resume: Option<PathBuf>,
}

impl KeepArgs {
    /// Where checkpoints go.
    pub fn place(&self) -> Option<&Path> {
        self.checkpoint.as_deref().or(self.resume.as_deref())
    }

    /// The file to go on from, for messages.
    pub fn name(&self) -> std::path::Display<'_> {
        self.resume.as_deref().unwrap_or(Path::new("")).display()
    }

    /// Some flag keeps the film or needs it whole.
    pub fn is_used(&self) -> bool {
        self.samples.is_some() || self.place().is_some()
    }

    /// What the file to go on from says. Refuses a checkpoint that would take the place of another render's.
    pub fn resumed(&self) -> anyhow::Result<Option<Header>> {
        anyhow::ensure!(
            self.checkpoint_every.is_none() || self.place().is_some(),
            "--checkpoint-every needs --checkpoint or --resume"
        );
        let header = self.resume.as_deref().map(part::read_header).transpose()?;
        if let Some(path) = self.place() {
            part::check(path)?;
            let is_own = self.resume.as_deref().is_some_and(|from| place(from) == place(path));
            anyhow::ensure!(
                is_own || !path.exists(),
                "{}: there already; go on from it with --resume, or remove it first",
                path.display()
            );
        }
        Ok(header)
    }

    /// First block and how many blocks are wanted of each pixel, when neither --spp, --time nor --error says so.
    pub fn range(&self, resumed: Option<&Header>, spp: Option<u32>) -> anyhow::Result<(u64, Option<u64>)> {
        let name = || self.name();
        match (&self.samples, resumed) {
            (Some(range), Some(header)) => {
                let first = header.first_sample();
                anyhow::ensure!(
                    range.start == first,
                    "{}: its samples begin at {first}, and --samples begins at {}; give --samples {first}..{} or another file",
                    name(),
                    range.start,
                    range.end.max(first + BLOCK)
                );
                Ok((header.first_block, Some((range.end - range.start) / BLOCK)))
            }
            (Some(range), None) => Ok((range.start / BLOCK, Some((range.end - range.start) / BLOCK))),
            (None, Some(header)) => {
                let first = header.first_sample();
                anyhow::ensure!(
                    first == 0 || spp.is_none(),
                    "{}: its samples begin at {first}; give --samples {first}..B in place of --spp",
                    name()
                );
                Ok((header.first_block, header.wanted_blocks))
            }
            (None, None) => Ok((0, None)),
        }
    }

    /// The film to go on from, if it is one of this very render.
    pub fn film(
        &self,
        ours: &Header,
        adaptive: bool,
        notes: &mut Vec<String>,
    ) -> anyhow::Result<Option<(Film, Record)>> {
        let Some(path) = &self.resume else { return Ok(None) };
        let part = part::read(path)?;
        let (name, theirs) = (path.display(), &part.header);
        let (with, now) = if adaptive { ("without", "it") } else { ("with", "none") };
        anyhow::ensure!(
            part.film.is_adaptive() == adaptive,
            "{name}: begun {with} --adaptive, and this render has {now}; give it the same, or render anew without --resume"
        );
        let said = match theirs.difference(ours) {
            None => None,
            Some(Difference::Scene) => Some(format!(
                "begun with {}, which is not the scene that {} is now",
                theirs.record.scene, ours.record.scene
            )),
            Some(Difference::Value { what, ours: file, theirs: now }) => {
                Some(format!("begun with {what} {file}, and this render has {now}"))
            }
        };
        if let Some(said) = said {
            anyhow::bail!("{name}: {said}; give it the same, or render anew without --resume");
        }
        for (what, before, now) in theirs.record.other_device(&ours.record) {
            notes.push(format!("{name} goes on with {what} {now} after {before}: not to the bit of one run"));
        }
        let spp = part.film.spp();
        notes.push(format!("goes on from {name} at {spp} samples a pixel; its seconds are counted in"));
        Ok(Some((part.film, part.header.record)))
    }
}

/// Writes checkpoints between passes.
pub struct Keeper {
    path: PathBuf,
    every_s: f64,
    /// As it was when tracing began.
    header: Header,
    /// Of the runs before this one.
    traced_s: f64,
    begun: Instant,
    started: Instant,
    last: Instant,
}

impl Keeper {
    /// One that writes to the flags' file, if they name one. `started` is the start of the process.
    pub fn begin(args: &KeepArgs, header: &Header, started: Instant) -> Option<Self> {
        let now = Instant::now();
        Some(Self {
            path: args.place()?.to_owned(),
            every_s: args.checkpoint_every.unwrap_or(EVERY_S),
            header: header.clone(),
            traced_s: header.record.seconds.trace,
            begun: now,
            started,
            last: now,
        })
    }

    /// Writes when it is time. A disk that is full now may have room later: the render goes on.
    pub fn tick(&mut self, film: &Film) {
        if self.last.elapsed().as_secs_f64() < self.every_s {
            return;
        }
        let mut header = self.header.clone();
        let record = &mut header.record;
        record.stopped_by = "checkpoint".into();
        record.seconds.trace = self.traced_s + self.begun.elapsed().as_secs_f64();
        record.wall_s += self.started.elapsed().as_secs_f64();
        record.peak_host_bytes = record.peak_host_bytes.max(record::peak_host_bytes());
        record.film_bytes = film.bytes() as u64;
        record.set_rates(film.sample_count(), film.ray_count());
        if let Err(error) = part::write(&self.path, &header, film) {
            say(format_args!("{error}; the render goes on, and the checkpoint before stays as it is"));
        }
        self.last = Instant::now();
    }
}

/// `A..B` in whole blocks of 16, A below B.
fn parse_samples(text: &str) -> Result<Range<u64>, String> {
    let bounds = text.split_once("..").and_then(|(a, b)| Some((a.trim().parse().ok()?, b.trim().parse().ok()?)));
    let Some((a, b)) = bounds else {
        return Err("write it as A..B, such as 0..256".into());
    };
    let limit = MAX_BLOCKS * BLOCK;
    if a >= b || b > limit {
        return Err(format!("A must be below B, and B at most {limit}"));
    }
    if a % BLOCK != 0 || b % BLOCK != 0 {
        let nearest = |n: u64| (n + BLOCK / 2) / BLOCK * BLOCK;
        let first = nearest(a);
        let end = nearest(b).max(first + BLOCK);
        return Err(format!("samples come in whole blocks of {BLOCK}, the nearest are {first}..{end}"));
    }
    Ok(a..b)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_are_whole_blocks() {
        assert_eq!(parse_samples("0..256"), Ok(0..256));
        assert_eq!(parse_samples("16 .. 32"), Ok(16..32));
        for (wrong, word) in [
            ("0..100", "0..96"),
            ("7..250", "0..256"),
            ("9..10", "16..32"),
            ("0..1", "0..16"),
            ("16..16", "below B"),
            ("32..16", "below B"),
            ("0..99999999999", "at most"),
            ("0-16", "A..B"),
            ("..16", "A..B"),
            ("-16..16", "A..B"),
        ] {
            let error = parse_samples(wrong).unwrap_err();
            assert!(error.contains(word), "{wrong}: {error}");
        }
    }
}
