// One seed of the simulation: servers on one store, clients, accidents, and the checks.
#pragma once

#include <cstdint>

#include "tests/simulation/simulated_store.h"

namespace motiondb::simulation {

// Runs a seed and returns the hash of its trace. If an invariant is broken, prints the seed and
// which one, and ends the process.
std::uint64_t Simulate(std::uint64_t seed, Protection removed);

}  // namespace motiondb::simulation
