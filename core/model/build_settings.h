// How a database's models are built. Fixed when the database is created.
#pragma once

#include "core/tree/feature_scale.h"

namespace motiondb::core {

struct BuildSettings {
  double frame_rate_hz = 60;
  int min_frames = 16;  // fewest frames of a node (section III-B)
  Scaling scaling = Scaling::kKind;
};

}  // namespace motiondb::core
