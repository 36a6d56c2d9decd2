// core's plan as a message. Safe to call from any thread.
#pragma once

#include <string>

#include "absl/status/status.h"
#include "core/planning/plan.h"
#include "server/translate/plan_body.h"

namespace motiondb::core {
class Model;
}

namespace motiondb::v1 {
class PlanResponse;
}

namespace motiondb::server {

// All but the times that it took. `with_files` adds each motion as a file. CANCELLED.
absl::Status SetPlan(const core::PlanAnswer& answer, const std::string& database,
                     const core::Model& model, const PlanBody& body, bool with_files,
                     const core::Cancelled& cancelled, v1::PlanResponse& message);

}  // namespace motiondb::server
