// What a plan is asked for -> core's problem, but for the body (plan_body.h). Safe to call from any
// thread.
#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "core/planning/plan.h"
#include "server/engine/engine.h"

namespace motiondb::v1 {
class PlanRequest;
}

namespace motiondb::server {

// Far more than the usual effort takes: a slow machine's plans are those of a fast one.
inline constexpr double kUsualSearchSeconds = 5;

struct PlanOptions {
  core::PlanProblem problem;  // without a body
  std::string start_clip;     // id of the clip that the start is in, or is most like
  double max_search_seconds = kUsualSearchSeconds;
};

// Everything that the request says is checked, and every error names its field: INVALID_ARGUMENT,
// but NOT_FOUND for the skeleton of an observation's joints, and CANCELLED.
absl::StatusOr<PlanOptions> OptionsFrom(const v1::PlanRequest& request, const core::Model& model,
                                        Engine& engine, const LiveDatabase& database,
                                        const WorkTerms& terms = {});

}  // namespace motiondb::server
