// Answers of queries as text for the terminal.
#pragma once

#include <motiondb/messages.h>
#include <motiondb/v1/plan.pb.h>

#include <string>
#include <vector>

namespace motiondb::client {

// Returns whether a window is called unknown: an answer of recognize (v1::RecognitionWindow) or of
// observe (v1::ObserveResponse).
template <typename Window>
bool IsUnknown(const Window& window, double threshold) {
  return window.has_unknown_probability() && window.unknown_probability() > threshold;
}

// "unknown 0.83"
std::string UnknownText(double probability);

// Returns a line for each window: time, most probable labels, familiarity, best clip. The last line
// has the share of windows of each label. The probability of unknown motion precedes the labels if
// it is greater than `unknown_threshold`; otherwise it follows them.
std::string RecognitionText(const v1::RecognizeResponse& response, double unknown_threshold);

// Returns the state, each path as runs "NODExFRAMES", and the positions and expected errors of
// missing markers.
std::string EstimationText(const v1::EstimateResponse& response,
                           const std::vector<std::string>& marker_names);

// Returns the next nodes with their probabilities. For each horizon: confidence, and the positions
// (m) of the body's middle (the mean of all markers) and of the first marker. Notes say whether
// the prediction extrapolates.
std::string PredictionText(const v1::PredictResponse& response,
                           const std::vector<std::string>& marker_names, double unknown_threshold);

// Returns the name of an outcome, such as "EXACT".
std::string OutcomeText(v1::PlanOutcome outcome);

// Returns one line: duration, length, distance from the goal, smallest clearance.
std::string PlanSummary(const v1::PlanQuality& quality);

// Returns the outcome, the stored segments, a table of quality values with a column for each
// motion, the most slowed parts, efforts and balance of the best motion, and the effort of the
// search.
std::string PlanText(const v1::PlanResponse& response);

}  // namespace motiondb::client
