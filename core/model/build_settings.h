// Settings of a database, fixed when it is created: how clips are stored and models are built.
#pragma once

#include "absl/status/status.h"
#include "core/motion/glitches.h"
#include "core/tree/feature_scale.h"

namespace motiondb::core {

// Frame rates of databases and plans, Hz.
inline constexpr double kMinFrameRate_hz = 1;
inline constexpr double kMaxFrameRate_hz = 1000;  // the fastest motion capture

struct BuildSettings {
  double frame_rate_hz = 60;
  int min_frames = 16;  // minimum frames of a node (section III-B)
  Scaling scaling = Scaling::kKind;
  GlitchPolicy glitches = GlitchPolicy::kRepair;  // applied at ingest; models ignore it
};

// Returns INVALID_ARGUMENT, naming the field, for numbers out of range.
absl::Status CheckSettings(const BuildSettings& settings);

}  // namespace motiondb::core
