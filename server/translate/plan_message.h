// Converts plan requests to the engine's, and plans to messages.
#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/motion/motion.h"
#include "server/engine/query/plan_query.h"

namespace motiondb::core {
class Model;
}

namespace motiondb::v1 {
class PlanRequest;
class PlanResponse;
}  // namespace motiondb::v1

namespace motiondb::server {

// Converts a request; the result refers to `request`. `database` is the id of the database. Returns
// INVALID_ARGUMENT with the field.
absl::StatusOr<PlanRequest> ParsePlanRequest(const v1::PlanRequest& request,
                                             const std::string& database);

// Sets a plan with its files.
void SetPlan(PlanResult plan, const std::string& database, const core::Model& model,
             v1::PlanResponse& message);

// Returns the names of the columns of joint angles: the name of the joint if it has one degree of
// freedom; otherwise "joint.tx", "joint.rx" and so on, by the nearest axis, with a number for a
// repeated axis: "joint.rz2".
std::vector<std::string> DofNames(const core::Skeleton& skeleton);

}  // namespace motiondb::server
