// What a stream of frames says, for people. Pure functions.
#pragma once

#include <string>

#include "client/cli/observe_replay.h"

namespace motiondb::client {

// One line, without its end. `seconds`: where in the motion its newest frame is.
std::string ObservedLine(const v1::ObserveResponse& answer, double seconds);

// `paced`: messages were sent at a rate of their own, so that how long answers took says something.
std::string ReplayText(const ReplayFigures& figures, const v1::ObserveResponse& last, bool paced);

}  // namespace motiondb::client
