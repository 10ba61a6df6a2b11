//! Files: EXR with every layer, PNG and Radiance HDR for looking at, and the run's record.
//!
//! Every file is written beside its place and renamed, so that no one ever reads half of one. `check` says before the render
//! whether a path can be written.

pub mod bands;
pub mod exr;
pub mod hdr;
pub mod image;
pub mod look;
pub mod palette;
pub mod part;
pub mod record;

use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use crate::error::Error;
use crate::film::Film;
use look::Look;
use record::Record;

/// A picture format, by its file's extension.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    Exr,
    Png,
    Hdr,
}

impl Format {
    pub fn of(path: &Path) -> Result<Self, Error> {
        let extension = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
        match extension.as_deref() {
            Some("exr") => Ok(Self::Exr),
            Some("png") => Ok(Self::Png),
            Some("hdr") => Ok(Self::Hdr),
            _ => Err(Error::file(path, "not a known picture format: use .exr, .png or .hdr")),
        }
    }
}

/// Fails, with one sentence, where `path` could not be written later.
pub fn check(path: &Path) -> Result<(), Error> {
    if path.is_dir() {
        return Err(Error::file(path, "cannot write: it is a directory"));
    }
    sweep(path);
    let beside = beside(path);
    let file = File::create(&beside).map_err(|e| Error::io("write", path, e))?;
    drop(file);
    std::fs::remove_file(&beside).map_err(|e| Error::io("write", path, e))
}

/// The same, and that the extension names a picture format.
pub fn check_picture(path: &Path) -> Result<(), Error> {
    Format::of(path)?;
    check(path)
}

/// Writes the film's picture by the extension of `path`. EXR holds every layer and the record; `look` (or stops of exposure) is for
/// PNG only.
pub fn write_picture(path: &Path, film: &Film, record: &Record, look: impl Into<Look>) -> Result<(), Error> {
    match Format::of(path)? {
        Format::Exr => exr::write(path, film, record),
        Format::Png => image::write_png(path, &image::Picture::of_film(film), look),
        Format::Hdr => image::write_hdr(path, &image::Picture::of_film(film)),
    }
}

/// Writes `bytes` beside `path` and renames.
pub fn write_atomically(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    replace(path, |beside| std::fs::write(beside, bytes).map_err(|e| Error::io("write", path, e)))
}

/// Lets `write` make a file beside `path`, then renames it; nothing is left behind when it fails.
pub fn replace(path: &Path, write: impl FnOnce(&Path) -> Result<(), Error>) -> Result<(), Error> {
    let beside = beside(path);
    let written = write(&beside).and_then(|()| std::fs::rename(&beside, path).map_err(|e| Error::io("write", path, e)));
    if written.is_err() {
        // The first error is the one to tell.
        std::fs::remove_file(&beside).ok();
    }
    written
}

/// Files that this process may have begun. A signal's handler, which ends the process, knows nothing else of them.
static BEGUN: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// Removes what was begun and not finished: before a process ends at once.
pub fn remove_unfinished() {
    if let Ok(begun) = BEGUN.lock() {
        // Those that were finished have other names.
        begun.iter().for_each(|path| drop(std::fs::remove_file(path)));
    }
}

/// The same, and the bytes are on the disk before the new file takes the place of the old one: a loss of power leaves one of the two.
pub fn replace_durably(path: &Path, write: impl FnOnce(&mut File) -> std::io::Result<()>) -> Result<(), Error> {
    replace(path, |beside| {
        let written = File::create(beside).and_then(|mut file| {
            write(&mut file)?;
            file.sync_all()
        });
        written.map_err(|e| Error::io("write", path, e))
    })?;
    // The rename itself; not every file system can bring a folder to the disk.
    if let Ok(folder) = File::open(folder(path)) {
        folder.sync_all().ok();
    }
    Ok(())
}

fn folder(path: &Path) -> &Path {
    path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(".".as_ref())
}

/// `dir/.name.PID.tmp`: on the same file system, and not the same for two processes.
fn beside(path: &Path) -> PathBuf {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let beside = path.with_file_name(format!(".{name}.{}.tmp", std::process::id()));
    if let Ok(mut begun) = BEGUN.lock()
        && !begun.contains(&beside)
    {
        begun.push(beside.clone());
    }
    beside
}

/// Removes what processes that were killed while they wrote `path` left beside it. Only where the system says which still run.
fn sweep(path: &Path) {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let (begin, processes) = (format!(".{name}."), Path::new("/proc"));
    if !processes.join("self").exists() {
        return;
    }
    for entry in std::fs::read_dir(folder(path)).into_iter().flatten().flatten() {
        let file = entry.file_name();
        let id = file.to_str().and_then(|f| f.strip_prefix(&begin)).and_then(|rest| rest.strip_suffix(".tmp"));
        let is_left = id.is_some_and(|id| id.parse::<u32>().is_ok() && !processes.join(id).exists());
        if is_left {
            std::fs::remove_file(entry.path()).ok();
        }
    }
}

#[cfg(test)]
mod tests;
