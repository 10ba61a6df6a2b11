//! The program: commands on top of the library. Results on stdout, progress and messages on stderr.
//!
//! Exit codes: 0 done, 1 a check did not hold, 2 an error (one sentence), 130 interrupted with what was rendered saved.

#![deny(unsafe_code)]

mod cli;

use std::process::ExitCode;
use std::time::Instant;

fn main() -> ExitCode {
    let started = Instant::now();
    // Before any thread: it sets where Mesa keeps compiled kernels.
    steradian::gpu::driver_cache::configure();
    tracing_subscriber::fmt()
        .with_env_filter(tracing_subscriber::EnvFilter::from_default_env())
        .with_writer(std::io::stderr)
        .init();
    match cli::run(started) {
        Ok(exit) => exit.into(),
        Err(error) => {
            cli::say(error);
            ExitCode::from(2)
        }
    }
}
