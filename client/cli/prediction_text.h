// What comes next, for a person. Pure functions.
#pragma once

#include <motiondb/messages.h>

#include <string>
#include <vector>

namespace motiondb::client {

// The next nodes with their probabilities; then for each horizon where the body's middle (the mean
// of all markers) and the first marker are, in metres, with the confidence.
std::string PredictionText(const v1::PredictResponse& response,
                           const std::vector<std::string>& marker_names);

}  // namespace motiondb::client
