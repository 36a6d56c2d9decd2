// Answers of estimate and predict as text for the terminal and as tables.
#pragma once

#include <motiondb/messages.h>

#include <string>
#include <vector>

#include "client/cli/query/query_options.h"
#include "client/cli/terminal/table.h"

namespace motiondb::client {

// Returns the state, each path as runs "NODExFRAMES", and the positions and expected errors of
// missing markers.
std::string EstimationText(const v1::EstimateResponse& response,
                           const std::vector<std::string>& marker_names);

// Returns a row for each run of frames of each path in the same node.
Table EstimationTable(const v1::EstimateResponse& response);

struct PredictionView {
  double unknown_threshold = kDefaultUnknownThreshold;
  // The whole motion, to compare predictions with: positions (m) of the markers of the database in
  // each frame. Empty: no comparison.
  std::vector<float> motion_m;
  double frame_rate_hz = 0;
};

// Returns the next nodes with their probabilities, and for each horizon the confidence, the
// expected error, the mean distance (m) of the markers from the motion, and the position (m) of the
// middle of the body: the mean of all markers. Notes say whether the prediction extrapolates.
std::string PredictionText(const v1::PredictResponse& response, const PredictionView& view);

// Returns a row for each horizon.
Table PredictionTable(const v1::PredictResponse& response, const PredictionView& view);

}  // namespace motiondb::client
