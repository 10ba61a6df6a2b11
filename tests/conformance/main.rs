//! The gates on the first Vulkan device, under the validation layer: each failing row fails the test with its evidence, and so does
//! any message of the layer. Without a device these tests fail: a machine that cannot run them must not look as if it had.
//! `steradian conform` runs the same rows; nothing is decided here.

use steradian::conform::subject::Subject;
use steradian::conform::{self, GateRow, Report, Verdict, mutations, paths};
use steradian::gpu::{Choice, Device, Options};

fn device() -> Device {
    let options = Options { validation: true, ..Options::default() };
    Device::open(&Choice::Auto, &options).expect("a Vulkan device and the validation layer: ./x setup installs both")
}

/// Rows that are known to fail on lavapipe, and why. One that passes fails the test: then its line goes.
const KNOWN: &[(&str, &str)] = &[(
    "dielectric_sample",
    "one input of a million, a reflection within 0.02 degrees of grazing on both sides, is at 1.2 of the bound; the cause is not found yet",
)];

fn check(device: &Device, rows: Vec<GateRow>) {
    let mut report = Report::new(&device.info().name, &device.info().driver);
    report.rows = rows;
    for row in report.rows.iter().filter(|r| r.verdict == Verdict::Skip) {
        println!("skipped: gate {} {}: {}", row.gate.number(), row.name, row.evidence);
    }
    for (name, why) in KNOWN {
        let Some(row) = report.rows.iter_mut().find(|r| r.name == *name) else { continue };
        assert!(
            row.verdict == Verdict::Fail,
            "{name} passes although it is known to fail ({why}): take it off the list"
        );
        println!("skipped: known failure of gate {} {name}: {why}; {}", row.gate.number(), row.evidence);
        row.verdict = Verdict::Skip;
    }
    assert!(report.is_passed(), "{}", report.text());
    let messages = device.messages();
    assert!(messages.is_empty(), "the validation layer said: {}", messages.join("\n"));
}

/// Gates 1 to 5: records, integers, functions, densities, traversal.
#[test]
fn functions() {
    let device = device();
    check(&device, conform::run(&device, "").rows);
}

/// Gates 6 to 8: single paths, images, specialised kernels; small images, 256 samples a pixel.
#[test]
fn paths_and_images() {
    let device = device();
    check(&device, paths::rows(&Subject::new(&device), "", paths::SMALL));
}

/// Gate 9: every deliberate fault is caught by the gates it names.
#[test]
fn faults_are_caught() {
    let device = device();
    let rows = mutations::rows(&device, "");
    assert!(rows.len() >= 10, "{} faults are too few", rows.len());
    check(&device, rows);
}
