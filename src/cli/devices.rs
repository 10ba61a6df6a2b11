//! `devices`: what can render here.

use steradian::gpu::{self, DeviceInfo};

use super::{Exit, say};

#[derive(clap::Args)]
pub struct Args {
    /// One JSON object a device and line
    #[arg(long)]
    json: bool,
}

pub fn run(args: &Args) -> anyhow::Result<Exit> {
    let devices = gpu::list().unwrap_or_else(|error| {
        say(format_args!("{error}"));
        Vec::new()
    });
    let threads = std::thread::available_parallelism().map_or(1, |n| n.get());
    for device in &devices {
        if args.json {
            println!("{}", serde_json::to_string(device)?);
        } else {
            print!("{}", describe(device));
        }
    }
    if args.json {
        println!("{}", serde_json::json!({ "index": "cpu", "name": "double-precision reference", "threads": threads }));
    } else {
        println!("cpu  double-precision reference, {threads} threads");
    }
    Ok(Exit::Done)
}

fn describe(d: &DeviceInfo) -> String {
    let kind = if d.is_software { "software".into() } else { format!("{:?}", d.kind).to_lowercase() };
    let mebibytes = |bytes: u64| bytes >> 20;
    let mut text = format!(
        "{:<4} {} ({kind})\n     {} {}, Vulkan {}; heap {} MiB, storage range {} MiB, texel buffer {} M texels\n",
        d.index,
        d.name,
        d.driver,
        d.driver_version,
        d.api_version,
        mebibytes(d.limits.heap),
        mebibytes(d.limits.max_storage_range as u64),
        d.limits.max_texel_elements >> 20,
    );
    if let Some(problem) = &d.problem {
        text += &format!("     cannot be used: {problem}\n");
    }
    text
}
