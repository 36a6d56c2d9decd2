// Clips on their way into a model. Functions are safe to call from any thread.
#pragma once

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "core/model/model.h"
#include "core/motion/states.h"

namespace motiondb::core {

struct BuildInput {
  std::string clip_id;
  std::string label;
  StateSequence states;  // without NaN
  std::string subject;   // who moves; may be empty. Calibration holds out all that one did
};

// INVALID_ARGUMENT, naming the clip, if there is none, or one has no frame, a number that is not
// finite, or does not fit the marker set or the frame rate.
absl::Status CheckInputs(const BuildSettings& settings, const MarkerSet& marker_set,
                         const std::vector<BuildInput>& inputs);

// Clips end to end.
struct ConcatenatedInputs {
  std::vector<ModelClip> clips;  // numbered from frame 0
  FrameMatrix states;            // frames x dimensions, not scaled
  RootPath root_path;
};

// Each input's memory is given back as soon as it is copied. REQUIRES: CheckInputs.
ConcatenatedInputs Concatenate(std::vector<BuildInput> inputs);

}  // namespace motiondb::core
