//! `generate showcase`: makes the generated files of scenes/ again.

use std::path::PathBuf;

use steradian::output::write_atomically;
use steradian::showcase;

use super::Exit;

#[derive(clap::Args)]
pub struct Args {
    #[command(subcommand)]
    what: What,
}

#[derive(clap::Subcommand)]
enum What {
    /// The model and the sky of scenes/showcase.toml
    Showcase {
        /// Folder to write into
        #[arg(short, long, value_name = "DIR")]
        output: PathBuf,
    },
}

pub fn run(args: &Args) -> anyhow::Result<Exit> {
    let What::Showcase { output } = &args.what;
    for (name, bytes) in showcase::files() {
        let path = output.join(name);
        write_atomically(&path, &bytes)?;
        println!("wrote {} ({} bytes)", path.display(), bytes.len());
    }
    Ok(Exit::Done)
}
