// The T-pose or A-pose that many tools write at the start of a file; it is not part of the motion.
#pragma once

#include "core/motion/marker_set.h"

namespace motiondb::core {

enum class ReferencePose { kNone, kT, kA };

struct PoseAtStart {
  ReferencePose pose = ReferencePose::kNone;
  int frame_count = 0;
};

// Returns the reference pose at the start of a motion on the standard set, and its number of
// frames. Arms are straight and in the plane of the body: level in a T-pose, 35 to 75 degrees from
// the trunk in an A-pose. Legs are straight. The pose ends with a jump of the limbs, or is held
// without movement for at least 0.25 s. Frames into which a filter has spread the jump belong to
// the pose, up to 0.15 s. None if the whole motion is in the pose, or if the set or the motion
// lacks joints.
PoseAtStart FindPoseAtStart(const MarkerSet& set, const MarkerMotion& motion, double leg_length_m);

// Replaces a reference pose at the start by the first frame after it, so that the times of the
// other frames do not change.
void ReplacePoseAtStart(const MarkerSet& set, double leg_length_m, MarkerMotion& motion);

}  // namespace motiondb::core
