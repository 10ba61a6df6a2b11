//! `compare A B`: every measure of metric::error, as text or JSON; a map of where the error is.

use std::path::PathBuf;

use steradian::metric::error::{self, Errors};
use steradian::output::{self, image};

use super::Exit;

#[derive(clap::Args)]
pub struct Args {
    /// Image to judge (.exr, .png, .hdr)
    image: PathBuf,
    /// Reference it is judged by
    reference: PathBuf,
    /// One JSON object on stdout
    #[arg(long)]
    json: bool,
    /// Writes a map of each pixel's relMSE as .png: black below 1e-4, white above 1
    #[arg(short, long = "output", value_name = "FILE")]
    output: Option<PathBuf>,
    /// Exit code 1 when relMSE is above this, or a pixel is not finite
    #[arg(long, value_name = "E", value_parser = super::parse_positive)]
    max_relmse: Option<f64>,
}

pub fn run(args: &Args) -> anyhow::Result<Exit> {
    if let Some(path) = &args.output {
        anyhow::ensure!(
            output::Format::of(path)? == output::Format::Png,
            "{}: the error map is written as .png",
            path.display()
        );
        output::check(path)?;
    }
    let (a, b) = (image::read(&args.image)?, image::read(&args.reference)?);
    anyhow::ensure!(
        (a.width, a.height) == (b.width, b.height),
        "{} is {}x{} and {} is {}x{}: only images of one size are compared",
        args.image.display(),
        a.width,
        a.height,
        args.reference.display(),
        b.width,
        b.height
    );
    let errors = error::compare(&a.pixels, &b.pixels, a.width as usize);
    if args.json {
        println!("{}", serde_json::to_string(&errors)?);
    } else {
        print!("{}", table(&errors));
    }
    if let Some(path) = &args.output {
        let terms = a.pixels.iter().zip(&b.pixels).map(|(x, r)| error::relative_square(*x, *r, error::EPSILON));
        let bytes: Vec<u8> = terms.flat_map(|e| error::map_color(error::decades(e))).collect();
        image::write_rgb8(path, a.width, a.height, &bytes)?;
    }
    let is_past = args.max_relmse.is_some_and(|limit| errors.relmse > limit || errors.nonfinite > 0);
    Ok(if is_past { Exit::CheckFailed } else { Exit::Done })
}

fn table(e: &Errors) -> String {
    let mut text = String::new();
    for (name, value, meaning) in [
        ("relMSE", e.relmse, "mean of (x-r)^2/(r^2 + 0.01)"),
        ("relMSE exposure", e.relmse_exposure, "the same with epsilon (0.1 mean r)^2"),
        ("relMSE trimmed", e.relmse_trimmed, "the first without the worst 0.1 % of pixels"),
        ("RMSE", e.rmse, "W/(m2 sr)"),
        ("bias", e.bias, "mean of x - r, W/(m2 sr)"),
        ("FLIP", e.flip, "mean LDR-FLIP of both cut to [0, 1]"),
        ("FLIP HDR", e.flip_hdr, "mean HDR-FLIP, the worst over exposures"),
        ("reference mean", e.reference_mean, "W/(m2 sr)"),
    ] {
        text += &format!("{name:<16} {value:>13.6e}  {meaning}\n");
    }
    if e.nonfinite > 0 {
        text += &format!("{:<16} {:>13}  pixels left out: NaN or infinite\n", "not finite", e.nonfinite);
    }
    text
}
