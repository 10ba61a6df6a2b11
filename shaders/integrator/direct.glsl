// The lecture's reflection equation: emission seen directly plus one bounce, without roulette. See src/integrator/direct.rs.
// MAX_DEPTH is 2 at most, so that a path goes on after its first edge only.
bool integrator_goes_on(inout PathState s, bool goes_on) {
    return goes_on;
}
