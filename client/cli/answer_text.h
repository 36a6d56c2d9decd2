// What a motion was recognized as, where in the tree it is, and what comes next, for a person. Pure
// functions.
#pragma once

#include <motiondb/messages.h>
#include <motiondb/v1/plan.pb.h>

#include <string>
#include <vector>

namespace motiondb::client {

// A line for each window: its time, the most probable labels, familiarity and the best clip; then
// how many windows each label leads.
std::string RecognitionText(const v1::RecognizeResponse& response);

// The state, then each path with the runs of frames that stay in one node as "NODExFRAMES", then
// the markers that were missing, with where they are and how far off that may be.
std::string EstimationText(const v1::EstimateResponse& response,
                           const std::vector<std::string>& marker_names);

// The next nodes with their probabilities; then for each horizon where the body's middle (the mean
// of all markers) and the first marker are, in metres, with the confidence.
std::string PredictionText(const v1::PredictResponse& response,
                           const std::vector<std::string>& marker_names);

// A plan, for a person. Pure functions.

// "EXACT".
std::string OutcomeText(v1::PlanOutcome outcome);

// One line: duration, length, errors at the end and the smallest clearance.
std::string PlanFigures(const v1::PlanQuality& quality);

// The outcome and what is missing, the stored motion that is played, a table of the quality figures
// with a column for each motion, and what the search took.
std::string PlanText(const v1::PlanResponse& response);

}  // namespace motiondb::client
