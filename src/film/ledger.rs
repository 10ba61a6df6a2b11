//! The bias ledger: what was lost from the estimate, by cause, and where to replay it.

use serde::{Deserialize, Serialize};

use super::slot::{self, SlotRecord};
use crate::prepare::records::NONE;

/// Replay keys kept; the counts go on.
const MAX_KEYS: usize = 16;

/// A sample that was NaN, infinite or negative.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct BadSample {
    pub x: u32,
    pub y: u32,
    pub sample: u64,
}

/// Totals over all samples of a film.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Ledger {
    /// Samples that were NaN or infinite: counted and replaced by 0. Negative ones: counted and kept.
    pub nan: u64,
    pub inf: u64,
    pub negative: u64,
    /// Paths cut at `max_depth`.
    pub depth: u64,
    /// Directions or frames whose shading and geometric sides disagreed.
    pub disagree: u64,
    /// Rays that met more transparent hits than the loop allows.
    pub alpha_overflow: u64,
    /// Entries into a fifth medium, which is not remembered.
    #[serde(default)]
    pub media_overflow: u64,
    /// Samples that a driver's limit on loops ended, which bring nothing.
    #[serde(default)]
    pub cut: u64,
    /// Sum of the throughput's luminance where paths were cut.
    pub lost_energy: f64,
    /// The first bad samples in the order they came.
    pub bad_samples: Vec<BadSample>,
    /// Some counter of a block was full: the true number is larger.
    pub is_saturated: bool,
}

impl Ledger {
    pub(super) fn add_slot(&mut self, slot: &SlotRecord, (x, y): (u32, u32)) {
        if slot.ledger_a | slot.ledger_b == 0 {
            return;
        }
        let totals = [
            &mut self.nan,
            &mut self.inf,
            &mut self.negative,
            &mut self.disagree,
            &mut self.depth,
            &mut self.alpha_overflow,
            &mut self.media_overflow,
            &mut self.cut,
        ];
        for (counter, total) in slot::COUNTERS.into_iter().zip(totals) {
            let count = counter.read(slot);
            *total += count as u64;
            self.is_saturated |= count == counter.max();
        }
        if slot.lost_energy.is_finite() {
            self.lost_energy += slot.lost_energy as f64;
        }
        if slot.first_bad != NONE {
            self.keep(BadSample { x, y, sample: slot.first_bad as u64 });
        }
    }

    /// A block whose sum overflowed f32.
    pub(super) fn count_overflow(&mut self, key: BadSample) {
        self.inf += 1;
        self.keep(key);
    }

    pub fn join(&mut self, other: &Self) {
        self.nan += other.nan;
        self.inf += other.inf;
        self.negative += other.negative;
        self.depth += other.depth;
        self.disagree += other.disagree;
        self.alpha_overflow += other.alpha_overflow;
        self.media_overflow += other.media_overflow;
        self.cut += other.cut;
        self.lost_energy += other.lost_energy;
        self.is_saturated |= other.is_saturated;
        other.bad_samples.iter().for_each(|&key| self.keep(key));
    }

    fn keep(&mut self, key: BadSample) {
        if self.bad_samples.len() < MAX_KEYS && self.bad_samples.last() != Some(&key) {
            self.bad_samples.push(key);
        }
    }

    /// Samples that were replaced by 0.
    pub fn bad_count(&self) -> u64 {
        self.nan + self.inf + self.negative
    }

    /// One line for people: only causes that happened.
    pub fn summary(&self) -> String {
        let causes = [
            ("NaN", self.nan),
            ("infinite", self.inf),
            ("negative", self.negative),
            ("cut by depth", self.depth),
            ("sides disagree", self.disagree),
            ("alpha overflow", self.alpha_overflow),
            ("media overflow", self.media_overflow),
            ("cut by the driver", self.cut),
        ];
        let happened: Vec<String> =
            causes.iter().filter(|(_, n)| *n > 0).map(|(name, n)| format!("{name} {n}")).collect();
        if happened.is_empty() { "nothing lost".into() } else { happened.join(", ") }
    }
}
