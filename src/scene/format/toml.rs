//! The project's own scene format, documented key by key in docs/scene.md (generated from `keys`).
//!
//! Degrees and colours as people write them come in here; the scene holds radians and linear values. Files are found
//! beside the scene file, or in a folder that an environment variable names. Order: textures, materials, models, shapes, then patches of what models brought.

mod camera;
mod copies;
mod film;
mod group;
pub mod keys;
mod light;
mod material;
mod mixture;
mod model;
mod sensor;
mod shape;
mod table;
#[cfg(test)]
mod tests;
mod transform;

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use super::image_file;
use super::tangents;
use crate::math::spectrum::LUMEN_PER_WATT;
use crate::scene::{Encoding, Error, Filter, Minify, Scene, Sky, SkyRadiance, Texture, Wrap};
use ::toml::de::DeTable;
pub use table::nearest;
use table::{Source, Table};

pub(crate) use material::{plain as plain_material, uv_transform};
pub(crate) use transform::is_invertible;

/// What is being built, with the names that the file gave to textures and materials.
struct Builder<'a> {
    source: Source<'a>,
    folder: &'a Path,
    scene: Scene,
    textures: HashMap<String, usize>,
    materials: HashMap<String, usize>,
    /// Copies of materials in other light groups.
    grouped: HashMap<(usize, String), usize>,
}

pub fn load(path: &Path) -> Result<Scene, Error> {
    let bytes = super::read_bytes(path)?;
    let text = String::from_utf8(bytes).map_err(|e| Error::Format {
        path: path.to_path_buf(),
        reason: format!("byte {} is no UTF-8 text; save the scene as UTF-8", e.utf8_error().valid_up_to()),
    })?;
    parse(&text, path)
}

/// `path` is for messages, and its folder is where files are looked for.
pub fn parse(text: &str, path: &Path) -> Result<Scene, Error> {
    let source = Source { path, text };
    let root = DeTable::parse(text).map_err(|e| {
        let reason = e.message().lines().collect::<Vec<_>>().join(", ");
        source.error(e.span().unwrap_or(0..0), format!("this is not TOML: {reason}"))
    })?;
    let top = Table::over(source, keys::TOP.name, 0..0, root.get_ref());
    top.check_keys(&[&keys::TOP], &[])?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut builder = Builder {
        source,
        folder,
        scene: Scene::default(),
        textures: HashMap::new(),
        materials: HashMap::new(),
        grouped: HashMap::new(),
    };
    builder.scene.name = top.text("name")?.unwrap_or_default().to_string();
    builder.film(&top)?;
    for item in top.tables("texture")? {
        builder.texture(&Table::open(source, item, &[&keys::TEXTURE], &[])?)?;
    }
    let patches = builder.materials(&top)?;
    let brought = builder.models(&top)?;
    for item in top.tables("shape")? {
        builder.shape(item)?;
    }
    for item in top.tables("light")? {
        builder.light(item)?;
    }
    builder.patch_materials(&patches, &brought)?;
    builder.patch_nodes(&top, &brought)?;
    tangents::complete(&mut builder.scene);
    builder.camera(&top)?;
    builder.sensors(&top)?;
    builder.sky(&top)?;
    builder.note_dark_groups(&top)?;
    Ok(builder.scene)
}

impl<'a> Builder<'a> {
    fn sky(&mut self, top: &Table<'a>) -> Result<(), Error> {
        let Some(item) = top.get("sky") else { return Ok(()) };
        let table = Table::open(self.source, item, &[&keys::SKY], &[])?;
        let measures = [light::Measure("radiance", false, 1.0), light::Measure("radiance_nt", true, 1.0)];
        let key = if table.get("radiance").is_some() { "radiance" } else { "radiance_nt" };
        let radiance = match (table.text("file")?, light::strength(&table, &measures, None)?) {
            (Some(_), Some(_)) => return Err(table.error(key, "stands beside `file`; keep one of the two")),
            (None, None) => return Err(table.missing("radiance` or `file")),
            (None, Some(radiance)) => SkyRadiance::Uniform(radiance),
            (Some(file), None) => {
                let image = image_file::read_sky(&self.path(&table, "file", file)?, &mut self.scene.notes)
                    .map_err(|e| table.error("file", format!("cannot be used: {e}")))?;
                self.scene.images.push(image);
                SkyRadiance::Image(self.scene.images.len() - 1)
            }
        };
        let mut scale = table.number("scale")?.unwrap_or(1.0);
        if scale < 0.0 {
            return Err(table.error("scale", "must not be negative"));
        }
        if choice(&table, "unit", &[("radiance", false), ("nt", true)])? {
            if matches!(radiance, SkyRadiance::Uniform(_)) {
                return Err(table.error("unit", "is that of the pixels of `file`; write `radiance_nt` instead"));
            }
            scale /= LUMEN_PER_WATT;
        }
        if matches!(radiance, SkyRadiance::Uniform(_)) && table.get("rotate_deg").is_some() {
            return Err(table
                .error("rotate_deg", "turns the picture of `file`, and this sky is the same all around; remove it"));
        }
        let rotation_rad = table.number("rotate_deg")?.unwrap_or(0.0).to_radians();
        let mut sky = Sky { radiance, rotation_rad, scale };
        if let Some(lux) = table.number("illuminance_lx")? {
            let now = sky.horizontal_irradiance(&self.scene.images);
            if lux < 0.0 || table.get("scale").is_some() || table.get("unit").is_some() {
                return Err(table.error("illuminance_lx", "must not be negative, nor stand beside `scale` or `unit`"));
            }
            if now <= 0.0 {
                return Err(table.error("illuminance_lx", "is asked of a sky whose upper half is black"));
            }
            sky.scale *= lux / LUMEN_PER_WATT / now;
        }
        let key = if table.get("illuminance_lx").is_some() { "illuminance_lx" } else { "scale" };
        sky.check(&self.scene.images).map_err(|reason| table.error(key, reason))?;
        self.sky_group(&table, &sky)?;
        self.scene.sky = Some(sky);
        Ok(())
    }

    fn texture(&mut self, table: &Table<'a>) -> Result<(), Error> {
        let name = table.text("name")?.ok_or_else(|| table.missing("name"))?;
        let color = |key| table.get(key).map(|item| material::color(table, key, item)).transpose();
        let kind = table.text("type")?.unwrap_or("image");
        if let Some((key, _)) = TEXTURE_KEYS.iter().find(|(key, owner)| table.get(key).is_some() && *owner != kind)
            && TEXTURE_KEYS.iter().any(|(_, owner)| *owner == kind)
        {
            return Err(table.error(key, format!("is no key of a texture of type \"{kind}\"; remove it")));
        }
        let texture = match kind {
            "image" => {
                let file = table.text("file")?.ok_or_else(|| table.missing("file"))?;
                let path = self.path(table, "file", file)?;
                let unusable = |reason: String| table.error("file", format!("cannot be used: {reason}"));
                let bytes = super::read_bytes(&path).map_err(|e| unusable(e.to_string()))?;
                let image = image_file::decode_any(&bytes, file, &mut self.scene.notes).map_err(unusable)?;
                self.scene.images.push(image);
                Texture::Image {
                    image: self.scene.images.len() - 1,
                    wrap: wrap(table)?,
                    filter: choice(table, "filter", &FILTERS)?,
                    minify: Minify {
                        filter: choice(table, "filter", &FILTERS)?,
                        levels: choice(table, "mipmap", &LEVELS)?,
                    },
                    encoding: choice(table, "encoding", &[("srgb", Encoding::Srgb), ("linear", Encoding::Linear)])?,
                }
            }
            "checker" => Texture::Checker {
                a: color("a")?.unwrap_or([0.8, 0.8, 0.8, 1.0]),
                b: color("b")?.unwrap_or([0.2, 0.2, 0.2, 1.0]),
                scale: table.splat("squares")?.unwrap_or([8.0; 2]),
            },
            "constant" => Texture::Constant(color("color")?.ok_or_else(|| table.missing("color"))?),
            _ => return Err(table.error("type", "must be \"image\", \"checker\" or \"constant\"")),
        };
        if self.textures.insert(name.to_string(), self.scene.textures.len()).is_some() {
            return Err(table.error("name", format!("\"{name}\" is taken by another texture; choose another")));
        }
        self.scene.textures.push(texture);
        Ok(())
    }

    /// A file named in the scene: beside it, unless the name begins with `$NAME/`, an environment variable that holds a folder.
    fn path(&self, table: &Table<'a>, key: &str, file: &str) -> Result<PathBuf, Error> {
        let Some((name, rest)) = file.strip_prefix('$').and_then(|f| f.split_once('/')) else {
            return Ok(self.folder.join(file));
        };
        let folder = std::env::var_os(name).filter(|f| !f.is_empty()).ok_or_else(|| {
            table.error(
                key,
                format!("begins with the environment variable {name}, which is not set; set it to the folder"),
            )
        })?;
        Ok(PathBuf::from(folder).join(rest))
    }

    /// The place of a name in a map, or an error that names the nearest.
    fn named(&self, map: &HashMap<String, usize>, table: &Table<'a>, key: &str, name: &str) -> Result<usize, Error> {
        map.get(name).copied().ok_or_else(|| {
            let mut names: Vec<&str> = map.keys().map(String::as_str).collect();
            names.sort_unstable();
            table.error(
                key,
                format!("is \"{name}\", which the file does not define; {}", nearest(name, names.into_iter())),
            )
        })
    }
}

/// Keys of textures that only one type has.
const TEXTURE_KEYS: [(&str, &str); 9] = [
    ("file", "image"),
    ("wrap", "image"),
    ("filter", "image"),
    ("mipmap", "image"),
    ("encoding", "image"),
    ("a", "checker"),
    ("b", "checker"),
    ("squares", "checker"),
    ("color", "constant"),
];

const FILTERS: [(&str, Filter); 2] = [("linear", Filter::Linear), ("nearest", Filter::Nearest)];
const LEVELS: [(&str, Option<Filter>); 3] =
    [("linear", Some(Filter::Linear)), ("nearest", Some(Filter::Nearest)), ("none", None)];

fn wrap(table: &Table<'_>) -> Result<[Wrap; 2], Error> {
    let parse = |text: &str| match text {
        "repeat" => Ok(Wrap::Repeat),
        "mirror" => Ok(Wrap::Mirror),
        "clamp" => Ok(Wrap::Clamp),
        _ => Err(table.error("wrap", "must be \"repeat\", \"mirror\" or \"clamp\", or two of them in [ ]")),
    };
    let Some(item) = table.get("wrap") else { return Ok([Wrap::Repeat; 2]) };
    let Some(array) = item.get_ref().as_array() else {
        return Ok([parse(item.get_ref().as_str().unwrap_or(""))?; 2]);
    };
    let words: Vec<_> = array.iter().map(|i| parse(i.get_ref().as_str().unwrap_or(""))).collect::<Result<_, _>>()?;
    words.try_into().map_err(|_| table.error("wrap", "must be one word, or two in [ ]"))
}

/// One of some words; the first when the key is missing.
fn choice<T: Copy>(table: &Table<'_>, key: &str, options: &[(&str, T)]) -> Result<T, Error> {
    let Some(word) = table.text(key)? else { return Ok(options[0].1) };
    options.iter().find(|o| o.0 == word).map(|o| o.1).ok_or_else(|| {
        let words: Vec<_> = options.iter().map(|o| format!("\"{}\"", o.0)).collect();
        table.error(key, format!("must be {}", words.join(" or ")))
    })
}
