// Recorded motion, before conversion to states: joint angles on a skeleton, or marker positions.
#pragma once

#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "core/motion/matrix.h"
#include "core/motion/skeleton.h"

namespace motiondb::core {

// Joint angles (rad) and translations (m) of a skeleton over time.
struct JointMotion {
  std::shared_ptr<const Skeleton> skeleton;
  double frame_rate_hz = 0;
  JointMatrix angles;  // frames x skeleton->dof_count()
};

// Marker positions in the world (m, z up) over time. A missing marker has NaN in all three columns.
struct MarkerMotion {
  std::vector<std::string> names;
  double frame_rate_hz = 0;
  FrameMatrix positions_m;  // frames x 3 * names.size(), x y z of each marker in turn
  int first_frame = 0;      // in the file, from 0; for messages
};

// A range of frames, counted from 0; first and last are included.
struct FrameSpan {
  int first = 0;
  int last = 0;
  friend bool operator==(const FrameSpan&, const FrameSpan&) = default;
};

using Motion = std::variant<JointMotion, MarkerMotion>;

}  // namespace motiondb::core
