// Corrections of a motion on the standard markers, before its states are computed: the T-pose or
// A-pose that many tools write at the start of a file is replaced, because it is not part of the
// motion; markers that the motion lacks are derived by the proportions of a person.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "absl/status/status.h"
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

// A marker beside another one, in leg lengths: to the front of the body, and upwards.
struct DerivedMarker {
  const char* marker;
  const char* from;
  double front;
  double up;
};

// Feet and head of the standard set. The foot is 0.31 leg lengths long and the ankle 0.08 above its
// sole (Winter, "Biomechanics and Motor Control of Human Movement", after Drillis and Contini); the
// ankle is at a quarter of the foot's length, the ball at three quarters. The head is that of
// core/mapping/figure_mapping.cc.
std::span<const DerivedMarker> DerivedMarkers();

// Adds the markers of DerivedMarkers that `motion` lacks in all frames and whose base it has. Feet
// point to the front of the reference frame (ReferenceFrames), so this is an estimate for people
// who stand or walk. Appends one note with their names. INVALID_ARGUMENT if no frame has both hips.
absl::Status AddDerivedMarkers(const MarkerSet& set, double leg_length_m, MarkerMotion& motion,
                               std::vector<std::string>& notes);

}  // namespace motiondb::core
