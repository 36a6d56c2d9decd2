// Plans: a request -> the engine's, and the engine's plan as a message. Safe to call from any
// thread.
#pragma once

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/motion/skeleton.h"
#include "server/engine/plan_query.h"

namespace motiondb::core {
class Model;
}

namespace motiondb::v1 {
class PlanRequest;
class PlanResponse;
}  // namespace motiondb::v1

namespace motiondb::server {

// What a plan is asked for; refers to the message. `database` is the id of the one that is asked.
// INVALID_ARGUMENT naming the field.
absl::StatusOr<PlanRequest> PlanRequestFrom(const v1::PlanRequest& request,
                                            const std::string& database);

// `with_files` adds each motion as a file. CANCELLED.
absl::Status SetPlan(const PlanResult& plan, const std::string& database, const core::Model& model,
                     bool with_files, const core::Cancelled& cancelled, v1::PlanResponse& message);

// One for each column of a frame of joint angles: the joint's name where that is its only degree of
// freedom, else "joint.tx" or "joint.rx" and so on, after the axis that it is nearest to; with a
// number, "joint.rz2", for another about the same axis.
std::vector<std::string> DofNames(const core::Skeleton& skeleton);

}  // namespace motiondb::server
