//! What a render writes: checked before anything else is done, and the layers that it asks of the film.

use std::path::{Path, PathBuf};

use steradian::film::aov::{Aovs, GROUPS};
use steradian::output::part::{self, Header};
use steradian::output::{self, Format};
use steradian::scene::Scene;

use super::Args;
use crate::cli::files;

pub struct Outputs {
    pub pictures: Vec<PathBuf>,
    pub parts: Vec<PathBuf>,
    /// Of the file to go on from.
    pub resumed: Option<Header>,
    /// The film is kept in a checkpoint or a part.
    pub keeps: bool,
}

impl Outputs {
    /// Fails where a file could not be written, or would take the place of another that this command reads or writes.
    pub fn check(args: &Args) -> anyhow::Result<Self> {
        let outputs =
            if args.output.is_empty() { vec![default_output(&args.scene.scene)] } else { args.output.clone() };
        for path in &outputs {
            files::check_output(path)?;
        }
        if let Some(path) = &args.record {
            output::check(path)?;
        }
        let of_scene = [Some(args.scene.scene.as_path()), args.scene.sky.env.as_deref()];
        // A checkpoint may take the place of the one that was read.
        let other = args.keep.resume.as_deref().filter(|_| args.keep.checkpoint.is_some());
        let checkpoint =
            args.keep.place().filter(|path| other.is_none_or(|from| files::place(from) != files::place(path)));
        let written = outputs.iter().chain(&args.record).map(PathBuf::as_path).chain(checkpoint);
        files::no_file_twice(of_scene.into_iter().chain([other]).flatten(), written)?;
        let resumed = args.keep.resumed()?;
        let (parts, pictures): (Vec<_>, Vec<_>) = outputs.into_iter().partition(|path| part::is_part(path));
        anyhow::ensure!(
            !(args.adaptive && args.keep.samples.is_some()),
            "--adaptive: how many samples a pixel gets follows from those before, so that no range stands alone: leave out --samples, or --adaptive"
        );
        let keeps = args.keep.is_used() || !parts.is_empty();
        Ok(Self { pictures, parts, resumed, keeps })
    }

    /// Layers of the film beside radiance. Fails where a flag is for files that are not written.
    pub fn layers(&self, args: &Args, scene: &Scene) -> anyhow::Result<Aovs> {
        let has = |format| self.pictures.iter().any(|path| Format::of(path).is_ok_and(|f| f == format));
        let has_part = !self.parts.is_empty() || args.keep.place().is_some();
        for (flag, is_given) in [("--exposure", args.exposure.is_some()), ("--tonemap", args.tonemap.is_some())] {
            anyhow::ensure!(
                !is_given || has(Format::Png) || has_part,
                "{flag} is for .png files, and none is written; others hold radiance"
            );
        }
        let aovs = match (&args.aov, &self.resumed) {
            (Some(chosen), _) if has(Format::Exr) || has_part || *chosen == Aovs::NONE => *chosen,
            (Some(_), _) => anyhow::bail!("--aov is for .exr files, and none is written"),
            (None, Some(header)) => header.aovs().unwrap_or_default(),
            (None, None) if has(Format::Exr) || !self.parts.is_empty() => Aovs::usual(),
            (None, None) => Aovs::NONE,
        };
        // A kernel with everything in it makes every layer, and the scene's tables must have what they show. More groups than slots hold are left out.
        match args.kernel.everything() {
            true => Ok(Aovs::ALL.of_scene(scene).unwrap_or(Aovs::ALL.without(GROUPS))),
            false => aovs.of_scene(scene).map_err(anyhow::Error::msg),
        }
    }
}

/// `helmet.png` for `models/helmet.gltf`, in the current folder.
fn default_output(scene: &Path) -> PathBuf {
    PathBuf::from(scene.file_stem().unwrap_or("render".as_ref())).with_extension("png")
}
