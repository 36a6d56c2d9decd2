#include "core/format/writable_motion.h"

#include "core/format/frame_rate.h"
#include "core/motion/error.h"

namespace motiondb::core {

absl::Status CheckWritable(std::string_view format, const JointMotion& motion) {
  if (motion.skeleton == nullptr) {
    return InvalidArgument("{}: the motion has no skeleton", format);
  }
  if (motion.angles.rows() == 0) return InvalidArgument("{}: the motion has no frame", format);
  if (!IsFrameRate(motion.frame_rate_hz)) {
    return InvalidArgument("{}: expected a frame rate from 0.001 to 100000 Hz, found {}", format,
                           motion.frame_rate_hz);
  }
  if (motion.angles.cols() != motion.skeleton->dof_count()) {
    return InvalidArgument("{}: expected {} columns, one a degree of freedom, found {}", format,
                           motion.skeleton->dof_count(), motion.angles.cols());
  }
  for (Eigen::Index frame = 0; frame < motion.angles.rows(); ++frame) {
    if (!motion.angles.row(frame).allFinite()) {
      return InvalidArgument("{}: frame {} has a joint angle that is not finite", format, frame);
    }
  }
  return absl::OkStatus();
}

}  // namespace motiondb::core
