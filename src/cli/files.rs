//! What a command may write, and writing it.

use std::path::{Path, PathBuf};

use steradian::error::Error;
use steradian::film::Film;
use steradian::output::part::{self, Header};
use steradian::output::{self, Format};

use super::say;

/// Every file that is written is another one, and none is read: the last writer would win, or what is read be lost.
pub fn no_file_twice<'a>(
    read: impl IntoIterator<Item = &'a Path>,
    written: impl IntoIterator<Item = &'a Path>,
) -> anyhow::Result<()> {
    let mut taken: Vec<PathBuf> = read.into_iter().map(place).collect();
    for path in written {
        let at = place(path);
        anyhow::ensure!(
            !taken.contains(&at),
            "{}: it is read or written already by this command; give another name",
            path.display()
        );
        taken.push(at);
    }
    Ok(())
}

/// Where a path lies, whether or not there is a file; behind links, if there is.
pub fn place(path: &Path) -> PathBuf {
    if let Ok(place) = path.canonicalize() {
        return place;
    }
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(".".as_ref());
    folder.canonicalize().unwrap_or_else(|_| folder.to_owned()).join(path.file_name().unwrap_or_default())
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
