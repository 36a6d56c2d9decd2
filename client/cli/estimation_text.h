// Where in the tree a motion is, for a person. Pure function.
#pragma once

#include <motiondb/messages.h>

#include <string>

namespace motiondb::client {

// The state, then each path with the runs of frames that stay in one node as "NODExFRAMES".
std::string EstimationText(const v1::EstimateResponse& response);

}  // namespace motiondb::client
