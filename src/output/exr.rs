//! OpenEXR: every AOV as named channels of one part, 32-bit float; units and the record in the header.
//!
//! Channels follow film::aov::AOVS: `R G B`, `albedo.R`, `normal.X`, `depth.Z`, `CryptoObject00.r`, `variance.R`, `samples`. Attributes:
//! `unit.<channel>` (text), `steradian.record` (the record as JSON), and what Cryptomattes need.

use std::path::Path;

use exr::prelude::*;
use rayon::prelude::*;

use super::image::Picture;
use super::record::Record;
use crate::error::Error;
use crate::film::Film;
use crate::film::aov;

/// Header attribute that holds the record.
pub const RECORD_ATTRIBUTE: &str = "steradian.record";

pub fn write(path: &Path, film: &Film, record: &Record) -> std::result::Result<(), Error> {
    let mut channels: SmallVec<[AnyChannel<FlatSamples>; 4]> = SmallVec::new();
    let mut attributes = LayerAttributes { software_name: Some(record.program.as_str().into()), ..Default::default() };
    for channel in aov::channels(film, film.names()) {
        let unit = AttributeValue::Text(channel.unit.into());
        attributes.other.insert(format!("unit.{}", channel.name).as_str().into(), unit);
        let samples = FlatSamples::F32((0..film.pixel_count()).into_par_iter().map(&channel.value).collect());
        // Ids are no colours: nothing may quantize them.
        channels.push(AnyChannel { quantize_linearly: true, ..AnyChannel::new(channel.name.as_str(), samples) });
    }
    for (name, text) in aov::attributes(film.aovs(), film.names()) {
        attributes.other.insert(name.as_str().into(), AttributeValue::Text(text.as_str().into()));
    }
    let json = serde_json::to_string(record).map_err(|e| Error::file(path, format!("cannot write its record: {e}")))?;
    attributes.other.insert(RECORD_ATTRIBUTE.into(), AttributeValue::Text(json.as_str().into()));
    let size = (film.width() as usize, film.height() as usize);
    // A crop says where it lies in the whole image.
    let window = film.window();
    attributes.layer_position = Vec2(window.x as i32, window.y as i32);
    let layer = Layer::new(size, attributes, Encoding::FAST_LOSSLESS, AnyChannels::sort(channels));
    let mut image = Image::from_layer(layer);
    let whole = Vec2(record.width.max(window.x + window.width), record.height.max(window.y + window.height));
    image.attributes.display_window = IntegerBounds::from_dimensions(Vec2(whole.0 as usize, whole.1 as usize));
    super::replace(path, |beside| {
        image.write().to_file(beside).map_err(|e| match e {
            exr::error::Error::Io(e) => Error::io("write", path, e),
            other => Error::file(path, format!("cannot write: {other}")),
        })
    })
}

/// R, G, B of the first layer that has them (or Y alone), and whatever record is in the header.
pub fn read(path: &Path) -> std::result::Result<Picture, Error> {
    let image = read_all(path)?;
    let layer = &image.layer_data;
    let channel = |name: &str| layer.channel_data.list.iter().find(|c| c.name.eq(name));
    let rgb = ["R", "G", "B"].map(|name| channel(name).or_else(|| channel("Y")));
    let [Some(r), Some(g), Some(b)] = rgb else {
        return Err(Error::file(path, "no channels R, G, B in its first layer"));
    };
    let count = layer.size.width() * layer.size.height();
    let pixels = (0..count).map(|i| [r, g, b].map(|c| c.sample_data.value_by_flat_index(i).to_f32())).collect();
    Ok(Picture { width: layer.size.width() as u32, height: layer.size.height() as u32, pixels })
}

/// Three channels of the first layer by name, as floats; None when one of them is not there.
pub fn read_channels(path: &Path, names: [&str; 3]) -> std::result::Result<Option<Vec<[f32; 3]>>, Error> {
    let image = read_all(path)?;
    let list = &image.layer_data.channel_data.list;
    let [Some(a), Some(b), Some(c)] = names.map(|name| list.iter().find(|c| c.name.eq(name))) else { return Ok(None) };
    let count = image.layer_data.size.width() * image.layer_data.size.height();
    Ok(Some((0..count).map(|i| [a, b, c].map(|c| c.sample_data.value_by_flat_index(i).to_f32())).collect()))
}

/// The record's JSON from the header, if there is one.
pub fn read_record(path: &Path) -> std::result::Result<Option<String>, Error> {
    let image = read_all(path)?;
    let value = image.layer_data.attributes.other.get(&Text::from(RECORD_ATTRIBUTE));
    Ok(value.and_then(|v| if let AttributeValue::Text(text) = v { Some(text.to_string()) } else { None }))
}

type FlatImage = Image<Layer<AnyChannels<FlatSamples>>>;

fn read_all(path: &Path) -> std::result::Result<FlatImage, Error> {
    let reader = exr::prelude::read().no_deep_data().largest_resolution_level().all_channels();
    reader.first_valid_layer().all_attributes().from_file(path).map_err(|e| match e {
        exr::error::Error::Io(e) => Error::io("read", path, e),
        other => Error::file(path, format!("cannot read the picture: {other}")),
    })
}
