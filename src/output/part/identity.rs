//! What two films must have in common to be films of one render: program, device family, settings, scene.

use serde::{Deserialize, Serialize};

use crate::film::source::DeviceInfo;
use crate::integrator::Settings;
use crate::prepare::Prepared;
use crate::scene::Scene;
use crate::shader::tables;

/// Version, and the hash of all sources that a sample can depend on: two builds may differ in their samples and not in their version.
pub const PROGRAM: &str = concat!("steradian ", env!("CARGO_PKG_VERSION"), " of sources ", env!("STERADIAN_SOURCES"));

#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Identity {
    /// Program, version and sources.
    pub program: String,
    /// Kind of device and its driver, without versions: "software llvmpipe".
    pub device_family: String,
    /// Every choice that the picture depends on, by its flag.
    pub settings: Vec<(String, String)>,
    /// Hash of the prepared scene.
    pub scene: String,
}

/// The first thing that is not the same.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Difference {
    Scene,
    /// What it is, ours, and the other's.
    Value {
        what: String,
        ours: String,
        theirs: String,
    },
}

impl Identity {
    /// `settings.aovs` are those that the film keeps: a kernel with everything in it keeps more than were asked for.
    pub fn new(scene: &Scene, fingerprint: String, settings: &Settings, device: &DeviceInfo) -> Self {
        Self {
            program: PROGRAM.into(),
            device_family: device.family.clone(),
            settings: settings_of(scene, settings),
            scene: fingerprint,
        }
    }

    pub fn setting(&self, flag: &str) -> Option<&str> {
        self.settings.iter().find(|(name, _)| name == flag).map(|(_, value)| value.as_str())
    }

    pub fn difference(&self, other: &Self) -> Option<Difference> {
        let differs = |what: &str, ours: &str, theirs: &str| {
            let (what, ours, theirs) = (what.into(), ours.into(), theirs.into());
            (ours != theirs).then_some(Difference::Value { what, ours, theirs })
        };
        let of_setting =
            |(flag, ours): &(String, String)| differs(flag, ours, other.setting(flag).unwrap_or("nothing"));
        differs("version", &self.program, &other.program)
            .or_else(|| differs("device", &self.device_family, &other.device_family))
            .or_else(|| self.settings.iter().find_map(of_setting))
            .or_else(|| (self.scene != other.scene).then_some(Difference::Scene))
    }
}

/// The hash of what a scene's picture depends on: all tables, and where their origin lies.
pub fn fingerprint(prepared: &Prepared) -> String {
    let origin = prepared.origin.to_array().map(|v| format!("{:x}", v.to_bits())).join("-");
    format!("{}-{origin}", tables::fingerprint(prepared))
}

fn settings_of(scene: &Scene, settings: &Settings) -> Vec<(String, String)> {
    // Named one by one: a new one does not compile until it is listed.
    let Settings { integrator, estimator, sampler, max_depth, roulette_edge, seed, aovs, instancing } = *settings;
    let film = &scene.film;
    let crop = film.crop.map_or("none".into(), |c| format!("{},{},{},{}", c.x, c.y, c.x + c.width, c.y + c.height));
    let list = [
        ("--seed", seed.to_string()),
        ("--size", format!("{}x{}", film.width, film.height)),
        ("--crop", crop),
        ("--aov", aovs.list()),
        ("--sampler", keyword(sampler)),
        ("--integrator", keyword(integrator)),
        ("--estimator", keyword(estimator)),
        ("--max-depth", max_depth.to_string()),
        ("--pixel-filter", film.filter.kind.keyword().into()),
        ("--filter-radius", film.filter.radius.to_string()),
        ("--texture-filter", keyword(scene.texture_filter)),
        ("--instances", keyword(instancing)),
        ("roulette", roulette_edge.to_string()),
    ];
    list.map(|(flag, value)| (flag.to_owned(), value)).to_vec()
}

/// The word that the command line knows a choice by.
pub fn keyword(value: impl clap::ValueEnum) -> String {
    value.to_possible_value().map_or(String::new(), |v| v.get_name().into())
}
