//! Whether a render goes band by band, and how many rows a band has.

use std::path::PathBuf;

use steradian::film::Film;
use steradian::film::source::SampleSource;
use steradian::output::bands::{Bands, Subject};
use steradian::output::record::resident_bytes;
use steradian::render::bands::rows_within;

/// Besides the film and lines on their way: a dispatch's slots as the device and the host hold them (32 MiB each), and what the
/// driver and the compiler take while they work.
const WORKING_BYTES: u64 = 128 << 20;
/// Film of a band when no limit is given.
const BAND_BYTES: u64 = 256 << 20;

/// Rows of a band; None when the whole film fits into `limit`. A note says what was chosen.
pub fn rows(
    is_asked: bool,
    limit: Option<u64>,
    other_stop: Option<f64>,
    outputs: &[PathBuf],
    subject: &Subject,
    source: &dyn SampleSource,
    notes: &mut Vec<String>,
) -> anyhow::Result<Option<u32>> {
    let (window, in_use) = (subject.window, resident_bytes());
    let mebibytes = |bytes: u64| bytes.div_ceil(1 << 20);
    let a_pixel = Film::bytes_a_pixel(source.aovs()) as u64;
    let film = window.pixel_count() as u64 * a_pixel;
    // Writing a whole film takes its channels once more; 2 is more than any choice of AOVs needs.
    if !is_asked && limit.is_some_and(|limit| in_use + WORKING_BYTES + 2 * film <= limit) {
        return Ok(None);
    }
    anyhow::ensure!(
        other_stop.is_none(),
        "a film in bands takes all samples of a band before the next one: give --spp instead of --time or --error"
    );
    let lines = Bands::bytes(outputs, subject) as u64;
    let taken = in_use + WORKING_BYTES + lines;
    let room = limit.map_or(BAND_BYTES, |limit| limit.saturating_sub(taken));
    let Some(rows) = rows_within(room, window, source) else {
        let least = taken + u64::from(window.width) * a_pixel;
        anyhow::bail!(
            "--max-memory: a row of {} pixels needs {} MiB beside the {} MiB in use; give {} MiB or more",
            window.width,
            mebibytes(least - in_use),
            mebibytes(in_use),
            mebibytes(least)
        );
    };
    let planned = taken + u64::from(rows) * u64::from(window.width) * a_pixel;
    notes.push(format!(
        "the film of {}x{} ({} MiB) is finished in {} bands of {rows} rows; {} MiB of memory are planned for",
        window.width,
        window.height,
        mebibytes(film),
        window.height.div_ceil(rows),
        mebibytes(planned)
    ));
    Ok(Some(rows))
}
