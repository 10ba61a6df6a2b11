//! AOVs: what a render stores beside radiance. One row of `AOVS` each; kernel text, slots, oracle and EXR follow the table.
//!
//! What is not asked for is neither in the kernel nor in the slots (`Aovs`, `layout`). Ids with coverage are Cryptomattes
//! (`cryptomatte`). Tests: film/tests.rs, output/tests.rs; the device against both modes of the oracle: `conform::aov`.

pub mod cryptomatte;
pub mod layout;

use glam::DVec3;

use super::Film;
use crate::reference::path::{FirstHit, Sample};
use crate::scene::Scene;
pub use layout::{Block, Layout};

/// One layer of the EXR.
pub struct Aov {
    /// What `--aov` calls it, and its layer; empty for the colour itself.
    pub name: &'static str,
    /// Channel names inside the layer; "" where the layer is one channel of its own name.
    pub channels: &'static [&'static str],
    pub unit: &'static str,
    pub doc: &'static str,
    pub source: Source,
}

/// Where an AOV's numbers come from. GLSL and oracle state the same quantity on their own.
pub enum Source {
    /// The film's sums of radiance.
    Film(fn(&Film, usize) -> [f64; 3]),
    /// A vec3 at the first surface, from `s`, `surface`, `shading` and `hit`.
    Surface { glsl: &'static str, value: fn(&FirstHit) -> DVec3, mean: Mean },
    /// A vec3 of the finished path, from `s`.
    Path { glsl: &'static str, value: fn(&Sample) -> DVec3 },
    /// The light of each light group of the scene, one vec3 of the finished path each.
    Groups,
    /// A number for each sample: how often each occurs.
    Ids { glsl: &'static str, value: fn(&FirstHit) -> u32 },
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mean {
    /// Over all samples; those that hit nothing are 0.
    OfSamples,
    /// Over the samples that hit; what it is where none did.
    OfHits { missing: f32 },
    /// Over the samples that hit, moved by the film's origin; 0 where none did.
    Place,
}

macro_rules! surface {
    ($name:literal, $channels:expr, $unit:literal, $mean:expr, $glsl:literal, $value:expr, $doc:literal) => {
        Aov {
            name: $name,
            channels: &$channels,
            unit: $unit,
            doc: $doc,
            source: Source::Surface { glsl: $glsl, value: $value, mean: $mean },
        }
    };
}

const RGB: [&str; 3] = ["R", "G", "B"];
const XYZ: [&str; 3] = ["X", "Y", "Z"];
const RADIANCE: &str = "W/(m^2 sr)";

/// Name of the row of light groups.
pub const GROUPS: &str = "light_groups";
/// Most light groups that slots hold.
pub const GROUP_LIMIT: usize = 16;

/// Every layer, in slot order.
pub const AOVS: &[Aov] = &[
    Aov {
        name: "",
        channels: &RGB,
        unit: RADIANCE,
        doc: "radiance",
        source: Source::Film(|film, pixel| film.mean(pixel)),
    },
    surface!(
        "albedo",
        RGB,
        "1",
        Mean::OfSamples,
        "bsdf_albedo(shading.lobes)",
        |hit| hit.albedo,
        "share of light that the first surface scatters"
    ),
    surface!(
        "normal",
        XYZ,
        "1",
        Mean::OfSamples,
        "shading.frame.n",
        |hit| hit.normal,
        "shading normal, on the viewer's side where nothing is transmitted"
    ),
    surface!(
        "geometric_normal",
        XYZ,
        "1",
        Mean::OfSamples,
        "shading.ng",
        |hit| hit.geometric_normal,
        "normal of the shape itself, on the same side"
    ),
    surface!("position", XYZ, "m", Mean::Place, "surface.p", |hit| hit.position, "where the surface lies in the world"),
    surface!(
        "uv",
        ["U", "V"],
        "1",
        Mean::OfHits { missing: 0.0 },
        "vec3(surface.point.uv0, 0.0)",
        |hit| hit.uv.extend(0.0),
        "first set of texture coordinates"
    ),
    surface!(
        "depth",
        ["Z"],
        "m",
        Mean::OfHits { missing: f32::INFINITY },
        "vec3(hit.t, 0.0, 0.0)",
        |hit| DVec3::new(hit.depth, 0.0, 0.0),
        "distance along the ray; infinite where nothing is"
    ),
    Aov {
        name: "direct",
        channels: &RGB,
        unit: RADIANCE,
        doc: "emission that is seen, and light scattered once",
        source: Source::Path { glsl: "s.direct", value: |sample| sample.direct },
    },
    Aov {
        name: "indirect",
        channels: &RGB,
        unit: RADIANCE,
        doc: "light scattered more than once",
        source: Source::Path { glsl: "s.radiance - s.direct", value: |sample| sample.radiance - sample.direct },
    },
    Aov {
        name: GROUPS,
        channels: &RGB,
        unit: RADIANCE,
        doc: "light by light group, a layer `light.GROUP` each: their sum is radiance",
        source: Source::Groups,
    },
    Aov {
        name: "object",
        channels: &[],
        unit: "1",
        doc: "Cryptomatte CryptoObject: names of shapes and their coverage",
        source: Source::Ids { glsl: "hit.primitive", value: |hit| hit.object },
    },
    Aov {
        name: "material",
        channels: &[],
        unit: "1",
        doc: "Cryptomatte CryptoMaterial: names of materials and their coverage",
        source: Source::Ids { glsl: "surface.material", value: |hit| hit.material },
    },
    Aov {
        // Of the mean, so that its root is the standard error; infinite below two blocks.
        name: "variance",
        channels: &RGB,
        unit: "(W/(m^2 sr))^2",
        doc: "of the pixel's mean",
        source: Source::Film(|film, pixel| film.variance_of_mean(pixel)),
    },
    Aov {
        name: "samples",
        channels: &[""],
        unit: "1",
        doc: "samples taken",
        source: Source::Film(|film, pixel| [f64::from(film.block_count(pixel) * super::slot::BLOCK_SAMPLES), 0.0, 0.0]),
    },
];

const _: () = assert!(AOVS.len() <= Aovs::GROUPS_SHIFT as usize, "a bit for each row");

/// Row of the AOV of this name.
///
/// # Panics
/// When there is none: names are those of the table.
pub fn index_of(name: &str) -> usize {
    AOVS.iter().position(|a| a.name == name).expect("a name of the table")
}

/// A choice of rows of `AOVS`; the colour is always there. The upper bits say how many light groups the scene has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Aovs(u32);

impl Aovs {
    pub const NONE: Self = Self(0);
    /// Every row but the colour's, the first, so that what is written as a list and read again is the same choice.
    pub const ALL: Self = Self((1 << AOVS.len()) - 2);
    /// Where the number of light groups begins.
    const GROUPS_SHIFT: u32 = 24;

    /// What an EXR holds unless something else is asked for.
    pub fn usual() -> Self {
        ["albedo", "normal", "depth", "variance", "samples"].into_iter().fold(Self::NONE, Self::with)
    }

    /// `name` added; a name that is none changes nothing.
    pub fn with(self, name: &str) -> Self {
        AOVS.iter().position(|a| a.name == name).map_or(self, |index| Self(self.0 | 1 << index))
    }

    /// `name` left out.
    pub fn without(self, name: &str) -> Self {
        AOVS.iter().position(|a| a.name == name).map_or(self, |index| Self(self.0 & !(1 << index)))
    }

    pub fn has(self, name: &str) -> bool {
        self == self.with(name)
    }

    /// As `--aov` takes it: names with commas, or none.
    pub fn list(self) -> String {
        let names: Vec<&str> = self.iter().map(|(_, a)| a.name).filter(|name| !name.is_empty()).collect();
        if names.is_empty() { "none".into() } else { names.join(",") }
    }

    /// The same choice with room for `count` light groups, if it has their row at all.
    pub fn with_groups(self, count: u32) -> Self {
        let rows = self.0 & ((1 << Self::GROUPS_SHIFT) - 1);
        Self(rows | if self.has(GROUPS) { count.min(255) << Self::GROUPS_SHIFT } else { 0 })
    }

    /// The same choice for the groups of `scene`; the error says that there are too many.
    pub fn of_scene(self, scene: &Scene) -> Result<Self, String> {
        if !self.has(GROUPS) {
            return Ok(self);
        }
        match scene.light_groups().len() {
            count if count > GROUP_LIMIT => Err(format!(
                "--aov: the scene has {count} light groups, more than the {GROUP_LIMIT} that {GROUPS} holds; let some lights share one"
            )),
            count => Ok(self.with_groups(count as u32)),
        }
    }

    /// Light groups that slots hold.
    pub fn group_count(self) -> u32 {
        self.0 >> Self::GROUPS_SHIFT
    }

    /// "all", "none", or names with commas between them. The error names the nearest.
    pub fn parse(text: &str) -> Result<Self, String> {
        let names = || AOVS.iter().map(|a| a.name).filter(|n| !n.is_empty());
        let mut chosen = Self::NONE;
        for word in text.split(',').map(str::trim) {
            match word {
                "all" => chosen = Self::ALL,
                "none" => {}
                _ if names().any(|n| n == word) => chosen = chosen.with(word),
                _ => {
                    let near =
                        names().max_by(|a, b| strsim::jaro_winkler(word, a).total_cmp(&strsim::jaro_winkler(word, b)));
                    let known: Vec<&str> = names().collect();
                    let near = near.unwrap_or_default();
                    return Err(format!("\"{word}\" is no AOV; did you mean {near}? Known are {}", known.join(", ")));
                }
            }
        }
        Ok(chosen)
    }

    /// The rows chosen, with their places in `AOVS`.
    pub fn iter(self) -> impl Iterator<Item = (usize, &'static Aov)> {
        AOVS.iter().enumerate().filter(move |(index, _)| self.0 >> index & 1 == 1)
    }

    /// Some row needs the slots.
    pub fn in_slots(self) -> bool {
        self.iter().any(|(_, a)| !matches!(a.source, Source::Film(_)))
    }
}

/// Names behind the numbers of a film, and where its world's origin lies.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Names {
    pub objects: Vec<String>,
    pub materials: Vec<String>,
    /// Of the light groups, by number.
    pub groups: Vec<String>,
    /// Added to positions, m.
    pub origin: DVec3,
}

/// One channel of the file.
pub struct Channel<'a> {
    pub name: String,
    pub unit: &'static str,
    /// By pixel of the film.
    pub value: Box<dyn Fn(usize) -> f32 + Sync + 'a>,
}

/// Every channel of a film, in table order.
pub fn channels<'a>(film: &'a Film, names: &'a Names) -> Vec<Channel<'a>> {
    let mut list = Vec::new();
    for (index, aov) in film.aovs().with("").iter() {
        if let Source::Groups = aov.source {
            list.extend(group_channels(film, index, aov, names));
            continue;
        }
        for (c, channel) in aov.channels.iter().enumerate() {
            let name = match (aov.name, *channel) {
                ("", channel) => channel.into(),
                (layer, "") => layer.into(),
                (layer, channel) => format!("{layer}.{channel}"),
            };
            let value: Box<dyn Fn(usize) -> f32 + Sync> = match &aov.source {
                Source::Film(value) => Box::new(move |pixel| value(film, pixel)[c] as f32),
                Source::Surface { mean: Mean::Place, .. } => Box::new(move |pixel| {
                    let place = film.aov_mean(index, pixel).unwrap_or_default()[c];
                    (if film.hit_share(pixel) > 0.0 { place + names.origin[c] } else { 0.0 }) as f32
                }),
                _ => Box::new(move |pixel| film.aov_mean(index, pixel).unwrap_or_default()[c] as f32),
            };
            list.push(Channel { name, unit: aov.unit, value });
        }
        if let Source::Ids { .. } = aov.source {
            list.extend(cryptomatte::channels(film, index, cryptomatte::names_of(aov, names)));
        }
    }
    list
}

/// `light.GROUP.R` and so on, group by group.
fn group_channels<'a>(film: &'a Film, index: usize, aov: &Aov, names: &Names) -> Vec<Channel<'a>> {
    let part_count = film.aovs().group_count() as usize;
    let parts = (0..part_count).flat_map(|part| (0..3).map(move |c| (part, c)));
    let channel = |(part, c): (usize, usize)| Channel {
        name: format!("light.{}.{}", names.groups.get(part).map_or("", String::as_str), aov.channels[c]),
        unit: aov.unit,
        value: Box::new(move |pixel| film.part_mean(index, part, pixel).unwrap_or_default()[c] as f32),
    };
    parts.map(channel).collect()
}

/// Header attributes of a film's Cryptomattes: name and text.
pub fn attributes(aovs: Aovs, names: &Names) -> Vec<(String, String)> {
    let ids = aovs.iter().filter(|(_, a)| matches!(a.source, Source::Ids { .. }));
    ids.flat_map(|(_, a)| cryptomatte::attributes(a, cryptomatte::names_of(a, names))).collect()
}
