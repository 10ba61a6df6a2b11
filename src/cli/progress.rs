//! The progress bar: on a terminal only, with samples, time and the estimated error.

use std::io::IsTerminal;

use indicatif::{ProgressBar, ProgressStyle};
use steradian::film::slot::BLOCK_SAMPLES;
use steradian::render::Progress;

const STEPS: u64 = 1000;

pub struct Bar(Option<ProgressBar>);

impl Bar {
    /// A bar on stderr, or nothing when that is not a terminal.
    pub fn new() -> Self {
        if !std::io::stderr().is_terminal() {
            return Self(None);
        }
        let bar = ProgressBar::new(STEPS);
        if let Ok(style) = ProgressStyle::with_template("{bar:40} {percent:>3} %  {msg}") {
            bar.set_style(style.progress_chars("=> "));
        }
        bar.set_message("first pass (a new kernel is compiled by the driver)");
        Self(Some(bar))
    }

    pub fn update(&self, progress: &Progress) {
        if let Some(bar) = &self.0 {
            bar.set_position((progress.fraction() * STEPS as f64) as u64);
            bar.set_message(message(progress));
        }
    }

    pub fn finish(&self) {
        if let Some(bar) = &self.0 {
            bar.finish_and_clear();
        }
    }
}

fn message(progress: &Progress) -> String {
    let samples = BLOCK_SAMPLES as u64;
    let spp = match progress.blocks_wanted {
        Some(wanted) => format!("{}/{} spp", progress.blocks_done * samples, wanted * samples),
        None => format!("{} spp", progress.blocks_done * samples),
    };
    let error = progress.error.map_or(String::new(), |e| format!("  relMSE {:.2e}", e.relmse.value));
    format!("{spp}  {:.1} s{error}", progress.elapsed_s)
}
