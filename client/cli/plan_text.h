// A plan, for a person. Pure functions.
#pragma once

#include <motiondb/v1/plan.pb.h>

#include <string>

namespace motiondb::client {

// "EXACT".
std::string OutcomeText(v1::PlanOutcome outcome);

// One line: duration, length, errors at the end and the smallest clearance.
std::string PlanFigures(const v1::PlanQuality& quality);

// The outcome and what is missing, the stored motion that is played, a table of the quality figures
// with a column for each motion, and what the search took.
std::string PlanText(const v1::PlanResponse& response);

}  // namespace motiondb::client
