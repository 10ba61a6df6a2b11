//! `generate`: makes the generated files of scenes/, those of the showcase, which are committed, and those of the peers' scenes;
//! `generate stones`, a scene of a million placed meshes; and `generate sheet`, pictures of all sample models on one page.

use std::path::{Path, PathBuf};
use std::time::Instant;

use steradian::conform::models;
use steradian::integrator::Settings;
use steradian::output::image::Picture;
use steradian::output::{palette, write_atomically};
use steradian::render::{self, Stops};
use steradian::report::sheet;
use steradian::showcase;

use super::{Exit, source};

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
    /// The statue of scenes/peer_b.toml and the sky of scenes/peer_c.toml
    Peers {
        /// Folder to write into
        #[arg(short, long, value_name = "DIR")]
        output: PathBuf,
    },
    /// stones.toml: a beach of placed stones, and the files it reads; some 90 bytes a stone
    Stones {
        /// Folder to write into
        #[arg(short, long, value_name = "DIR")]
        output: PathBuf,
        /// How many
        #[arg(long, value_name = "N", default_value_t = 1_000_000, value_parser = clap::value_parser!(u32).range(1..=100_000_000))]
        count: u32,
    },
    /// A contact sheet of every model below gltf/ of the assets folder, numbered in the order of their names; a PNG of 256 colours
    Sheet {
        /// PNG to write
        #[arg(short, long, value_name = "FILE")]
        output: PathBuf,
        #[arg(long, value_name = "WxH", default_value = "128x96", value_parser = super::parse_size)]
        size: (u32, u32),
        /// Samples a pixel
        #[arg(long, value_name = "N", default_value_t = 1024, value_parser = clap::value_parser!(u32).range(1..))]
        spp: u32,
        /// Pictures in a row
        #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u16).range(1..=100))]
        columns: u16,
        #[arg(long, value_name = "D", default_value = "auto")]
        device: String,
    },
}

fn write<N: AsRef<Path>>(folder: &Path, files: Vec<(N, Vec<u8>)>) -> anyhow::Result<()> {
    std::fs::create_dir_all(folder)
        .map_err(|e| anyhow::anyhow!("{}: cannot make the folder: {e}", folder.display()))?;
    for (name, bytes) in files {
        let path = folder.join(name.as_ref());
        write_atomically(&path, &bytes)?;
        println!("wrote {} ({} bytes)", path.display(), bytes.len());
    }
    Ok(())
}

pub fn run(args: &Args) -> anyhow::Result<Exit> {
    match &args.what {
        What::Showcase { output } => write(output, showcase::files())?,
        What::Peers { output } => write(output, showcase::peer_files())?,
        What::Stones { output, count } => write(output, showcase::stones::files(*count))?,
        What::Sheet { output, size, spp, columns, device } => {
            let pictures = pictures([size.0, size.1], *spp, device)?;
            let (width, height, bytes) = sheet::lay_out(&pictures, usize::from(*columns));
            // 256 colours: the sheet is kept beside the text, and a third of the bytes looks the same at this size.
            palette::write_png(output, width, height, &bytes)?;
            println!("wrote {}", output.display());
        }
    }
    Ok(Exit::Done)
}

/// Every sample model: flat ones from their front, which their makers mean to be looked at, others from the front right.
fn pictures(size: [u32; 2], spp: u32, device: &str) -> anyhow::Result<Vec<Picture>> {
    let folder = models::folder();
    let list = models::list(&folder);
    anyhow::ensure!(!list.is_empty(), "no models in {}: set STERADIAN_ASSETS", folder.join("gltf").display());
    let mut pictures = Vec::new();
    for path in list {
        let mut scene = models::framed(&path, &folder, size)?;
        models::face(&path, &mut scene)?;
        println!("{:3} {}", pictures.len() + 1, scene.name);
        scene.notes.iter().for_each(|note| println!("    {note}"));
        let options = source::Options { device, ..source::Options::default() };
        let mut opened = source::open(&scene, &Settings::default(), &options)?;
        let blocks = Some(render::blocks_for(u64::from(spp)));
        let stops = Stops { blocks, time_s: None, error: None, started: Instant::now() };
        let outcome = render::render(opened.source.as_mut(), &stops, &|| false, &mut |_| ())?;
        pictures.push(Picture::of_film(&outcome.film));
    }
    Ok(pictures)
}
