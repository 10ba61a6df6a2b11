//! Command line: one file a command. A flag that is not built yet is not accepted.

/// Instead of std's of these names, which panic where stdout is closed or full: see `out`. Before the modules, so that all have them.
macro_rules! println {
    ($($text:tt)*) => { $crate::cli::out::write(format_args!("{}\n", format_args!($($text)*))) };
}
macro_rules! print {
    ($($text:tt)*) => { $crate::cli::out::write(format_args!($($text)*)) };
}

mod bands;
mod bench;
mod bench_error;
mod compare;
mod conform;
mod converge;
mod devices;
mod files;
mod generate;
mod inspect;
mod interrupt;
mod keep;
mod measure;
mod merge;
mod out;
mod progress;
mod render;
mod scene_args;
mod source;

use std::fmt::Display;
use std::io::Write;
use std::process::ExitCode;
use std::time::Instant;

use clap::{Parser, Subcommand};

/// A headless, progressive Monte Carlo renderer whose every number can be checked.
#[derive(Parser)]
#[command(name = "steradian", version, arg_required_else_help = true)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Renders a scene (.toml, .gltf, .glb, .obj, .ply) to images
    Render(Box<render::Args>),
    /// Lists the devices that can render
    Devices(devices::Args),
    /// Says what a scene needs, what its kernel leaves out, and what that saved
    Inspect(inspect::Args),
    /// Runs the gates on a device and writes a report
    Conform(conform::Args),
    /// Error against run time: variants, replicates, plots and a page
    Converge(converge::Args),
    /// Measures rates on generated scenes; JSON lines
    Bench(bench::Args),
    /// Makes the generated scenes again: the showcase, the peers', a million stones; and the contact sheet of models
    Generate(generate::Args),
    /// Reads the scene's sensors: value, interval, unit
    Measure(measure::Args),
    /// Measures the error of image A against reference B
    Compare(compare::Args),
    /// Adds ranges of samples (render --samples) up to the picture of one run
    Merge(merge::Args),
}

/// How a command ended, when it was not an error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exit {
    Done,
    CheckFailed,
    Interrupted,
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        ExitCode::from(match exit {
            Exit::Done => 0,
            Exit::CheckFailed => 1,
            Exit::Interrupted => 130,
        })
    }
}

/// Parses the command line and runs the command. `started` is the start of the process.
pub fn run(started: Instant) -> anyhow::Result<Exit> {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) if !error.use_stderr() => {
            out::note(error.print());
            return out::finish(Exit::Done);
        }
        Err(error) if error.kind() == clap::error::ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => error.exit(),
        Err(error) => anyhow::bail!(one_sentence(&error)),
    };
    interrupt::survive_file_limit()?;
    let exit = match cli.command {
        Command::Render(args) => render::run(&args, started),
        Command::Devices(args) => devices::run(&args),
        Command::Inspect(args) => inspect::run(&args),
        Command::Conform(args) => conform::run(&args),
        Command::Converge(args) => converge::run(&args),
        Command::Bench(args) => bench::run(&args),
        Command::Measure(args) => measure::run(&args),
        Command::Generate(args) => generate::run(&args),
        Command::Compare(args) => compare::run(&args),
        Command::Merge(args) => merge::run(&args),
    }?;
    out::finish(exit)
}

/// A line on stderr that begins with the program's name.
pub fn say(message: impl Display) {
    // Where stderr is closed there is nobody to tell.
    let _ = writeln!(std::io::stderr(), "steradian: {message}");
}

/// clap's message without its usage text: its lines joined.
fn one_sentence(error: &clap::Error) -> String {
    let text = error.to_string();
    let is_usage = |line: &&str| line.starts_with("Usage:") || line.starts_with("For more");
    let lines = text.lines().map(str::trim).take_while(|line| !is_usage(line)).filter(|line| !line.is_empty());
    let parts: Vec<&str> = lines.map(|line| line.trim_start_matches("error: ").trim_start_matches("tip: ")).collect();
    format!("{}; see --help", parts.join("; ").replace(":;", ":"))
}

/// `640x480`, each 1..=65536.
pub fn parse_size(text: &str) -> Result<(u32, u32), String> {
    let parts = text.split_once(['x', 'X']).and_then(|(w, h)| Some((w.parse::<u32>().ok()?, h.parse::<u32>().ok()?)));
    match parts {
        Some((w, h)) if (1..=65536).contains(&w) && (1..=65536).contains(&h) => Ok((w, h)),
        Some(_) => Err("width and height are 1 to 65536 pixels each".into()),
        None => Err("write it as WIDTHxHEIGHT, such as 640x480".into()),
    }
}

/// `X0,Y0,X1,Y1` in whole pixels.
pub fn parse_crop(text: &str) -> Result<[u32; 4], String> {
    let numbers: Option<Vec<u32>> = text.split(',').map(|part| part.trim().parse().ok()).collect();
    let edges = numbers.and_then(|n| <[u32; 4]>::try_from(n).ok());
    edges.ok_or_else(|| "write it as X0,Y0,X1,Y1 in whole pixels, such as 0,0,320,240".into())
}

/// Bytes, with K, M, G or T for powers of 1024.
pub fn parse_bytes(text: &str) -> Result<u64, String> {
    let digits = text.trim_end_matches(['K', 'M', 'G', 'T', 'k', 'm', 'g', 't']);
    let shift = match text[digits.len()..].to_ascii_uppercase().as_str() {
        "" => Some(0),
        "K" => Some(10),
        "M" => Some(20),
        "G" => Some(30),
        "T" => Some(40),
        _ => None,
    };
    let bytes = shift.and_then(|s| Some((digits.parse::<f64>().ok()?, s)));
    match bytes {
        Some((number, shift)) if number > 0.0 && number <= 1e9 => Ok((number * f64::from(shift).exp2()) as u64),
        _ => Err("write bytes as a number with K, M, G or T, such as 512M".into()),
    }
}

/// A finite number above 0.
pub fn parse_positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && value > 0.0 => Ok(value),
        _ => Err("a number above 0 is needed".into()),
    }
}

/// A finite number.
pub fn parse_finite(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err("a finite number is needed".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_parser_is_sound() {
        use clap::CommandFactory;
        Cli::command().debug_assert();
    }

    #[test]
    fn sizes() {
        assert_eq!(parse_size("640x480"), Ok((640, 480)));
        for wrong in ["0x5", "5x0", "65537x1", "640", "x", "-1x5", "1e3x5", "640x480x3"] {
            assert!(parse_size(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_wrong_flag_is_one_sentence() {
        let error = Cli::try_parse_from(["steradian", "compare", "a", "b", "--jason"]).err().unwrap();
        let text = one_sentence(&error);
        assert!(text.starts_with("unexpected argument '--jason' found") && !text.contains('\n'), "{text}");
    }
}
