// Answers of predict as text for the terminal and as a table.
#pragma once

#include <motiondb/messages.h>

#include <string>
#include <vector>

#include "client/cli/query/query_options.h"
#include "client/cli/terminal/table.h"

namespace motiondb::client {

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
