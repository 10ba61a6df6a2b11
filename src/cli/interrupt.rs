//! Ctrl-C and SIGTERM. Where there is something to keep, the first signal asks the command to stop and to write it, the second
//! ends the process at once, without half a file left behind. A render has nothing before its first samples (loading, compiling, a driver's own compilation at the
//! first dispatch, which no one can ask to stop): the first signal then ends it.

use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

struct Counts {
    signals: AtomicU32,
    /// Polls until there is something to keep.
    polls_left: AtomicU32,
}

/// A file that grows beyond the shell's limit (ulimit -f) is then a write that fails, with its sentence, in place of a signal that
/// ends the process and leaves half a file.
pub fn survive_file_limit() -> anyhow::Result<()> {
    #[cfg(unix)]
    // The write says it too: nobody reads the flag.
    signal_hook::flag::register(signal_hook::consts::SIGXFSZ, Arc::default())?;
    Ok(())
}

/// Counts the signals since it was installed.
#[derive(Clone)]
pub struct Interrupt(Arc<Counts>);

impl Interrupt {
    /// Takes over SIGINT, SIGTERM and SIGHUP: the first signal asks. Call once a process.
    pub fn install() -> anyhow::Result<Self> {
        Self::after_polls(0)
    }

    /// The same for a render, which polls before its first block and after each: nothing is there until the second poll.
    pub fn install_for_render() -> anyhow::Result<Self> {
        Self::after_polls(2)
    }

    fn after_polls(count: u32) -> anyhow::Result<Self> {
        let counts = Arc::new(Counts { signals: AtomicU32::new(0), polls_left: AtomicU32::new(count) });
        let in_handler = counts.clone();
        ctrlc::set_handler(move || {
            let is_first = in_handler.signals.fetch_add(1, Ordering::SeqCst) == 0;
            let is_empty = in_handler.polls_left.load(Ordering::SeqCst) > 0;
            if is_empty {
                super::say("interrupted before the first samples: nothing is written");
            }
            if is_empty || !is_first {
                steradian::output::remove_unfinished();
                std::process::exit(130);
            }
            super::say("stopping; what is rendered will be written (once more to stop at once)");
        })?;
        Ok(Self(counts))
    }

    /// A signal came.
    pub fn is_set(&self) -> bool {
        self.0.signals.load(Ordering::SeqCst) > 0
    }

    /// The same, asked by a render before its first block and after each.
    pub fn poll(&self) -> bool {
        let fewer = |left: u32| Some(left.saturating_sub(1));
        // Never None, so that there is no error.
        let _ = self.0.polls_left.fetch_update(Ordering::SeqCst, Ordering::SeqCst, fewer);
        self.is_set()
    }
}
