//! The gates on the first Vulkan device, under the validation layer: each failing row fails the test with its evidence, and so does
//! any message of the layer. Without a device these tests fail: a machine that cannot run them must not look as if it had.
//! `steradian conform` runs the same rows; nothing is decided here.

use std::ops::RangeInclusive;

use steradian::conform::subject::Subject;
use steradian::conform::{self, Gate, GateRow, Report, Verdict, mutations, paths};
use steradian::gpu::{Choice, Device, Options};

fn device() -> Device {
    let options = Options { validation: true, ..Options::default() };
    Device::open(&Choice::Auto, &options).expect("a Vulkan device and the validation layer: ./x setup installs both")
}

/// A row that is known to fail on lavapipe.
struct Known {
    gate: Gate,
    name: &'static str,
    why: &'static str,
}

/// One that passes, or that no longer exists, fails the test: then its line goes.
const KNOWN: &[Known] = &[];

/// Rows of `known` become skipped ones. Returns what is wrong with the list; all rows of `gates` are in `rows`.
fn set_aside(rows: &mut [GateRow], gates: &RangeInclusive<u32>, known: &[Known]) -> Vec<String> {
    let mut faults = Vec::new();
    for Known { gate, name, why } in known.iter().filter(|k| gates.contains(&k.gate.number())) {
        match rows.iter_mut().find(|r| r.gate == *gate && r.name == *name) {
            None => faults.push(format!(
                "gate {} has no row \"{name}\", which is listed as known to fail: mend the name or take it off the list",
                gate.number()
            )),
            Some(row) if row.verdict == Verdict::Fail => {
                println!("skipped: known failure of gate {} {name}: {why}; {}", gate.number(), row.evidence);
                row.verdict = Verdict::Skip;
            }
            Some(_) => faults.push(format!("{name} passes although it is known to fail ({why}): take it off the list")),
        }
    }
    faults
}

fn check(device: &Device, gates: RangeInclusive<u32>, rows: Vec<GateRow>) {
    let mut report = Report::new(&device.info().name, &device.info().driver);
    report.rows = rows;
    for row in report.rows.iter().filter(|r| r.verdict == Verdict::Skip) {
        println!("skipped: gate {} {}: {}", row.gate.number(), row.name, row.evidence);
    }
    let faults = set_aside(&mut report.rows, &gates, KNOWN);
    assert!(faults.is_empty(), "{}", faults.join("\n"));
    assert!(report.is_passed(), "{}", report.text());
    let messages = device.messages();
    assert!(messages.is_empty(), "the validation layer said: {}", messages.join("\n"));
}

/// Gates 1 to 5: records, integers, functions, densities, traversal.
#[test]
fn functions() {
    let device = device();
    check(&device, 1..=5, conform::run(&device, "").rows);
}

/// Gates 6 to 8: single paths, images, specialised kernels; small images, 256 samples a pixel.
#[test]
fn paths_and_images() {
    let device = device();
    check(&device, 6..=8, paths::rows(&Subject::new(&device), "", paths::SMALL, &|_| ()));
}

/// Gate 9: every deliberate fault is caught by the gates it names.
#[test]
fn faults_are_caught() {
    let device = device();
    let rows = mutations::rows(&device, "");
    assert!(rows.len() >= 10, "{} faults are too few", rows.len());
    check(&device, 9..=9, rows);
}

/// The list of known failures cannot rot: a row that is gone or passes is a fault, one of another run's gates is not.
#[test]
fn a_known_failure_without_its_row_is_a_fault() {
    let row = |name: &str, is_passed| GateRow::new(Gate::Functions, name, is_passed, String::new(), "");
    let known = |name| [Known { gate: Gate::Functions, name, why: "a test" }];
    let mut rows = [row("passes", true), row("fails", false)];
    assert!(set_aside(&mut rows, &(1..=5), &known("gone"))[0].contains("no row"));
    assert!(set_aside(&mut rows, &(1..=5), &known("passes"))[0].contains("take it off"));
    assert!(set_aside(&mut rows, &(6..=8), &known("gone")).is_empty());
    assert!(set_aside(&mut rows, &(1..=5), &known("fails")).is_empty());
    assert_eq!(rows[1].verdict, Verdict::Skip);
}
