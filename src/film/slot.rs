//! The slot: what a device writes for one (pixel, block). The only definition; GLSL gets struct, encoder and constants from here.
//!
//! Rows 0 and 1 are `SlotRecord`; those of the AOVs asked for follow (`aov::Layout`). A slot is written by one invocation, whole, so
//! no atomics are needed.

use super::aov::{Aovs, Layout};
use crate::gpu_record;
use crate::prepare::records::NONE;
use crate::shader::record::GpuRecord;

/// Samples in a block: aligned, block k holds samples 16 k .. 16 k + 15.
pub const BLOCK_SAMPLES: u32 = 16;

gpu_record! {
    /// One block of one pixel.
    pub struct SlotRecord {
        /// Sum of the 16 samples' radiance; a bad sample adds 0.
        sum: [f32; 3],
        /// Rays traced, shadow rays included.
        rays: u32,
        /// LEDGER_NAN, LEDGER_INF, LEDGER_NEGATIVE, LEDGER_DISAGREE: 8 bits each, saturating.
        ledger_a: u32,
        /// LEDGER_DEPTH, LEDGER_ALPHA_OVERFLOW, LEDGER_MEDIA_OVERFLOW, LEDGER_CUT: 8 bits each, saturating.
        ledger_b: u32,
        /// Sum of the throughput's luminance where `max_depth` cut a path.
        lost_energy: f32,
        /// Sample index (in the pixel) of the first NaN, infinite or negative sample, or NONE.
        first_bad: u32,
    }
}

pub const SLOT_ROWS: usize = size_of::<SlotRecord>() / 16;

/// Rows of a slot.
pub fn rows(aovs: Aovs) -> usize {
    SLOT_ROWS + Layout::of(aovs).rows
}

/// A saturating counter inside a ledger word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Counter {
    pub name: &'static str,
    /// 0: `ledger_a`, 1: `ledger_b`.
    pub word: u32,
    pub shift: u32,
    pub bits: u32,
}

impl Counter {
    pub const fn max(self) -> u32 {
        (1 << self.bits) - 1
    }
    pub fn read(self, slot: &SlotRecord) -> u32 {
        let word = if self.word == 0 { slot.ledger_a } else { slot.ledger_b };
        (word >> self.shift) & self.max()
    }
    /// Adds with saturation; what GLSL's `ledger_count` does.
    pub fn add(self, slot: &mut SlotRecord, count: u32) {
        let total = self.read(slot).saturating_add(count).min(self.max());
        let word = if self.word == 0 { &mut slot.ledger_a } else { &mut slot.ledger_b };
        *word = (*word & !(self.max() << self.shift)) | (total << self.shift);
    }
}

pub const LEDGER_NAN: Counter = Counter { name: "LEDGER_NAN", word: 0, shift: 0, bits: 8 };
pub const LEDGER_INF: Counter = Counter { name: "LEDGER_INF", word: 0, shift: 8, bits: 8 };
pub const LEDGER_NEGATIVE: Counter = Counter { name: "LEDGER_NEGATIVE", word: 0, shift: 16, bits: 8 };
pub const LEDGER_DISAGREE: Counter = Counter { name: "LEDGER_DISAGREE", word: 0, shift: 24, bits: 8 };
pub const LEDGER_DEPTH: Counter = Counter { name: "LEDGER_DEPTH", word: 1, shift: 0, bits: 8 };
pub const LEDGER_ALPHA_OVERFLOW: Counter = Counter { name: "LEDGER_ALPHA_OVERFLOW", word: 1, shift: 8, bits: 8 };
pub const LEDGER_MEDIA_OVERFLOW: Counter = Counter { name: "LEDGER_MEDIA_OVERFLOW", word: 1, shift: 16, bits: 8 };
/// Samples that the slot lacks, because the driver ended the kernel's loops before them (shaders/kernel/render.glsl).
pub const LEDGER_CUT: Counter = Counter { name: "LEDGER_CUT", word: 1, shift: 24, bits: 8 };

pub const COUNTERS: [Counter; 8] = [
    LEDGER_NAN,
    LEDGER_INF,
    LEDGER_NEGATIVE,
    LEDGER_DISAGREE,
    LEDGER_DEPTH,
    LEDGER_ALPHA_OVERFLOW,
    LEDGER_MEDIA_OVERFLOW,
    LEDGER_CUT,
];

/// Rows of one slot from those of its samples, one slot each and in order: what one invocation would have written, to the bit,
/// because it adds in the same order.
pub fn joined(rows: &[[u32; 4]], aovs: Aovs) -> Vec<[u32; 4]> {
    let layout = Layout::of(aovs);
    let mut whole = SlotRecord { first_bad: NONE, ..SlotRecord::default() };
    let mut more = vec![[0u32; 4]; layout.rows];
    for (sample, part) in rows.chunks_exact(SLOT_ROWS + layout.rows).enumerate() {
        let slot: SlotRecord = bytemuck::cast([part[0], part[1]]);
        for c in 0..3 {
            whole.sum[c] += slot.sum[c];
        }
        whole.rays += slot.rays;
        COUNTERS.iter().for_each(|counter| counter.add(&mut whole, counter.read(&slot)));
        whole.lost_energy += slot.lost_energy;
        whole.first_bad = whole.first_bad.min(slot.first_bad);
        layout.join(&mut more, &part[SLOT_ROWS..], sample);
    }
    let whole: [[u32; 4]; SLOT_ROWS] = bytemuck::cast(whole);
    whole.into_iter().chain(more).collect()
}

/// Constants, structs, encoders and the saturating count for GLSL: `uvec2 ledger_count(uvec2 ledger, uvec3 counter, uint count)`
/// with counter = (word, shift, max), and `uvec4 SlotRecord_row0(SlotRecord s)` and so on for each row.
pub fn glsl() -> String {
    let mut text = format!("const uint BLOCK_SAMPLES = {BLOCK_SAMPLES}u;\nconst uint SLOT_ROWS = {SLOT_ROWS}u;\n");
    for c in COUNTERS {
        text += &format!("const uvec3 {} = uvec3({}u, {}u, {}u);\n", c.name, c.word, c.shift, c.max());
    }
    text += &SlotRecord::glsl_struct();
    text += &encoder::<SlotRecord>();
    text + "uvec2 ledger_count(uvec2 ledger, uvec3 counter, uint count) {\n\
            \x20   uint word = counter.x == 0u ? ledger.x : ledger.y;\n\
            \x20   uint total = min(((word >> counter.y) & counter.z) + count, counter.z);\n\
            \x20   word = (word & ~(counter.z << counter.y)) | (total << counter.y);\n\
            \x20   return counter.x == 0u ? uvec2(word, ledger.y) : uvec2(ledger.x, word);\n}\n"
}

/// `uvec4 NAME_rowK(NAME s)` for each row: the inverse of the generated loader.
fn encoder<R: GpuRecord>() -> String {
    let mut words: Vec<String> = Vec::new();
    for f in R::FIELDS {
        for k in 0..f.word_count {
            let part = if f.word_count == 1 { String::new() } else { format!(".{}", ["x", "y", "z", "w"][k]) };
            let value = format!("s.{}{part}", f.name);
            words.push(if f.glsl.starts_with('u') { value } else { format!("floatBitsToUint({value})") });
        }
    }
    words
        .chunks(4)
        .enumerate()
        .map(|(row, w)| format!("uvec4 {0}_row{row}({0} s) {{ return uvec4({1}); }}\n", R::NAME, w.join(", ")))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counters_do_not_overlap_and_saturate() {
        for word in 0..2 {
            let masks = COUNTERS.iter().filter(|c| c.word == word).map(|c| c.max() << c.shift);
            assert_eq!(
                masks.fold(0u32, |seen, mask| {
                    assert_eq!(seen & mask, 0);
                    seen | mask
                }),
                u32::MAX
            );
        }
        let mut slot = SlotRecord { first_bad: NONE, ..Default::default() };
        LEDGER_DISAGREE.add(&mut slot, 300);
        LEDGER_NAN.add(&mut slot, 3);
        LEDGER_DEPTH.add(&mut slot, 70_000);
        assert_eq!(COUNTERS.map(|c| c.read(&slot)), [3, 0, 0, 255, 255, 0, 0, 0]);
    }

    #[test]
    fn glsl_encodes_every_word() {
        let text = glsl();
        assert!(text.contains("uvec4 SlotRecord_row1(SlotRecord s) { return uvec4(s.ledger_a, s.ledger_b, floatBitsToUint(s.lost_energy), s.first_bad); }"), "{text}");
    }
}
