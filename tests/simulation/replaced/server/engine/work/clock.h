// Takes the place of server/engine/work/clock.h in the simulation: the wall clock of the server.
#pragma once

#include <cstdint>

#include "tests/simulation/world.h"

namespace motiondb::server {

inline std::int64_t NowMicroseconds() { return simulation::World::Current().WallMicroseconds(); }

}  // namespace motiondb::server
