// Progressive path tracing: roulette after every edge from ROULETTE_EDGE on. See src/integrator/path.rs.
bool integrator_goes_on(inout PathState s, bool goes_on) {
    return roulette_survives(s) && goes_on;
}
