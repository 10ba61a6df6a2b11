//! The library's error: one sentence that says what happened, where, and what to do.
//!
//! Stages with richer errors (scene readers, the device) have their own enums and convert into this one.

use std::path::{Path, PathBuf};

/// Why a command could not be done. Exit code 2, printed as `steradian: <message>`.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The operating system refused a file.
    #[error("{}: cannot {action}: {}", path.display(), reason(source))]
    Io { action: &'static str, path: PathBuf, source: std::io::Error },
    /// A file whose content is not what it should be.
    #[error("{}: {message}", path.display())]
    File { path: PathBuf, message: String },
    /// A scene that cannot be rendered; the message names the entity and the key.
    #[error("{0}")]
    Scene(String),
    /// No device, a missing feature, out of memory, device lost.
    #[error("{0}")]
    Device(String),
    /// A kernel that does not assemble or compile.
    #[error("{0}")]
    Shader(String),
    /// A command line that asks for something impossible.
    #[error("{0}")]
    Usage(String),
}

impl From<crate::gpu::GpuError> for Error {
    fn from(error: crate::gpu::GpuError) -> Self {
        Self::Device(error.to_string())
    }
}

impl From<crate::shader::compile::CompileError> for Error {
    fn from(error: crate::shader::compile::CompileError) -> Self {
        Self::Shader(error.to_string())
    }
}

impl Error {
    pub fn io(action: &'static str, path: impl AsRef<Path>, source: std::io::Error) -> Self {
        Self::Io { action, path: path.as_ref().to_path_buf(), source }
    }
    pub fn file(path: impl AsRef<Path>, message: impl Into<String>) -> Self {
        Self::File { path: path.as_ref().to_path_buf(), message: message.into() }
    }
}

/// The system's words without Rust's "(os error 2)".
fn reason(source: &std::io::Error) -> String {
    let text = source.to_string();
    match text.find(" (os error") {
        Some(end) => text[..end].to_lowercase(),
        None => text,
    }
}
