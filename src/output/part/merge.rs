//! Ranges of samples added up to the film of one run.

use std::ops::Range;
use std::path::{Path, PathBuf};

use super::{Difference, Header, Part, read, read_header};
use crate::error::Error;
use crate::film::slot::BLOCK_SAMPLES;
use crate::output::record::Record;

/// Reads parts in whatever order and adds them in that of their samples. Refused, with a sentence each: parts of different renders,
/// ranges that overlap, and ranges with samples missing between them. Only the last range may have pixels that differ in
/// samples, as an interrupt leaves them. One film and the next part are in memory at a time.
pub fn merge(paths: &[PathBuf]) -> Result<Part, Error> {
    let mut headers: Vec<(&Path, Header)> = Vec::new();
    for path in paths {
        headers.push((path, read_header(path)?));
    }
    headers.sort_by_key(|(_, header)| header.first_block);
    let Some((first, others)) = headers.split_first() else {
        return Err(Error::Usage("no parts to merge".into()));
    };
    for other in others {
        same_render(first, other)?;
    }
    // Counts of an adaptive render depend on what was seen.
    if let Some((path, _)) = headers.iter().find(|(_, h)| h.record.adaptive.is_some() && headers.len() > 1) {
        let message = "its samples were placed by what they showed, so it is no range that others could follow";
        return Err(Error::file(path, message));
    }
    let mut whole = read(first.0)?;
    for (path, _) in others {
        add(&mut whole, read(path)?)?;
        whole.path = path.to_path_buf();
    }
    Ok(whole)
}

fn same_render((first, ours): &(&Path, Header), (path, theirs): &(&Path, Header)) -> Result<(), Error> {
    let first = first.display();
    let said = match ours.difference(theirs) {
        None => return Ok(()),
        Some(Difference::Scene) => format!("its scene ({}) is not that of {first}", theirs.record.scene),
        Some(Difference::Value { what, ours, theirs }) => {
            format!("its {what} is {theirs}, and that of {first} is {ours}")
        }
    };
    Err(Error::file(path, format!("{said}; only parts of one render are merged")))
}

/// Adds `next` behind `whole`, whose `path` is that of the part before.
fn add(whole: &mut Part, next: Part) -> Result<(), Error> {
    let (before, after) = (samples(whole), samples(&next));
    let name = whole.path.display();
    let range = |r: &Range<u64>| format!("{}..{}", r.start, r.end);
    if after.start < before.end {
        let message = format!(
            "its samples {} overlap those of {name}, {}; leave one out, or render it anew with --samples {}..B",
            range(&after),
            range(&before),
            before.end
        );
        return Err(Error::file(&next.path, message));
    }
    let least = before.start + u64::from(whole.film.min_block_count() * BLOCK_SAMPLES);
    if least < before.end {
        let message = format!(
            "interrupted: some pixels end at sample {least}, others at {}; finish it with `render --resume` before {} follows",
            before.end,
            next.path.display()
        );
        return Err(Error::file(&whole.path, message));
    }
    if after.start > before.end {
        let gap = range(&(before.end..after.start));
        let message =
            format!("samples {gap} are missing between {name} and it; render them with --samples {gap} -o X.part");
        return Err(Error::file(&next.path, message));
    }
    whole.film.add_film(&next.film);
    let wanted = next.header.wanted_blocks.map(|n| next.header.first_block - whole.header.first_block + n);
    whole.header.wanted_blocks = wanted;
    add_record(&mut whole.header.record, &next.header.record);
    Ok(())
}

/// From the first sample to the end of the furthest pixel.
fn samples(part: &Part) -> Range<u64> {
    let first = part.header.first_sample();
    first..first + u64::from(part.film.max_block_count() * BLOCK_SAMPLES)
}

fn add_record(ours: &mut Record, next: &Record) {
    let note = |(what, a, b): (&str, &str, &str)| {
        format!("parts of {what} {a} and {what} {b} are added: not to the bit what either makes alone")
    };
    let notes: Vec<String> = ours.other_device(next).map(note).collect();
    ours.notes.extend(notes);
    ours.stopped_by = next.stopped_by.clone();
    ours.add_run(next);
}
