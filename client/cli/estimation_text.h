// Where in the tree a motion is, for a person. Pure function.
#pragma once

#include <motiondb/messages.h>

#include <string>
#include <vector>

namespace motiondb::client {

// The state, then each path with the runs of frames that stay in one node as "NODExFRAMES", then
// the markers that were missing, with where they are and how far off that may be.
std::string EstimationText(const v1::EstimateResponse& response,
                           const std::vector<std::string>& marker_names);

}  // namespace motiondb::client
