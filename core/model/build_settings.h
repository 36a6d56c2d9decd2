// How a database's clips are stored and its models built. Fixed when the database is created.
#pragma once

#include "core/motion/glitches.h"
#include "core/tree/feature_scale.h"

namespace motiondb::core {

// Of a database's frames, and of those of a plan.
inline constexpr double kLowestFrameRateHz = 1;
inline constexpr double kHighestFrameRateHz = 1000;  // the fastest that motion is captured with

struct BuildSettings {
  double frame_rate_hz = 60;
  int min_frames = 16;  // fewest frames of a node (section III-B)
  Scaling scaling = Scaling::kKind;
  GlitchPolicy glitches = GlitchPolicy::kRepair;  // of clips on their way in; no model knows it
};

}  // namespace motiondb::core
