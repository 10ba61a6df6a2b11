//! `inspect SCENE`: what the scene needs, what its kernel leaves out, and what that saved.

use steradian::gpu::{self, Choice, Selected};
use steradian::prepare;
use steradian::report::inspect;

use steradian::film::aov::Aovs;

use super::scene_args::SceneArgs;
use super::{Exit, say};

#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    scene: SceneArgs,
    /// auto, cpu, an index of `steradian devices`, or part of a name
    #[arg(long, value_name = "D", default_value = "auto")]
    device: String,
    /// One JSON object
    #[arg(long)]
    json: bool,
    /// Prints the assembled GLSL of the kernel instead
    #[arg(long, conflicts_with = "json")]
    glsl: bool,
}

pub fn run(args: &Args) -> anyhow::Result<Exit> {
    let scene = args.scene.load()?;
    let settings = args.scene.settings(&scene, Aovs::NONE);
    let prepared = prepare::prepare(&scene, &settings)?;
    scene.notes.iter().chain(&prepared.notes).for_each(say);
    let selected = gpu::select(&Choice::from(args.device.as_str()), &gpu::Options::default())?;
    if args.glsl {
        let Selected::Vulkan(device) = selected else {
            anyhow::bail!("--glsl needs a Vulkan device, and there is none")
        };
        println!("{}", inspect::glsl(&device, &prepared, &settings)?);
        return Ok(Exit::Done);
    }
    let mut inspection = inspect::inspect(&prepared, &settings);
    inspection.variants = scene.variants.clone();
    match selected {
        Selected::Vulkan(device) => inspection.kernels = Some(inspect::kernels(&device, &prepared, &settings)?),
        Selected::Cpu { .. } => say("no Vulkan device: the kernels are not compiled"),
    }
    if args.json {
        println!("{}", serde_json::to_string(&inspection)?);
    } else {
        print!("{}", inspection.text());
    }
    Ok(Exit::Done)
}
