//! What a command may write.

use std::path::{Path, PathBuf};

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
