//! Part files: a film with all its accumulators, to go on from (a checkpoint) or to merge (a range of samples).
//!
//! Bytes: "STERPART", the format's version and the header's length (u64 each), the header (JSON, filled up to 8 bytes with spaces), the film
//! (`film::store`), a checksum of all before (128 bits). Little endian, not compressed: the noise of samples does not compress. A pixel
//! takes 124 bytes, 188 with the usual AOVs. A file is written beside its place, brought to the disk and renamed; it is read only when
//! its checksum is right, and then nothing in it is taken on trust either. Tests: tests.rs here, tests/cli/resume.rs.

mod identity;
mod merge;
mod seal;

use std::fs::File;
use std::io::{BufReader, BufWriter, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::look::Look;
use super::record::Record;
use crate::error::Error;
use crate::film::aov::{Aovs, GROUP_LIMIT, GROUPS, Names};
use crate::film::slot::BLOCK_SAMPLES;
use crate::film::store::{MAX_BLOCKS, ReadError};
use crate::film::{Film, Tile};
pub use identity::{Difference, Identity, fingerprint, keyword};
pub use merge::merge;
use seal::Seal;

/// Extension by which the command line knows a part.
pub const EXTENSION: &str = "part";

const MAGIC: &[u8; 8] = b"STERPART";
const VERSION: u64 = 2;
/// Magic, version, length of the header.
const HEAD_BYTES: u64 = 24;
const SEAL_BYTES: u64 = 16;
/// A render may be asked for more blocks than a film can hold.
const MAX_WANTED: u64 = 1 << 32;
/// No counter is larger; sums of some parts' counters fit into 64 bits then.
const MAX_COUNT: u64 = 1 << 56;

/// All that a part file says besides the film's accumulators.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Header {
    /// What must be the same to go on or to merge.
    pub identity: Identity,
    /// Where the film's pixels lie in the image.
    pub window: Tile,
    pub first_block: u64,
    /// Blocks that the render was asked for, counted from the first; None where time or error was to stop it.
    pub wanted_blocks: Option<u64>,
    pub look: Look,
    pub names: Names,
    /// The run so far: seconds, rays, ledger, device. Of a render that still ran, `stopped_by` is "checkpoint".
    pub record: Record,
}

/// A film that was read.
#[derive(Clone, Debug)]
pub struct Part {
    pub path: PathBuf,
    pub header: Header,
    pub film: Film,
}

/// The file is named as a part.
pub fn is_part(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case(EXTENSION))
}

impl Header {
    /// None when it names one that is not known, or more light groups than there can be.
    pub fn aovs(&self) -> Option<Aovs> {
        let aovs = Aovs::parse(self.identity.setting("--aov")?).ok()?;
        let groups = self.names.groups.len();
        (!aovs.has(GROUPS) || groups <= GROUP_LIMIT).then(|| aovs.with_groups(groups as u32))
    }

    /// First sample of every pixel.
    pub fn first_sample(&self) -> u64 {
        self.first_block * u64::from(BLOCK_SAMPLES)
    }

    /// Why the films of the two cannot be of one render.
    pub fn difference(&self, other: &Self) -> Option<Difference> {
        let place = |w: &Tile| format!("{}x{} at {},{}", w.width, w.height, w.x, w.y);
        let (ours, theirs) = (place(&self.window), place(&other.window));
        (self.identity.difference(&other.identity))
            .or_else(|| (self.names != other.names).then_some(Difference::Scene))
            .or_else(|| (ours != theirs).then_some(Difference::Value { what: "window".into(), ours, theirs }))
    }

    /// Why it cannot be right.
    fn fault(&self) -> Option<&'static str> {
        let record = &self.record;
        let ledger = &record.ledger;
        let counts = [
            ledger.nan,
            ledger.inf,
            ledger.negative,
            ledger.depth,
            ledger.disagree,
            ledger.alpha_overflow,
            ledger.media_overflow,
            ledger.cut,
            record.rays,
        ];
        let is_image = (1..=65536).contains(&record.width) && (1..=65536).contains(&record.height);
        match () {
            () if !is_image || !self.window.is_inside(record.width, record.height) => {
                Some("its window does not lie in its image")
            }
            () if self.first_block > MAX_BLOCKS || self.wanted_blocks.is_some_and(|n| n > MAX_WANTED) => {
                Some("it begins or ends at a sample beyond 2^32")
            }
            () if self.aovs().is_none() => Some("it names AOVs that this program does not know"),
            () if counts.iter().any(|&n| n > MAX_COUNT) => Some("one of its counts is more than any render's"),
            () => None,
        }
    }
}

/// Fails, with one sentence, where a part could not be written later.
pub fn check(path: &Path) -> Result<(), Error> {
    super::check(&behind_links(path))
}

/// A part that is a link stays one: its file is replaced.
fn behind_links(path: &Path) -> PathBuf {
    match path.is_symlink() {
        true => path.canonicalize().unwrap_or_else(|_| path.to_owned()),
        false => path.to_owned(),
    }
}

/// Writes `film` with a header whose record says how the run stands; window, range, names, ledger and rays are the film's.
pub fn write(path: &Path, header: &Header, film: &Film) -> Result<(), Error> {
    let mut header = header.clone();
    (header.window, header.first_block, header.names) = (film.window(), film.first_block(), film.names().clone());
    let record = &mut header.record;
    (record.samples, record.rays, record.ledger) = (film.sample_count(), film.ray_count(), film.ledger().clone());
    (record.spp, record.adaptive) = (film.spp(), film.spread());
    // Estimates are made again from the film; some are infinite, which JSON cannot say.
    (record.relmse_est, record.relmse_est_exposure, record.relmse_est_trimmed) = (None, None, None);
    let json = serde_json::to_string(&header).map_err(|e| Error::file(path, format!("cannot write: {e}")))?;
    let room = " ".repeat(json.len().next_multiple_of(8) - json.len());
    super::replace_durably(&behind_links(path), |file| {
        let mut out = Seal::new(BufWriter::with_capacity(1 << 16, file));
        out.write_all(MAGIC)?;
        out.write_all(&VERSION.to_le_bytes())?;
        out.write_all(&((json.len() + room.len()) as u64).to_le_bytes())?;
        out.write_all(json.as_bytes())?;
        out.write_all(room.as_bytes())?;
        film.store(&mut out)?;
        let (sum, mut out) = out.finish();
        out.write_all(&sum.to_le_bytes())?;
        out.flush()
    })
}

/// The header alone; the whole file is checked.
pub fn read_header(path: &Path) -> Result<Header, Error> {
    Ok(Reader::open(path)?.header)
}

pub fn read(path: &Path) -> Result<Part, Error> {
    let Reader { mut input, header, film_bytes } = Reader::open(path)?;
    let aovs = header.aovs().expect("the reader has parsed it");
    Film::check_memory(header.window.width, header.window.height, aovs)?;
    let film = Film::restore(
        header.window,
        aovs,
        (header.first_block, header.record.adaptive.is_some()),
        &mut input,
        film_bytes,
    );
    let mut film = film.map_err(|e| match e {
        ReadError::Io(e) => Error::io("read", path, e),
        ReadError::Content(what) => Error::file(path, format!("not a part file that this program writes: {what}")),
    })?;
    film.set_names(header.names.clone());
    film.set_totals(header.record.rays, header.record.ledger.clone());
    Ok(Part { path: path.to_owned(), header, film })
}

/// A file whose checksum is right, at the begin of its film.
struct Reader {
    input: BufReader<File>,
    header: Header,
    film_bytes: u64,
}

impl Reader {
    fn open(path: &Path) -> Result<Self, Error> {
        let fault = |what: &str| Error::file(path, what);
        let io = |e| Error::io("read", path, e);
        if path.is_dir() {
            return Err(fault("cannot read: it is a directory"));
        }
        // Opening a pipe would wait for a writer.
        if !std::fs::metadata(path).map_err(io)?.is_file() {
            return Err(fault("cannot read: it is no regular file"));
        }
        let mut file = File::open(path).map_err(io)?;
        let length = file.metadata().map_err(io)?.len();
        let mut head = [0u8; HEAD_BYTES as usize];
        if length < HEAD_BYTES + SEAL_BYTES {
            return Err(fault("too short for a part file"));
        }
        file.read_exact(&mut head).map_err(io)?;
        let number = |k: usize| u64::from_le_bytes(std::array::from_fn(|i| head[8 * k + i]));
        if head[..8] != *MAGIC {
            return Err(fault("not a part file: they are written by `render` with --checkpoint or -o X.part"));
        }
        if number(1) != VERSION {
            let said = format!("a part file of format {}, and this program reads format {VERSION}", number(1));
            return Err(fault(&said));
        }
        file.rewind().map_err(io)?;
        let is_sealed = seal::holds(&mut file, length - SEAL_BYTES).map_err(io)?;
        if !is_sealed {
            return Err(fault("damaged or cut short: its checksum is not that of its content; render that part again"));
        }
        let lies = |what: &str| fault(&format!("not a part file that this program writes: {what}"));
        let header_bytes = number(2);
        let Some(film_bytes) = (length - HEAD_BYTES - SEAL_BYTES).checked_sub(header_bytes) else {
            return Err(lies("its header is longer than the file"));
        };
        file.seek(SeekFrom::Start(HEAD_BYTES)).map_err(io)?;
        let mut input = BufReader::with_capacity(1 << 16, file);
        let mut json = vec![0u8; header_bytes as usize];
        input.read_exact(&mut json).map_err(io)?;
        let header: Header = serde_json::from_slice(&json).map_err(|e| lies(&format!("its header: {e}")))?;
        match header.fault() {
            Some(what) => Err(lies(what)),
            None if Film::stored_bytes(header.window, header.aovs().unwrap_or_default()) > film_bytes => {
                Err(lies("its size in pixels is more than its bytes can hold"))
            }
            None => Ok(Self { input, header, film_bytes }),
        }
    }
}

#[cfg(test)]
mod tests;
