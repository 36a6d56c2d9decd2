// Clips as input of a model build.
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
  std::string subject;   // may be empty; calibration holds out all clips of a subject
};

// INVALID_ARGUMENT if there is no clip, or if a clip has no frame, has a number that is not finite,
// or does not fit the marker set or the frame rate. The message names the clip.
absl::Status CheckInputs(const BuildSettings& settings, const MarkerSet& marker_set,
                         const std::vector<BuildInput>& inputs);

// All clips, concatenated.
struct ConcatenatedInputs {
  std::vector<ModelClip> clips;  // numbered from frame 0
  FrameMatrix states;            // frames x dimensions, not scaled
  RootPath root_path;
};

// Frees each input as soon as it is copied. REQUIRES: CheckInputs.
ConcatenatedInputs Concatenate(std::vector<BuildInput> inputs);

}  // namespace motiondb::core
