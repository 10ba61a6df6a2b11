//! The record of a run: what was rendered, how long it took, how good it is, what was lost. JSON field names are the field's.

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::error::Error;
use crate::film::Tile;
use crate::film::adaptive::Spread;
use crate::film::filter::PixelFilter;
use crate::film::ledger::Ledger;
use crate::metric::estimate::{Estimate, FilmError};

/// Seconds by stage. `write` is 0 in the copy inside an EXR's header, which is written before it is known.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Stages {
    pub load: f64,
    pub bvh: f64,
    pub compile: f64,
    pub upload: f64,
    pub trace: f64,
    pub write: f64,
}

impl Stages {
    /// Of both together.
    pub fn plus(self, other: Self) -> Self {
        Self {
            load: self.load + other.load,
            bvh: self.bvh + other.bvh,
            compile: self.compile + other.compile,
            upload: self.upload + other.upload,
            trace: self.trace + other.trace,
            write: self.write + other.write,
        }
    }
}

/// Said of an estimate that is heavy-tailed (`FilmError::is_heavy_tailed`).
pub const HEAVY_TAILS: &str = "a few pixels carry most of the estimated error: its tails are too heavy for its interval to be trusted, and more samples are needed to tell";

#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[allow(non_snake_case)] // throughput_MSps and throughput_Mrays_ps are the field's names
pub struct Record {
    /// Program and version.
    pub program: String,
    pub command: String,
    pub scene: String,
    pub width: u32,
    pub height: u32,
    /// What of the image was rendered, when it was not all.
    pub crop: Option<Tile>,
    pub filter: Option<PixelFilter>,
    pub seed: u32,
    pub integrator: String,
    pub estimator: String,
    pub sampler: String,
    pub max_depth: u32,
    /// Samples a pixel; where a pass was interrupted, the fewest of any pixel; of an adaptive render the mean, rounded down.
    pub spp: u64,
    /// Fewest and most samples of a pixel, where sampling was adaptive. The image has no bias by it: see `film::adaptive`.
    #[serde(default)]
    pub adaptive: Option<Spread>,
    /// What ended the render: "spp", "time", "error" or "interrupt"; "checkpoint" in that of a render that still ran.
    pub stopped_by: String,
    /// From process start to the end of the render (in an EXR's header) or of the last file (elsewhere).
    pub wall_s: f64,
    pub seconds: Stages,
    /// Estimated relMSE with its 95 % interval; absent below two blocks of 16 samples.
    pub relmse_est: Option<Estimate>,
    /// The same with epsilon (0.1 mean)^2, which does not depend on exposure.
    pub relmse_est_exposure: Option<Estimate>,
    /// The first without the worst 0.1 % of pixels.
    pub relmse_est_trimmed: Option<f64>,
    /// The estimate is carried by so few pixels that its interval is not to be trusted.
    #[serde(default)]
    pub relmse_est_heavy_tails: bool,
    pub samples: u64,
    pub rays: u64,
    pub throughput_MSps: f64,
    pub throughput_Mrays_ps: f64,
    pub peak_host_bytes: u64,
    pub peak_device_bytes: u64,
    pub film_bytes: u64,
    pub device: String,
    pub device_kind: String,
    pub driver: String,
    pub kernel_hash: String,
    pub ledger: Ledger,
    pub notes: Vec<String>,
}

impl Record {
    /// What another run was made by that this one was not: kernel, driver, device, with ours and theirs. Samples of both are not to the bit
    /// those of one.
    pub fn other_device<'a>(&'a self, other: &'a Self) -> impl Iterator<Item = (&'static str, &'a str, &'a str)> {
        let all = [
            ("kernel", &self.kernel_hash, &other.kernel_hash),
            ("driver", &self.driver, &other.driver),
            ("device", &self.device, &other.device),
        ];
        all.into_iter().filter(|(_, ours, theirs)| ours != theirs).map(|(what, a, b)| (what, a.as_str(), b.as_str()))
    }

    /// Samples and rays, and their rates over the seconds traced.
    pub fn set_rates(&mut self, samples: u64, rays: u64) {
        let per_second = |count: u64| count as f64 / self.seconds.trace.max(1e-9) * 1e-6;
        (self.throughput_MSps, self.throughput_Mrays_ps) = (per_second(samples), per_second(rays));
        (self.samples, self.rays) = (samples, rays);
    }

    /// The estimates of a film, and a note where they are not to be trusted.
    pub fn set_error(&mut self, error: Option<&FilmError>) {
        self.relmse_est = error.map(|e| e.relmse);
        self.relmse_est_exposure = error.map(|e| e.relmse_exposure);
        self.relmse_est_trimmed = error.map(|e| e.relmse_trimmed);
        self.relmse_est_heavy_tails = error.is_some_and(|e| e.is_heavy_tailed);
        if self.relmse_est_heavy_tails {
            self.add_note(HEAVY_TAILS);
        }
    }

    /// Counts in what another run of the same film took: seconds add, peaks are the larger ones, notes are all of them but
    /// what was said of its error alone.
    pub fn add_run(&mut self, other: &Self) {
        self.seconds = self.seconds.plus(other.seconds);
        self.wall_s += other.wall_s;
        self.peak_host_bytes = self.peak_host_bytes.max(other.peak_host_bytes);
        self.peak_device_bytes = self.peak_device_bytes.max(other.peak_device_bytes);
        self.film_bytes = self.film_bytes.max(other.film_bytes);
        other.notes.iter().filter(|note| *note != HEAVY_TAILS).for_each(|note| self.add_note(note));
    }

    fn add_note(&mut self, note: &str) {
        if !self.notes.iter().any(|n| n == note) {
            self.notes.push(note.into());
        }
    }

    /// Lines for people: error, speed, memory, ledger.
    pub fn summary(&self) -> String {
        let error = match &self.relmse_est {
            Some(e) if self.relmse_est_heavy_tails => {
                format!("relMSE about {:.0e} estimated, its tails too heavy for an interval", e.value)
            }
            Some(e) => format!("relMSE {:.3e} [{:.3e}, {:.3e}] estimated", e.value, e.low, e.high),
            None => "no error estimate below 32 spp".into(),
        };
        let s = &self.seconds;
        let mebibytes = |bytes: u64| bytes as f64 / (1 << 20) as f64;
        let crop = self.crop.map_or(String::new(), |c| format!(" (crop {}x{} at {},{})", c.width, c.height, c.x, c.y));
        let spread =
            self.adaptive.map_or(String::new(), |s| format!(" on average ({} to {})", s.fewest_spp, s.most_spp));
        format!(
            "{}x{}{crop} at {} spp{spread} in {:.2} s, {error}\n\
             load {:.2}, bvh {:.2}, compile {:.2}, upload {:.2}, trace {:.2}, write {:.2} s; {:.3} Msamples/s, {:.2} Mrays/s\n\
             host {:.0} MiB, device {:.0} MiB; {} ({}); lost: {}",
            self.width,
            self.height,
            self.spp,
            self.wall_s,
            s.load,
            s.bvh,
            s.compile,
            s.upload,
            s.trace,
            s.write,
            self.throughput_MSps,
            self.throughput_Mrays_ps,
            mebibytes(self.peak_host_bytes),
            mebibytes(self.peak_device_bytes),
            self.device,
            self.driver,
            self.ledger.summary(),
        )
    }

    /// One JSON object and a newline.
    pub fn write(&self, path: &Path) -> Result<(), Error> {
        let json = serde_json::to_string_pretty(self).map_err(|e| Error::file(path, format!("cannot write: {e}")))?;
        super::write_atomically(path, (json + "\n").as_bytes())
    }
}

/// Resident memory of this process now (VmRSS), bytes; 0 where the system does not say.
pub fn resident_bytes() -> u64 {
    status_bytes("VmRSS:")
}

/// Most resident memory this process ever had (VmHWM), bytes; 0 where the system does not say.
pub fn peak_host_bytes() -> u64 {
    status_bytes("VmHWM:")
}

fn status_bytes(key: &str) -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|l| l.strip_prefix(key));
    let kibibytes: Option<u64> = line.and_then(|l| l.split_whitespace().next()).and_then(|v| v.parse().ok());
    kibibytes.unwrap_or(0) * 1024
}
