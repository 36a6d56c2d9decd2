// Inverse kinematics: marker positions -> joint angles on a skeleton, within its joints' limits.
// The function keeps no state and is safe to call from any thread. For frames as they come, see
// PoseTracker.
#pragma once

#include <vector>

#include "absl/status/statusor.h"
#include "core/kinematics/ik_options.h"
#include "core/kinematics/marker_kinematics.h"
#include "core/motion/cancellation.h"
#include "core/motion/motion.h"

namespace motiondb::core {

struct IkMotion {
  JointMotion motion;           // at the markers' frame rate
  std::vector<IkError> errors;  // of each frame
};

// All frames of a motion on the kinematics' markers, in its order, each as PoseTracker follows
// them; frames before the first marker have the first pose. INVALID_ARGUMENT if the markers are
// others or infinite, no frame has one that counts, or an option is out of range; CANCELLED if
// `cancelled` says so.
absl::StatusOr<IkMotion> SolveInverseKinematics(const MarkerKinematics& kinematics,
                                                const MarkerMotion& markers,
                                                const IkOptions& options = {},
                                                const Cancelled& cancelled = {});

}  // namespace motiondb::core
