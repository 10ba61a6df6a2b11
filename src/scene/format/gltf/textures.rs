//! Images and textures of a glTF file: those that a used material looks up, decoded in parallel.

use std::collections::HashMap;

use glam::DVec2;
use rayon::prelude::*;

use super::buffers::File;
use super::container::{resolve, shorten};
use super::document::{Image as ImageEntry, TextureInfo};
use crate::scene::format::image_file;
use crate::scene::format::toml::uv_transform;
use crate::scene::{Encoding, Error, Filter, Image, Minify, Scene, Texture, Value, Wrap};

/// From the file's numbers to the scene's.
#[derive(Default)]
pub struct Textures {
    images: HashMap<usize, usize>,
    textures: HashMap<(usize, Encoding), usize>,
}

impl Textures {
    /// Decodes the images behind `used` textures (numbers in the file, ascending).
    pub fn read(file: &File<'_>, used: &[usize], scene: &mut Scene) -> Result<Self, Error> {
        let mut sources = Vec::new();
        for texture in used {
            sources.push(image_of(file, *texture)?);
        }
        sources.sort_unstable();
        sources.dedup();
        let decoded: Vec<Result<Image, Error>> = sources.par_iter().map(|i| read_image(file, *i)).collect();
        let mut images = HashMap::new();
        for (source, result) in sources.into_iter().zip(decoded) {
            images.insert(source, scene.images.len());
            scene.images.push(result?);
        }
        Ok(Self { images, textures: HashMap::new() })
    }

    /// A look-up of the texture that `info` names.
    pub fn value(
        &mut self,
        file: &File<'_>,
        info: &TextureInfo,
        encoding: Encoding,
        scene: &mut Scene,
    ) -> Result<Value, Error> {
        let texture = match self.textures.get(&(info.index, encoding)) {
            Some(texture) => *texture,
            None => {
                let image = self.images[&image_of(file, info.index)?];
                scene.textures.push(describe(file, info.index, image, encoding, &mut scene.notes)?);
                self.textures.insert((info.index, encoding), scene.textures.len() - 1);
                scene.textures.len() - 1
            }
        };
        let uv_transform = match &info.extensions.transform {
            Some(t) => uv_transform(DVec2::from(t.offset), t.rotation, DVec2::from(t.scale)),
            None => glam::DAffine2::IDENTITY,
        };
        let uv_set = match info.uv_set() {
            set @ 0..=1 => set as u8,
            set => {
                scene.notes.push(format!(
                    "texture {}: coordinate set {set} left out, set 0 taken (0 and 1 are read)",
                    info.index
                ));
                0
            }
        };
        Ok(Value::Texture { texture, uv_set, uv_transform })
    }
}

/// The image behind a texture; WebP where the file offers it in place of another.
fn image_of(file: &File<'_>, texture: usize) -> Result<usize, Error> {
    let entry = file.at(&file.document.textures, texture, "texture", "a material")?;
    let webp = entry.extensions.webp.as_ref().and_then(|w| w.source);
    let source = entry.source.or(webp).ok_or_else(|| {
        file.error(format!("texture {texture}"), "names no image that can be read (PNG, JPEG, WebP); convert its image")
    })?;
    file.at(&file.document.images, source, "image", &format!("texture {texture}"))?;
    Ok(source)
}

fn read_image(file: &File<'_>, index: usize) -> Result<Image, Error> {
    let entry = &file.document.images[index];
    let name = image_name(entry, index);
    let place = format!("image {index}");
    let decode = |bytes: &[u8]| image_file::decode(bytes, &name).map_err(|reason| file.error(&place, reason));
    match (&entry.uri, entry.buffer_view) {
        (Some(uri), _) => decode(&resolve(file.path, uri).map_err(|reason| file.error(&place, reason))?),
        (None, Some(view)) => decode(file.view(view, &place)?),
        (None, None) => Err(file.error(place, "has neither a file nor a buffer view; export it again")),
    }
}

fn image_name(entry: &ImageEntry, index: usize) -> String {
    match (&entry.name, &entry.uri) {
        (Some(name), _) => format!("\"{name}\""),
        (None, Some(uri)) if !uri.starts_with("data:") => shorten(uri),
        _ => index.to_string(),
    }
}

fn describe(
    file: &File<'_>,
    texture: usize,
    image: usize,
    encoding: Encoding,
    notes: &mut Vec<String>,
) -> Result<Texture, Error> {
    let entry = &file.document.textures[texture];
    let default = Default::default();
    let sampler = match entry.sampler {
        Some(sampler) => file.at(&file.document.samplers, sampler, "sampler", &format!("texture {texture}"))?,
        None => &default,
    };
    let mut wrap = |code| match code {
        33071 => Wrap::Clamp,
        33648 => Wrap::Mirror,
        10497 => Wrap::Repeat,
        other => {
            notes.push(format!("texture {texture}: wrap mode {other} does not exist, repeat taken"));
            Wrap::Repeat
        }
    };
    let wrap = [wrap(sampler.wrap_s), wrap(sampler.wrap_t)];
    // 9728 is NEAREST.
    let filter = if sampler.mag_filter == Some(9728) { Filter::Nearest } else { Filter::Linear };
    let minify = |filter, levels| Minify { filter, levels };
    let minify = match sampler.min_filter {
        None | Some(9987) => Minify::default(),
        Some(9728) => minify(Filter::Nearest, None),
        Some(9729) => minify(Filter::Linear, None),
        Some(9984) => minify(Filter::Nearest, Some(Filter::Nearest)),
        Some(9985) => minify(Filter::Linear, Some(Filter::Nearest)),
        Some(9986) => minify(Filter::Nearest, Some(Filter::Linear)),
        Some(other) => {
            notes.push(format!("texture {texture}: minification filter {other} does not exist, trilinear taken"));
            Minify::default()
        }
    };
    Ok(Texture::Image { image, wrap, filter, minify, encoding })
}
