//! .mtl files: what their keys become. The format describes a light model of 1990; this is the nearest surface of ours.
//!
//! | in the file | here |
//! |---|---|
//! | illum 4, 6, 7, 9 | `dielectric`, eta = Ni (1.5 where it is 1), smooth |
//! | illum 3, 5 with Kd = 0 | `gltf`, metallic 1, base colour Ks, roughness from Ns |
//! | Ks = 0, or illum 0 or 1, and neither Pr nor Pm | `lambert`, albedo Kd |
//! | else | `gltf`: base colour Kd, metallic Pm (0), roughness Pr or from Ns, ior Ni (1.5 where it is 1 or less) |
//! | Ke, map_Ke | emission of the front, W/(m2 sr) |
//! | map_Kd | times Kd, sRGB; alone where Kd is 0 |
//! | d, Tr = 1 - d, map_d | presence (not of a dielectric) |
//! | norm | normal map |
//!
//! Blinn and Phong's exponent becomes GGX's alpha = sqrt(2/(Ns + 2)) (Walter et al. 2007, section 5), and roughness = sqrt(alpha).
//! The size of Ks is not kept: glTF's dielectric reflects by its index. Kd of an exporter that wrote sRGB cannot be told, and is
//! taken as linear. Left out and noted: Ka, Tf, bump heights, and further maps.

use std::collections::{BTreeSet, HashMap};
use std::path::Path;

use glam::{DAffine2, DVec2};

use crate::bsdf::MODELS;
use crate::scene::format::image_file;
use crate::scene::format::toml::{plain_material, uv_transform};
use crate::scene::{Alpha, Encoding, Error, Filter, MAX_RADIANCE, Material, Minify, Scene, Texture, Value, Wrap};

/// The keys of one `newmtl`, as they stand.
#[derive(Clone, Default)]
struct Entry {
    kd: Option<[f64; 3]>,
    ks: [f64; 3],
    ke: [f64; 3],
    ns: f64,
    ni: f64,
    d: Option<f64>,
    pr: Option<f64>,
    pm: Option<f64>,
    illum: Option<u32>,
    map_kd: Option<Map>,
    map_ke: Option<Map>,
    map_d: Option<Map>,
    norm: Option<Map>,
}

/// A picture and how it lies.
#[derive(Clone)]
struct Map {
    file: String,
    scale: DVec2,
    offset: DVec2,
    is_clamped: bool,
}

/// Adds the materials that `used` names, once each; returns where each name went.
pub fn load(
    path: &Path,
    libraries: &[String],
    used: &[&str],
    scene: &mut Scene,
) -> Result<HashMap<String, usize>, Error> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut entries: HashMap<String, Entry> = HashMap::new();
    let mut left_out = BTreeSet::new();
    for library in libraries {
        let file = folder.join(library.replace('\\', "/"));
        match super::super::read_bytes(&file) {
            Ok(bytes) => parse(&file, &String::from_utf8_lossy(&bytes), &mut entries, &mut left_out)?,
            Err(_) => scene.notes.push(format!("material library {library} cannot be read; its materials are grey")),
        }
    }
    if !left_out.is_empty() {
        let keys: Vec<String> = left_out.into_iter().collect();
        scene.notes.push(format!("keys of the material library left out: {}", keys.join(", ")));
    }
    let mut textures = HashMap::new();
    let mut worn = HashMap::new();
    for name in used {
        if worn.contains_key(*name) {
            continue;
        }
        let material = match entries.get(*name) {
            Some(entry) => build(name, entry, folder, &mut textures, scene)?,
            None => {
                if !name.is_empty() {
                    scene.notes.push(format!("material \"{name}\" is not in the material library; it is grey"));
                }
                plain_material(if name.is_empty() { "default" } else { name }, model("lambert"))
            }
        };
        scene.materials.push(material);
        worn.insert((*name).to_owned(), scene.materials.len() - 1);
    }
    Ok(worn)
}

fn model(keyword: &str) -> usize {
    MODELS.iter().position(|m| m.keyword == keyword).expect("bsdf_list! holds the models that formats name")
}

fn set(material: &mut Material, input: &str, value: Value) {
    let place = MODELS[material.bsdf].inputs.iter().position(|i| i.name == input);
    material.inputs[place.expect("the model has the inputs that formats name")] = value;
}

fn parse(
    path: &Path,
    text: &str,
    entries: &mut HashMap<String, Entry>,
    left_out: &mut BTreeSet<String>,
) -> Result<(), Error> {
    let mut entry: Option<&mut Entry> = None;
    for (k, line) in text.lines().enumerate() {
        let line = line.split('#').next().unwrap_or("").trim();
        let Some(keyword) = line.split_ascii_whitespace().next() else { continue };
        let rest = line[keyword.len()..].trim();
        if keyword == "newmtl" {
            entry = Some(entries.entry(rest.to_owned()).or_default());
            continue;
        }
        let fail = |reason: String| Error::Text { path: path.to_path_buf(), line: k + 1, column: 1, reason };
        let Some(m) = entry.as_deref_mut() else { continue };
        let number = |least: f64, most: f64| -> Result<f64, Error> {
            let word = rest.split_ascii_whitespace().next().unwrap_or("");
            let x: f64 = word.parse().unwrap_or(f64::NAN);
            let wanted = || fail(format!("`{keyword}` must be a number from {least} to {}; correct it", short(most)));
            (least..=most).contains(&x).then_some(x).ok_or_else(wanted)
        };
        let color = |most: f64| -> Result<[f64; 3], Error> {
            let numbers: Vec<f64> = rest.split_ascii_whitespace().map(|w| w.parse().unwrap_or(f64::NAN)).collect();
            let rgb = match numbers[..] {
                [x] => [x; 3],
                [r, g, b, ..] => [r, g, b],
                _ => [f64::NAN; 3],
            };
            let is_good = rgb.iter().all(|c| (0.0..=most).contains(c));
            let wanted = || fail(format!("`{keyword}` must be three numbers from 0 to {}; correct it", short(most)));
            is_good.then_some(rgb).ok_or_else(wanted)
        };
        match keyword {
            "Kd" => m.kd = Some(color(1.0)?),
            "Ks" => m.ks = color(f64::MAX)?,
            "Ke" => m.ke = color(MAX_RADIANCE)?,
            "Ns" => m.ns = number(0.0, f64::MAX)?,
            "Ni" => m.ni = number(0.0, 10.0)?,
            "d" => m.d = Some(number(0.0, 1.0)?),
            "Tr" => m.d = Some(1.0 - number(0.0, 1.0)?),
            "Pr" => m.pr = Some(number(0.0, 1.0)?),
            "Pm" => m.pm = Some(number(0.0, 1.0)?),
            "illum" => m.illum = Some(number(0.0, 10.0)? as u32),
            "map_Kd" => m.map_kd = Some(map(rest)),
            "map_Ke" => m.map_ke = Some(map(rest)),
            "map_d" => m.map_d = Some(map(rest)),
            "norm" => m.norm = Some(map(rest)),
            // Ka has no meaning where light is computed; the transmission filter of an opaque surface none either.
            "Ka" | "Tf" | "sharpness" | "map_Ka" => {}
            other => {
                left_out.insert(other.chars().take(20).filter(|c| !c.is_control()).collect());
            }
        }
    }
    Ok(())
}

/// A number as people write it.
fn short(x: f64) -> String {
    if x < 1e6 { x.to_string() } else { format!("{x:e}") }
}

/// Options, then the file's name, which may hold spaces.
fn map(rest: &str) -> Map {
    let mut map = Map { file: String::new(), scale: DVec2::ONE, offset: DVec2::ZERO, is_clamped: false };
    let mut words = rest.split_ascii_whitespace().peekable();
    let mut last = None;
    while let Some(option) = words.peek().filter(|w| w.starts_with('-') && w.len() > 1).copied() {
        words.next();
        let mut vector = |default: f64| {
            let mut v = DVec2::splat(default);
            for k in 0..3 {
                let Some(x) = words.peek().and_then(|w| w.parse::<f64>().ok()).filter(|x| x.is_finite()) else { break };
                words.next();
                if k < 2 {
                    v[k] = x;
                }
            }
            v
        };
        match option {
            "-s" => map.scale = vector(1.0),
            "-o" => map.offset = vector(0.0),
            "-t" => drop(vector(0.0)),
            "-clamp" => map.is_clamped = words.next() == Some("on"),
            "-mm" => drop((words.next(), words.next())),
            // -blendu, -blendv, -cc, -bm, -boost, -texres, -imfchan, -type: one word each.
            _ => drop(words.next()),
        }
    }
    if let Some(first) = words.next() {
        last = Some(first.as_ptr() as usize - rest.as_ptr() as usize);
    }
    map.file = last.map_or("", |at| &rest[at..]).replace('\\', "/");
    map
}

fn build(
    name: &str,
    entry: &Entry,
    folder: &Path,
    textures: &mut HashMap<(String, bool, bool), usize>,
    scene: &mut Scene,
) -> Result<Material, Error> {
    let mut look_up = |map: &Map, encoding: Encoding| -> Result<Value, Error> {
        let key = (map.file.clone(), map.is_clamped, encoding == Encoding::Srgb);
        let texture = match textures.get(&key) {
            Some(texture) => *texture,
            None => {
                let path = folder.join(&map.file);
                let bytes = super::super::read_bytes(&path)?;
                let fail = |reason| Error::Image { path: path.clone(), reason };
                let image = image_file::decode_any(&bytes, &map.file, &mut scene.notes).map_err(fail)?;
                scene.images.push(image);
                let wrap = [if map.is_clamped { Wrap::Clamp } else { Wrap::Repeat }; 2];
                let image = scene.images.len() - 1;
                scene.textures.push(Texture::Image {
                    image,
                    wrap,
                    filter: Filter::Linear,
                    minify: Minify::default(),
                    encoding,
                });
                textures.insert(key, scene.textures.len() - 1);
                scene.textures.len() - 1
            }
        };
        Ok(Value::Texture { texture, uv_set: 0, uv_transform: upright(map) })
    };
    let kd = entry.kd.unwrap_or([0.5; 3]);
    let mut color = Value::rgb(kd[0], kd[1], kd[2]);
    if let Some(map) = &entry.map_kd {
        let texture = look_up(map, Encoding::Srgb)?;
        color = match kd {
            [1.0, 1.0, 1.0] | [0.0, 0.0, 0.0] => texture,
            _ if entry.kd.is_none() => texture,
            _ => Value::Multiply(Box::new(color), Box::new(texture)),
        };
    }
    // 1 is what exporters write who do not know.
    let ior = if entry.ni > 1.0 { entry.ni } else { 1.5 };
    let roughness = Value::scalar(entry.pr.unwrap_or((2.0 / (entry.ns + 2.0)).sqrt().sqrt()));
    let is_glass = matches!(entry.illum, Some(4 | 6 | 7 | 9));
    let is_mirror = matches!(entry.illum, Some(3 | 5)) && kd == [0.0; 3] && entry.map_kd.is_none();
    let is_plain = entry.ks == [0.0; 3] || matches!(entry.illum, Some(0 | 1));
    let mut material = if is_glass {
        let mut material = plain_material(name, model("dielectric"));
        set(&mut material, "eta", Value::scalar(ior));
        set(&mut material, "roughness", Value::scalar(0.0));
        material
    } else if is_plain && entry.pr.is_none() && entry.pm.is_none() {
        let mut material = plain_material(name, model("lambert"));
        set(&mut material, "albedo", color);
        material
    } else {
        let mut material = plain_material(name, model("gltf"));
        let ks = entry.ks.map(|c| c.min(1.0));
        set(&mut material, "base_color", if is_mirror { Value::rgb(ks[0], ks[1], ks[2]) } else { color });
        set(&mut material, "metallic", Value::scalar(if is_mirror { 1.0 } else { entry.pm.unwrap_or(0.0) }));
        set(&mut material, "roughness", roughness);
        set(&mut material, "ior", Value::scalar(ior));
        material
    };
    let d = entry.d.unwrap_or(1.0);
    if !is_glass && (d < 1.0 || entry.map_d.is_some()) {
        let mut value = Value::scalar(d);
        if let Some(map) = &entry.map_d {
            value = Value::Multiply(Box::new(value), Box::new(look_up(map, Encoding::Linear)?));
        }
        material.alpha = Alpha::Blend { value: Value::Channel(Box::new(value), 0) };
    }
    if entry.ke != [0.0; 3] || entry.map_ke.is_some() {
        let ke = if entry.ke == [0.0; 3] { [1.0; 3] } else { entry.ke };
        let mut emission = Value::rgb(ke[0], ke[1], ke[2]);
        if let Some(map) = &entry.map_ke {
            emission = Value::Multiply(Box::new(emission), Box::new(look_up(map, Encoding::Srgb)?));
        }
        material.emission = Some(emission);
    }
    if let Some(map) = &entry.norm {
        material.normal_map = Some((look_up(map, Encoding::Linear)?, 1.0));
    }
    Ok(material)
}

/// uv = offset + scale uv with v running up, as the file means it, for coordinates that run down: v' = 1 - v on both sides.
fn upright(map: &Map) -> DAffine2 {
    let offset = DVec2::new(map.offset.x, 1.0 - map.scale.y - map.offset.y);
    uv_transform(offset, 0.0, map.scale)
}
