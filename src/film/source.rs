//! Where samples come from: a GPU, software Vulkan, the CPU reference, or an analytic fake in tests.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::Film;
use super::aov::Aovs;
use super::spans::Span;
use crate::error::Error;

/// Something that renders whole blocks of samples into a film.
pub trait SampleSource {
    /// Width and height of the whole image in pixels.
    fn resolution(&self) -> (u32, u32);
    /// What its slots carry beside radiance, and what the film is to write.
    fn aovs(&self) -> Aovs {
        Aovs::NONE
    }
    /// Renders `blocks` of every pixel of the film's window and adds them, in block order. When `stop` turns true it may return early, after whole
    /// blocks: then some pixels have fewer of them, which the film knows.
    fn render_blocks(
        &mut self,
        blocks: Range<u64>,
        film: &mut Film,
        stop: &dyn Fn() -> bool,
    ) -> Result<PassStats, Error>;
    /// The same for a list of blocks by pixel of the film's window, in ascending order of pixels. A sample has the same bits either way.
    fn render_spans(&mut self, spans: &[Span], film: &mut Film, stop: &dyn Fn() -> bool) -> Result<PassStats, Error>;
    fn describe(&self) -> DeviceInfo;
}

/// What one call of `render_blocks` or `render_spans` did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PassStats {
    pub rays: u64,
    /// Time on the device, without the host's summing.
    pub device_time_s: f64,
}

impl std::ops::AddAssign for PassStats {
    fn add_assign(&mut self, other: Self) {
        self.rays += other.rays;
        self.device_time_s += other.device_time_s;
    }
}

/// What the record says of the device and the kernel.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct DeviceInfo {
    /// "gpu", "software" or "cpu".
    pub kind: String,
    pub name: String,
    pub driver: String,
    /// Kind and driver without versions: what makes the same picture from the same samples, up to rounding.
    pub family: String,
    /// Hash of the kernel's text; empty on the CPU.
    pub kernel_hash: String,
    /// Peak bytes allocated on the device.
    pub peak_bytes: u64,
    /// Stages it knows itself, seconds: compile, upload.
    pub compile_s: f64,
    pub upload_s: f64,
    /// What the user should know (fallbacks taken, features missing).
    pub notes: Vec<String>,
}
