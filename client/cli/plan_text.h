// Answers of plan as text for the terminal.
#pragma once

#include <motiondb/v1/plan.pb.h>

#include <string>

namespace motiondb::client {

// Returns the name of an outcome, such as "EXACT".
std::string OutcomeText(v1::PlanOutcome outcome);

// Returns one line: duration, length, distance from the goal, smallest clearance.
std::string PlanSummary(const v1::PlanQuality& quality);

// Returns the outcome, the stored segments, a table of quality values with a column for each
// motion, and the effort of the search.
std::string PlanText(const v1::PlanResponse& response);

}  // namespace motiondb::client
