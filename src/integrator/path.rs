//! Unidirectional path tracing: the f64 pieces of the loop (multiple importance sampling, roulette).
//!
//! Veach 1997, "Robust Monte Carlo methods for light transport simulation": power heuristic (section 9.2.4), roulette
//! (section 10.4.1). The survival probability looks at the throughput without the radiance compression of refraction
//! (its (eta_i/eta_t)^2, section 5.2), so that a path inside glass is not ended for a factor it gets back on leaving.

use super::Integrator;
use glam::DVec3;

pub const INTEGRATOR: Integrator = Integrator {
    keyword: "path",
    doc: "all light transport, by unidirectional path tracing",
    max_edges: u32::MAX,
    has_roulette: true,
};

/// Surfaces that are not there by their alpha, passed by one ray before the next is taken as there, which the ledger counts.
pub const ALPHA_LAYERS: u32 = 256;

/// Lowest survival probability: bounds the factor 1/q by 20, and with it the fireflies that roulette makes.
pub const SURVIVAL_MIN: f64 = 0.05;

/// Weight of a technique with density `own` against one with density `other`, both per solid angle and including the
/// probability of choosing the light. Power heuristic with beta = 2, in the ratio form that cannot overflow before `own` does.
pub fn power_heuristic(own: f64, other: f64) -> f64 {
    if own <= 0.0 {
        return 0.0;
    }
    let ratio = other / own;
    1.0 / (1.0 + ratio * ratio)
}

/// Probability that a path goes on, in [SURVIVAL_MIN, 1]. `eta_scale`: product of the refractions' `BsdfSample::eta_scale`.
pub fn survival_probability(throughput: DVec3, eta_scale: f64) -> f64 {
    (throughput / eta_scale).max_element().clamp(SURVIVAL_MIN, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_of_two_techniques_sum_to_one() {
        for (a, b) in [(1.0, 1.0), (1e-3, 10.0), (1e200, 1e-200), (2.0, 0.0)] {
            let sum = power_heuristic(a, b) + power_heuristic(b, a);
            assert!((sum - 1.0).abs() < 1e-15, "{a} {b}: {sum}");
        }
    }

    #[test]
    fn survival_ignores_the_compression_of_refraction() {
        let scale = 1.0 / (1.5 * 1.5);
        assert_eq!(survival_probability(DVec3::splat(scale), scale), 1.0);
        assert_eq!(survival_probability(DVec3::ZERO, 1.0), SURVIVAL_MIN);
    }
}
