#include "core/view/recorded_joints.h"

#include <utility>

#include "core/motion/error.h"
#include "core/motion/forward_kinematics.h"

namespace motiondb::core {

absl::StatusOr<FrameMatrix> RecordedJoints(const JointMotion& motion, const SourcePart& part,
                                           double frame_rate_hz) {
  MarkerMotion joints{
      {},
      motion.frame_rate_hz,
      JointPositions({motion.skeleton, motion.frame_rate_hz,
                      motion.angles.middleRows(part.first_frame, part.frame_count)})};
  for (int joint = 0; joint < motion.skeleton->joint_count(); ++joint) {
    joints.positions_m.col(3 * joint + 2).array() -= static_cast<float>(part.floor_m);
  }
  MOTIONDB_ASSIGN_OR_RETURN(MarkerMotion resampled, Resample(joints, frame_rate_hz));
  return std::move(resampled.positions_m);
}

}  // namespace motiondb::core
