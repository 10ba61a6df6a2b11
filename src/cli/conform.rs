//! `conform`: the gates on a device, as a report on stdout and as files.

use std::path::PathBuf;

use steradian::conform::subject::Subject;
use steradian::conform::{self, GateRow, Report, mutations, paths};
use steradian::gpu::{self, Choice, Selected};
use steradian::output::write_atomically;

use super::{Exit, say};

#[derive(clap::Args)]
pub struct Args {
    /// auto, an index of `steradian devices`, or part of a name
    #[arg(long, value_name = "D", default_value = "auto")]
    device: String,
    /// Only rows whose "gate N name" contains this
    #[arg(long, value_name = "S", default_value = "")]
    filter: String,
    /// Gate 9 too: injects faults, each of which a gate must catch
    #[arg(long)]
    mutations: bool,
    /// Images and samples of full size instead of those of continuous integration
    #[arg(long)]
    full: bool,
    /// Folder for conform.txt and conform.jsonl
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
}

pub fn run(args: &Args) -> anyhow::Result<Exit> {
    if let Some(folder) = &args.output {
        std::fs::create_dir_all(folder)
            .map_err(|e| anyhow::anyhow!("{}: cannot make the folder: {e}", folder.display()))?;
        steradian::output::check(&folder.join("conform.txt"))?;
    }
    let Selected::Vulkan(device) = gpu::select(&Choice::from(args.device.as_str()), &gpu::Options::default())? else {
        anyhow::bail!(
            "the gates hold a Vulkan device against the CPU reference, and no device is chosen: see `devices`"
        );
    };
    say(format_args!("gates on {}", device.info().title()));
    let show = |row: &GateRow| println!("{}", row.line());
    let mut report = conform::run(&device, &args.filter);
    report.rows.iter().for_each(show);
    let scale = if args.full { paths::FULL } else { paths::SMALL };
    report.rows.extend(paths::rows(&Subject::new(&device), &args.filter, scale, &show));
    if args.mutations {
        let rows = mutations::rows(&device, &args.filter);
        rows.iter().for_each(show);
        report.rows.extend(rows);
    }
    anyhow::ensure!(!report.rows.is_empty(), "no row of the gates contains \"{}\"", args.filter);
    println!("{} ({}): {}", report.device, report.driver, report.counts());
    if let Some(folder) = &args.output {
        write(&report, folder)?;
    }
    Ok(if report.is_passed() { Exit::Done } else { Exit::CheckFailed })
}

fn write(report: &Report, folder: &std::path::Path) -> anyhow::Result<()> {
    for (name, text) in [("conform.txt", report.text()), ("conform.jsonl", report.json_lines())] {
        write_atomically(&folder.join(name), text.as_bytes())?;
    }
    Ok(())
}
