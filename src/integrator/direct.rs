//! The lecture's reflection equation (Kajiya 1986, eq. 1, cut after one scattering): emission, plus light that is scattered
//! once towards the viewer. Two edges at most, no roulette; what longer paths would bring is counted in the ledger as `depth`.

use super::Integrator;

pub const INTEGRATOR: Integrator = Integrator {
    keyword: "direct",
    doc: "emission and one bounce: the reflection equation",
    max_edges: 2,
    has_roulette: false,
};
