//! Integrators: how samples of the light's path space become a pixel. Settings here are shared by kernel and oracle.
//!
//! `path` is progressive path tracing with next-event estimation; `direct` is the lecture's reflection equation (one bounce).

/// Everything about a render that changes its expected image or its random numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    pub integrator: IntegratorKind,
    pub estimator: Estimator,
    pub sampler: SamplerKind,
    /// Path edges: 1 = emission seen directly, 2 = one bounce.
    pub max_depth: u32,
    /// Roulette begins after this many edges.
    pub roulette_edge: u32,
    pub seed: u32,
    /// Albedo, normal and depth are recorded too.
    pub aovs: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            integrator: IntegratorKind::Path,
            estimator: Estimator::Mis,
            sampler: SamplerKind::Sobol,
            max_depth: 4096,
            roulette_edge: 4,
            seed: 0,
            aovs: false,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, clap::ValueEnum, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum IntegratorKind {
    Path,
    Direct,
}

/// How direct light is estimated: by BSDF sampling alone, by light sampling alone, or by both (multiple importance sampling).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, clap::ValueEnum, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Estimator {
    Bsdf,
    Light,
    Mis,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, clap::ValueEnum, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SamplerKind {
    Sobol,
    Independent,
}
