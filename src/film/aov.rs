//! AOVs: what a render stores beside radiance. One row of `AOVS` each; the EXR writer follows the table.

use super::Film;
use super::slot::AovSlotRecord;

/// One layer of the EXR.
pub struct Aov {
    /// Layer name; empty for the colour itself.
    pub name: &'static str,
    /// Channel names inside the layer; "" where the layer is one channel of its own name.
    pub channels: &'static [&'static str],
    pub unit: &'static str,
    /// Whether it needs the AOV rows of the slots.
    pub needs_slots: bool,
    /// Value of a pixel, one entry a channel.
    pub value: fn(&Film, usize) -> [f32; 3],
}

impl Aov {
    /// Name in the file of channel `index`: "R", "albedo.R", "samples".
    pub fn channel_name(&self, index: usize) -> String {
        match (self.name, self.channels[index]) {
            ("", channel) => channel.into(),
            (layer, "") => layer.into(),
            (layer, channel) => format!("{layer}.{channel}"),
        }
    }
}

/// Every layer, in file order.
pub const AOVS: &[Aov] = &[
    Aov {
        name: "",
        channels: &["R", "G", "B"],
        unit: "W/(m^2 sr)",
        needs_slots: false,
        value: |film, pixel| film.mean(pixel).map(|v| v as f32),
    },
    Aov {
        name: "albedo",
        channels: &["R", "G", "B"],
        unit: "1",
        needs_slots: true,
        value: |film, pixel| film.aov_mean(pixel).unwrap_or_default().albedo.map(|v| v as f32),
    },
    Aov {
        name: "normal",
        channels: &["X", "Y", "Z"],
        unit: "1",
        needs_slots: true,
        value: |film, pixel| film.aov_mean(pixel).unwrap_or_default().normal.map(|v| v as f32),
    },
    Aov {
        name: "depth",
        channels: &["Z"],
        unit: "m",
        needs_slots: true,
        value: |film, pixel| [film.aov_mean(pixel).unwrap_or_default().depth as f32, 0.0, 0.0],
    },
    Aov {
        // Of the mean, so that its root is the standard error; infinite below two blocks.
        name: "variance",
        channels: &["R", "G", "B"],
        unit: "(W/(m^2 sr))^2",
        needs_slots: false,
        value: |film, pixel| film.variance_of_mean(pixel).map(|v| v as f32),
    },
    Aov {
        name: "samples",
        channels: &[""],
        unit: "1",
        needs_slots: false,
        value: |film, pixel| [(film.block_count(pixel) * super::slot::BLOCK_SAMPLES) as f32, 0.0, 0.0],
    },
];

/// Sums over samples, f64: blocks are f32, so nothing is lost below 2^29 of them.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct AovSums {
    albedo: [f64; 3],
    depth: f64,
    normal: [f64; 3],
    hits: f64,
}

/// A pixel's AOVs. Albedo and normal are means over all samples (0 where nothing was hit), depth over the hits.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AovMeans {
    pub albedo: [f64; 3],
    /// m; infinite where nothing was hit.
    pub depth: f64,
    pub normal: [f64; 3],
    /// Share of samples that hit something.
    pub coverage: f64,
}

impl AovSums {
    pub(super) fn add(&mut self, slot: &AovSlotRecord) {
        for c in 0..3 {
            self.albedo[c] += slot.albedo[c] as f64;
            self.normal[c] += slot.normal[c] as f64;
        }
        self.depth += slot.depth as f64;
        self.hits += slot.hits as f64;
    }
    pub(super) fn means(&self, samples: f64) -> AovMeans {
        if samples == 0.0 {
            return AovMeans { depth: f64::INFINITY, ..Default::default() };
        }
        AovMeans {
            albedo: self.albedo.map(|v| v / samples),
            depth: if self.hits > 0.0 { self.depth / self.hits } else { f64::INFINITY },
            normal: self.normal.map(|v| v / samples),
            coverage: self.hits / samples,
        }
    }
}
