// A synthesised motion as its body plays it: joint angles, the markers that these give, and what
// that is worth. Safe to call from any thread.
#pragma once

#include "absl/status/statusor.h"
#include "core/planning/body.h"
#include "core/planning/plan.h"
#include "core/planning/synthesis.h"

namespace motiondb::core {

// Fills in what follows from the motion alone: root, markers, joints, and of the quality all but
// the correction. The outcome is kExact or kApproximate, judged on the markers that are returned.
// INVALID_ARGUMENT if the body cannot play it; CANCELLED.
absl::Status Perform(const MarkerScheme& scheme, const Body& body, const PlanProblem& problem,
                     SynthesisedMotion motion, const Cancelled& cancelled, PlannedMotion& planned);

}  // namespace motiondb::core
