//! What commands print on stdout. A reader that has gone away (`| head -1`) is no fault: the work goes on and ends with its own exit
//! code. Anything else that stdout does not take, as on a full disk, is an error at the end of the command.

use std::fmt::Arguments;
use std::io::{self, ErrorKind, Write, stdout};
use std::sync::{Mutex, PoisonError};

use super::Exit;

/// The first write that failed.
static FAILED: Mutex<Option<io::Error>> = Mutex::new(None);

/// Behind `println!` and `print!` of the commands.
pub fn write(text: Arguments<'_>) {
    note(stdout().write_fmt(text));
}

/// Keeps the first error for `finish`.
pub fn note(result: io::Result<()>) {
    if let Err(error) = result {
        FAILED.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
    }
}

/// How a command ends whose work ended as `exit`.
pub fn finish(exit: Exit) -> anyhow::Result<Exit> {
    note(stdout().flush());
    match FAILED.lock().unwrap_or_else(PoisonError::into_inner).take() {
        Some(error) if error.kind() != ErrorKind::BrokenPipe => {
            anyhow::bail!("stdout: cannot write: {}", error.to_string().to_lowercase())
        }
        _ => Ok(exit),
    }
}
