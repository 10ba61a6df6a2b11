//! Gate rows and the report made of them: text for people, JSON for programs.

use std::fmt::Write;

/// The gates of DESIGN, section 4.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Gate {
    /// 1: every word of every record through both loader bodies.
    Records,
    /// 2: integers, bit for bit.
    Integers,
    /// 3: GLSL functions against f64.
    Functions,
    /// 4: samples against densities, energy, reciprocity.
    Scattering,
    /// 5: traversal against brute force.
    Traversal,
    /// 6: paths replayed in f64.
    Replay,
    /// 7: images against the independent oracle and closed forms.
    Images,
    /// 8: specialised against everything-on.
    Specialised,
    /// 9: deliberate faults, each caught.
    Mutations,
}

impl Gate {
    pub fn number(self) -> u32 {
        self as u32 + 1
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    Pass,
    Fail,
    /// Could not run; never green, always counted.
    Skip,
}

/// One check: what was measured and what it was held to.
#[derive(Clone, Debug, serde::Serialize)]
pub struct GateRow {
    pub gate: Gate,
    pub name: String,
    pub verdict: Verdict,
    /// What was measured, with the worst input.
    pub evidence: String,
    /// What it must stay within, and where that comes from.
    pub bound: String,
}

impl GateRow {
    pub fn new(
        gate: Gate,
        name: impl Into<String>,
        is_passed: bool,
        evidence: String,
        bound: impl Into<String>,
    ) -> Self {
        let verdict = if is_passed { Verdict::Pass } else { Verdict::Fail };
        Self { gate, name: name.into(), verdict, evidence, bound: bound.into() }
    }

    /// The row as text.
    pub fn line(&self) -> String {
        let verdict = format!("{:?}", self.verdict).to_uppercase();
        format!("{verdict:4} gate {} {:32} {}  [{}]", self.gate.number(), self.name, self.evidence, self.bound)
    }

    /// Whether `filter` names the row: part of its name, or "gate N".
    pub fn is_wanted(&self, filter: &str) -> bool {
        is_wanted(self.gate, &self.name, filter)
    }
}

pub fn is_wanted(gate: Gate, name: &str, filter: &str) -> bool {
    format!("gate {} {name}", gate.number()).contains(filter)
}

/// All rows of a run on a device.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Report {
    pub device: String,
    pub driver: String,
    pub rows: Vec<GateRow>,
}

impl Report {
    pub fn new(device: &str, driver: &str) -> Self {
        Self { device: device.into(), driver: driver.into(), rows: Vec::new() }
    }

    pub fn count(&self, verdict: Verdict) -> usize {
        self.rows.iter().filter(|r| r.verdict == verdict).count()
    }

    /// No row failed, and at least one ran.
    pub fn is_passed(&self) -> bool {
        self.count(Verdict::Fail) == 0 && self.count(Verdict::Pass) > 0
    }

    pub fn failures(&self) -> impl Iterator<Item = &GateRow> {
        self.rows.iter().filter(|r| r.verdict == Verdict::Fail)
    }

    /// A line a row, then the counts.
    pub fn text(&self) -> String {
        let mut text = format!("{} ({})\n", self.device, self.driver);
        for r in &self.rows {
            let _ = writeln!(text, "{}", r.line());
        }
        text + &self.counts() + "\n"
    }

    /// How many rows passed, failed, were skipped.
    pub fn counts(&self) -> String {
        let counts = [Verdict::Pass, Verdict::Fail, Verdict::Skip].map(|v| self.count(v));
        format!("{} passed, {} failed, {} skipped", counts[0], counts[1], counts[2])
    }

    /// One JSON object a row and line, with the device in each.
    pub fn json_lines(&self) -> String {
        let line = |r: &GateRow| {
            serde_json::json!({ "device": self.device, "driver": self.driver, "gate": r.gate.number(), "name": r.name,
                "verdict": r.verdict, "evidence": r.evidence, "bound": r.bound })
            .to_string()
        };
        self.rows.iter().map(|r| line(r) + "\n").collect()
    }
}
