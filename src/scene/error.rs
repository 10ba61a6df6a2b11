//! What can go wrong while a scene is read. Every message is one sentence: what happened, where, and what to do.

use std::path::PathBuf;

#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The file system refused.
    #[error("cannot read {}: {reason}; {hint}", path.display())]
    Read { path: PathBuf, reason: String, hint: String },
    /// The extension names no format, or one that is not read yet.
    #[error("{}: {reason}", path.display())]
    Format { path: PathBuf, reason: String },
    /// A place in a text file, counted from 1.
    #[error("{}:{line}:{column}: {reason}", path.display())]
    Text { path: PathBuf, line: usize, column: usize, reason: String },
    /// An entity of a glTF file, such as `accessor 3 "positions"`.
    #[error("{}: {place}: {reason}", path.display())]
    Gltf { path: PathBuf, place: String, reason: String },
    /// Pixels that cannot be used.
    #[error("{}: {reason}", path.display())]
    Image { path: PathBuf, reason: String },
}

impl Error {
    /// A file that could not be opened or read, in words that say which case it is.
    pub fn read(path: &std::path::Path, error: &std::io::Error) -> Self {
        use std::io::ErrorKind;
        let (reason, hint) = match error.kind() {
            ErrorKind::NotFound => ("there is no such file".into(), "check the path"),
            ErrorKind::PermissionDenied => ("permission denied".into(), "check who may read it"),
            ErrorKind::IsADirectory => ("it is a directory".into(), "name the file inside it"),
            _ => (error.to_string(), "check the file and the disk it is on"),
        };
        Self::Read { path: path.to_path_buf(), reason, hint: hint.into() }
    }
}
