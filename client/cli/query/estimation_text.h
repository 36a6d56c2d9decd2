// Answers of estimate as text for the terminal and as a table.
#pragma once

#include <motiondb/messages.h>

#include <string>
#include <vector>

#include "client/cli/terminal/table.h"

namespace motiondb::client {

// Returns the state, each path as runs "NODExFRAMES", and the positions and expected errors of
// missing markers.
std::string EstimationText(const v1::EstimateResponse& response,
                           const std::vector<std::string>& marker_names);

// Returns a row for each run of frames of each path in the same node.
Table EstimationTable(const v1::EstimateResponse& response);

}  // namespace motiondb::client
