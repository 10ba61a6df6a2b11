//! Ctrl-C and SIGTERM: the first asks the render to stop after whole blocks, the second ends the process at once.

use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

/// Counts the signals since it was installed.
#[derive(Clone)]
pub struct Interrupt(Arc<AtomicU32>);

impl Interrupt {
    /// Takes over SIGINT, SIGTERM and SIGHUP. Call once a process.
    pub fn install() -> anyhow::Result<Self> {
        let count = Arc::new(AtomicU32::new(0));
        let in_handler = count.clone();
        ctrlc::set_handler(move || {
            if in_handler.fetch_add(1, Ordering::SeqCst) > 0 {
                std::process::exit(130);
            }
            super::say("stopping; what is rendered will be written (once more to stop at once)");
        })?;
        Ok(Self(count))
    }
    pub fn is_set(&self) -> bool {
        self.0.load(Ordering::SeqCst) > 0
    }
}
