// How do I get there? (section V-C). Safe to call from any thread.
#pragma once

#include "absl/status/statusor.h"
#include "core/motion/marker_set.h"
#include "core/planning/plan.h"

namespace motiondb::core {

class Model;

// Searches for stored motion from the start to the goal, and makes one motion of it: segments
// blended at their joins, the end corrected by at most 5 % of the length, feet kept where they
// stand, joint angles on the skeleton. The outcome is judged on the motion that is returned.
// `scheme` is the one of the model's marker set: it maps the skeleton.
//
// The same problem gives the same answer as long as time is not up first. INVALID_ARGUMENT naming
// the field of the problem that is out of range, unknown or does not fit; NOT_FOUND for a clip that
// the model does not have; CANCELLED.
absl::StatusOr<PlanAnswer> PlanMotion(const Model& model, const MarkerScheme& scheme,
                                      const PlanProblem& problem, const PlanControl& control = {});

}  // namespace motiondb::core
