// What a stream of frames says, for people. Pure functions.
#pragma once

#include <string>

#include "client/cli/observe_replay.h"

namespace motiondb::client {

// One line, without its end. `seconds`: where in the motion its newest frame is.
std::string ObservedLine(const v1::ObserveResponse& answer, double seconds, double latency_ms);

std::string ReplayText(const ReplayFigures& figures, const v1::ObserveResponse& last);

}  // namespace motiondb::client
