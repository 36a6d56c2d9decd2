// Joints of the recorded skeleton, in time with the stored states of a clip.
#pragma once

#include "absl/status/statusor.h"
#include "core/motion/motion.h"
#include "core/motion/states.h"

namespace motiondb::core {

// Returns the positions of all joints (frames x 3 * joint_count, m, world) by forward kinematics,
// at this frame rate, with the floor at z = 0. `part`: the frames of the states (Represent). Frame
// i is that of state i. Errors: those of Resample. REQUIRES: the motion has these frames. O(frames
// * joints).
absl::StatusOr<FrameMatrix> RecordedJoints(const JointMotion& motion, const SourcePart& part,
                                           double frame_rate_hz);

}  // namespace motiondb::core
