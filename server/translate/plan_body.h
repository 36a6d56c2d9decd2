// Who is to play a plan: a stored skeleton, a robot, or bare markers. Safe to call from any thread.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/format/urdf_reader.h"
#include "core/motion/marker_set.h"
#include "server/engine/engine.h"

namespace motiondb::v1 {
class PlanRequest;
}

namespace motiondb::server {

struct PlanBody {
  std::shared_ptr<const core::Skeleton> skeleton;  // null: bare markers
  bool is_robot = false;
  std::vector<core::MimicJoint> mimics;  // of a robot
};

// The body that the request names, or else that of the clip `start_clip`; bare markers where that
// clip has none. INVALID_ARGUMENT names `skeleton` or `robot.urdf` for one that is not
// known, cannot be read, or lacks the joints that the scheme maps; FAILED_PRECONDITION where the
// request wants files and there is no body to write.
absl::StatusOr<PlanBody> BodyFrom(const v1::PlanRequest& request, const std::string& start_clip,
                                  const core::MarkerScheme& scheme, Engine& engine,
                                  const LiveDatabase& database);

}  // namespace motiondb::server
