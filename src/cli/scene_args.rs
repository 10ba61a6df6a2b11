//! What commands share: the scene with the flags applied, its sky, and the settings of the transport.

use std::path::{Path, PathBuf};

use steradian::film::aov::Aovs;
use steradian::film::filter::{FilterKind, PixelFilter};
use steradian::integrator::{DEFAULT_MAX_DEPTH, Estimator, Instancing, IntegratorKind, SamplerKind, Settings};
use steradian::scene::{self, Film, Scene, Sky, SkyRadiance, TextureFilter};

#[derive(clap::Args)]
pub struct SceneArgs {
    /// Scene file: .toml, .gltf, .glb, .obj or .ply
    pub scene: PathBuf,
    /// Material variant of a glTF file (KHR_materials_variants); `inspect` lists their names
    #[arg(long, value_name = "NAME")]
    pub variant: Option<String>,
    /// Scene of a glTF file that holds several, counted from 0 [default: the file's]
    #[arg(long = "scene", value_name = "N")]
    pub scene_number: Option<usize>,
    /// How images are read where several of their texels fall into a pixel; else the scene's [default: exact]
    #[arg(long, value_name = "F")]
    pub texture_filter: Option<TextureFilter>,
    /// Image size in pixels; else the scene's
    #[arg(long, value_name = "WxH", value_parser = super::parse_size)]
    pub size: Option<(u32, u32)>,
    /// Renders only columns X0..X1 and rows Y0..Y1, X1 and Y1 excluded, each pixel as in the whole image
    #[arg(long, value_name = "X0,Y0,X1,Y1", value_parser = super::parse_crop)]
    pub crop: Option<[u32; 4]>,
    /// Pixel filter; else the scene's
    #[arg(long, value_name = "FILTER")]
    pub pixel_filter: Option<FilterKind>,
    /// Where the filter ends, in pixels [default: the scene's, else box 0.5, others 1.5]
    #[arg(long, value_name = "R", allow_negative_numbers = true)]
    pub filter_radius: Option<f64>,
    #[arg(long, default_value = "path")]
    pub integrator: IntegratorKind,
    #[command(flatten)]
    pub transport: TransportArgs,
    #[command(flatten)]
    pub sky: SkyArgs,
}

/// How paths are sampled.
#[derive(clap::Args)]
pub struct TransportArgs {
    #[arg(long, default_value = "mis")]
    pub estimator: Estimator,
    #[arg(long, default_value = "sobol")]
    pub sampler: SamplerKind,
    /// Path edges: 1 shows emission seen directly, 2 one bounce [default: the scene's, else 4096]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=65535))]
    pub max_depth: Option<u32>,
    #[arg(long, default_value_t = 0)]
    pub seed: u32,
    /// Whether meshes that are placed several times are kept once
    #[arg(long, default_value = "auto")]
    pub instances: Instancing,
}

impl TransportArgs {
    pub fn settings(&self, scene: &Scene) -> Settings {
        Settings {
            estimator: self.estimator,
            sampler: self.sampler,
            max_depth: self.max_depth.or(scene.film.max_depth).unwrap_or(DEFAULT_MAX_DEPTH),
            seed: self.seed,
            instancing: self.instances,
            ..Settings::default()
        }
    }
}

#[derive(clap::Args)]
pub struct SkyArgs {
    /// Sky instead of the scene's: a lat-long .hdr or .exr
    #[arg(long, value_name = "FILE")]
    pub env: Option<PathBuf>,
    /// Turns the sky about +y
    #[arg(long, value_name = "DEG", allow_negative_numbers = true, value_parser = super::parse_finite)]
    pub env_rotate: Option<f64>,
    /// Factor on the sky's radiance
    #[arg(long, value_name = "X", value_parser = super::parse_positive)]
    pub env_scale: Option<f64>,
}

impl SkyArgs {
    /// The scene with its sky as the flags want it.
    pub fn apply(&self, scene: &mut Scene) -> anyhow::Result<()> {
        if let Some(path) = &self.env {
            replace_sky(scene, path)?;
        }
        let source = scene.source.display().to_string();
        let sky = |scene: &mut Scene, flag: &str| -> anyhow::Result<Sky> {
            let no_sky = || anyhow::anyhow!("{flag}: {source} has no sky; give one with --env");
            scene.sky.take().ok_or_else(no_sky)
        };
        if let Some(degrees) = self.env_rotate {
            let mut turned = sky(scene, "--env-rotate")?;
            anyhow::ensure!(
                matches!(turned.radiance, SkyRadiance::Image(_)),
                "--env-rotate: the sky of {source} is the same all around; give one with --env"
            );
            turned.rotation_rad = degrees.to_radians();
            scene.sky = Some(turned);
        }
        if let Some(factor) = self.env_scale {
            let mut scaled = sky(scene, "--env-scale")?;
            scaled.scale *= factor;
            scaled.check(&scene.images).map_err(|reason| anyhow::anyhow!("--env-scale {reason}"))?;
            scene.sky = Some(scaled);
        }
        Ok(())
    }
}

impl SceneArgs {
    /// The scene as it will be rendered: flags applied, then a camera and a light where none is given.
    pub fn load(&self) -> anyhow::Result<Scene> {
        let integrator = self.integrator.description();
        if let Some(depth) = self.transport.max_depth.filter(|depth| *depth > integrator.max_edges) {
            anyhow::bail!(
                "--max-depth {depth}: --integrator {} has {} path edges at most; lower it, or leave it out",
                integrator.keyword,
                integrator.max_edges
            );
        }
        let choice = scene::Choice { variant: self.variant.as_deref(), scene: self.scene_number };
        let mut scene = scene::load_choice(&self.scene, choice)?;
        if let Some((width, height)) = self.size {
            (scene.film.width, scene.film.height) = (width, height);
        }
        self.film(&mut scene.film)?;
        if let Some(filter) = self.texture_filter {
            scene.texture_filter = filter;
        }
        self.sky.apply(&mut scene)?;
        scene::frame_camera(&mut scene);
        scene::ensure_light(&mut scene);
        Ok(scene)
    }

    /// Window and filter. A crop of the scene file must lie in the image that --size chose.
    fn film(&self, film: &mut Film) -> anyhow::Result<()> {
        let of_file = film.crop.map(|c| [c.x, c.y, c.x + c.width, c.y + c.height]);
        if let Some(edges) = self.crop.or(of_file) {
            let who = if self.crop.is_some() { "--crop" } else { "the scene's crop" };
            film.set_crop(edges).map_err(|reason| anyhow::anyhow!("{who} {reason}"))?;
        }
        if self.pixel_filter.is_some() || self.filter_radius.is_some() {
            let kind = self.pixel_filter.unwrap_or(film.filter.kind);
            film.filter = PixelFilter::new(kind, self.filter_radius)
                .map_err(|reason| anyhow::anyhow!("--filter-radius {reason}"))?;
        }
        Ok(())
    }

    pub fn settings(&self, scene: &Scene, aovs: Aovs) -> Settings {
        Settings { integrator: self.integrator, aovs, ..self.transport.settings(scene) }
    }
}

pub fn replace_sky(scene: &mut Scene, path: &Path) -> anyhow::Result<()> {
    let image = scene::format::image_file::read_sky(path, &mut scene.notes)?;
    scene.images.push(image);
    scene.sky = Some(Sky { radiance: SkyRadiance::Image(scene.images.len() - 1), rotation_rad: 0.0, scale: 1.0 });
    Ok(())
}
