//! Integrators: how a path turns into radiance, and the settings that kernels and the oracle share.
//!
//! One integrator is one file here, one GLSL file of the same stem and one line in `integrator_list!`. `path` is the whole
//! light transport; `direct` is the lecture's reflection equation. Both run the same loop (`reference::path` in f64,
//! shaders/integrator in GLSL); an integrator says which of the settings hold and supplies the pieces.

use crate::film::aov::Aovs;

pub mod direct;
pub mod path;

/// Which techniques find the light, and how they are weighed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, clap::ValueEnum, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Estimator {
    /// Emission found by BSDF sampling only.
    Bsdf,
    /// Emission found by light sampling only, except where no light sampling can find it (camera rays, delta lobes).
    Light,
    /// Both, weighed by the power heuristic (Veach 1997, section 9.2.4, beta = 2).
    Mis,
}

/// Which sequence feeds the path.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, clap::ValueEnum, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SamplerKind {
    /// Owen-scrambled Sobol, padded (Burley 2020).
    Sobol,
    /// Hashed counters, no stratification.
    Independent,
}

/// Whether meshes that are placed several times are kept once.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, clap::ValueEnum, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Instancing {
    /// Where it saves enough memory to pay for the time; see `prepare::instances`.
    #[default]
    Auto,
    /// Wherever a mesh is used twice.
    Always,
    /// All geometry is flat.
    Never,
}

/// What the command line calls an integrator, and what the documentation says of it.
#[derive(Clone, Copy, Debug)]
pub struct Integrator {
    pub keyword: &'static str,
    pub doc: &'static str,
    /// No path has more edges than this, whatever `Settings::max_depth` says.
    pub max_edges: u32,
    pub has_roulette: bool,
}

macro_rules! integrator_list {
    ($($stem:ident $variant:ident),* $(,)?) => {
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, clap::ValueEnum, serde::Serialize, serde::Deserialize)]
        #[serde(rename_all = "kebab-case")]
        pub enum IntegratorKind { $($variant),* }

        impl IntegratorKind {
            pub const ALL: &'static [Self] = &[$(Self::$variant),*];
            pub fn description(self) -> Integrator {
                match self { $(Self::$variant => $stem::INTEGRATOR),* }
            }
        }
    };
}

integrator_list! {
    path Path,
    direct Direct,
}

/// Everything about a render, besides the scene, that changes its expected image or its random numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    pub integrator: IntegratorKind,
    pub estimator: Estimator,
    pub sampler: SamplerKind,
    /// Path edges: 1 = emission seen directly, 2 = one bounce. See `edges()`.
    pub max_depth: u32,
    /// Roulette is played after every edge from this one on. See `first_roulette_edge()`.
    pub roulette_edge: u32,
    pub seed: u32,
    /// What is stored beside radiance.
    pub aovs: Aovs,
    pub instancing: Instancing,
}

/// Default of `Settings::max_depth`; what it cuts is counted in the ledger.
pub const DEFAULT_MAX_DEPTH: u32 = 4096;

impl Default for Settings {
    fn default() -> Self {
        Self {
            integrator: IntegratorKind::Path,
            estimator: Estimator::Mis,
            sampler: SamplerKind::Sobol,
            max_depth: DEFAULT_MAX_DEPTH,
            roulette_edge: 4,
            seed: 0,
            aovs: Aovs::NONE,
            instancing: Instancing::Auto,
        }
    }
}

impl Settings {
    /// Largest number of edges of a path, after the integrator's own limit.
    pub fn edges(&self) -> u32 {
        self.max_depth.min(self.integrator.description().max_edges)
    }

    /// First edge after which roulette is played; `u32::MAX` for never.
    pub fn first_roulette_edge(&self) -> u32 {
        if self.integrator.description().has_roulette { self.roulette_edge } else { u32::MAX }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn direct_is_two_edges_without_roulette() {
        let settings = Settings { integrator: IntegratorKind::Direct, ..Settings::default() };
        assert_eq!((settings.edges(), settings.first_roulette_edge()), (2, u32::MAX));
        assert_eq!(Settings { max_depth: 1, ..settings }.edges(), 1);
    }
}
