//! The reference of a study: a file, or rendered once with seeds of its own and kept.
//!
//! Its own noise is known from its blocks (the EXR's variance layer) and is subtracted from every squared error, whose expectation
//! holds it (Whittle, Jones, Mantiuk 2017: a noisy reference flattens curves). Where it is more than a tenth of what is
//! measured, the page says so.

use std::path::Path;

use crate::error::Error;
use crate::film::Film;
use crate::integrator::Settings;
use crate::metric::error::EPSILON;
use crate::output::exr;
use crate::output::image::{self, Picture};
use crate::prepare;
use crate::scene::Scene;
use crate::shader::tables;

/// Samples of the reference over those of the longest run, at least.
pub const FACTOR: f64 = 32.0;
/// Seeds of references are far from those of replicates, which count up from a small number.
pub const SEED: u32 = 0xa110_ca7e;

/// Names the reference of a scene as prepared, and of the settings that change its expected image.
pub fn fingerprint(scene: &Scene, settings: &Settings) -> Result<String, Error> {
    let prepared = prepare::prepare(scene, settings).map_err(|e| Error::Scene(format!("{}: {e}", scene.name)))?;
    let integrator = format!("{:?}-{}", settings.integrator, settings.edges()).to_lowercase();
    Ok(format!("{integrator}-{}", &tables::fingerprint(&prepared)[..16]))
}

/// What images are compared with.
#[derive(Clone, Debug)]
pub struct Reference {
    pub picture: Picture,
    /// Of each pixel's mean, where it is known.
    pub variance: Option<Vec<[f32; 3]>>,
    /// Expected relMSE between the reference and the truth; None where it is not known.
    pub noise: Option<f64>,
    /// Samples a pixel, where they are known.
    pub spp: Option<u64>,
    /// The file.
    pub source: String,
}

impl Reference {
    /// From a file; an EXR with a `variance` layer knows its noise.
    pub fn read(path: &Path) -> Result<Self, Error> {
        let picture = image::read(path)?;
        let is_exr = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("exr"));
        let layer = |names: [&str; 3]| if is_exr { exr::read_channels(path, names) } else { Ok(None) };
        let variance = layer(["variance.R", "variance.G", "variance.B"])?;
        let spp = layer(["samples", "samples", "samples"])?.map(|s| s.iter().map(|p| p[0] as u64).min().unwrap_or(0));
        Ok(Self::new(picture, variance, spp, path.display().to_string()))
    }

    pub fn of_film(film: &Film, source: String) -> Self {
        let variance = (0..film.pixel_count()).map(|i| film.variance_of_mean(i).map(|v| v as f32)).collect();
        let spp = u64::from(film.min_block_count()) * 16;
        Self::new(Picture::of_film(film), Some(variance), Some(spp), source)
    }

    fn new(picture: Picture, variance: Option<Vec<[f32; 3]>>, spp: Option<u64>, source: String) -> Self {
        let variance = variance.filter(|v| v.iter().flatten().all(|x| x.is_finite()));
        let noise = variance.as_ref().map(|v| {
            let term = |(p, v): (&[f32; 3], &[f32; 3])| {
                (0..3).map(|c| f64::from(v[c]) / (f64::from(p[c]).powi(2) + EPSILON)).sum::<f64>() / 3.0
            };
            picture.pixels.iter().zip(v).map(term).sum::<f64>() / picture.pixels.len() as f64
        });
        Self { picture, variance, noise, spp, source }
    }

    /// Of the mean over all pixels and channels, W/(m2 sr).
    pub fn standard_error_of_mean(&self) -> Option<f64> {
        let variance = self.variance.as_ref()?;
        // Channels of a pixel move together: their standard errors are added, not their variances.
        let pixel = |v: &[f32; 3]| (v.iter().map(|x| f64::from(*x).sqrt()).sum::<f64>() / 3.0).powi(2);
        Some(variance.iter().map(pixel).sum::<f64>().sqrt() / variance.len() as f64)
    }
}
