// Clips as input of a model build.
#pragma once

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "core/model/label_tracks.h"
#include "core/model/model.h"
#include "core/motion/states.h"

namespace motiondb::core {

struct BuildInput {
  std::string clip_id;
  LabelTracks labels;
  StateSequence states;  // without NaN
  std::string subject;   // may be empty; calibration holds out all clips of a subject

  // As ModelClip::label.
  const std::string& label() const { return labels.Whole(states.frame_count()); }
};

// Returns INVALID_ARGUMENT if there is no clip, or if a clip has no frame, a number that is not
// finite, invalid labels (LabelTracks::Check), or another marker set or frame rate. The message
// names the clip.
absl::Status CheckInputs(const BuildSettings& settings, const MarkerSet& marker_set,
                         const std::vector<BuildInput>& inputs);

struct ConcatenatedInputs {
  std::vector<ModelClip> clips;  // numbered from frame 0
  FrameMatrix states;            // frames x dimensions, not scaled
  RootPath root_path;
};

// Returns all clips. Frees each input after copying it. REQUIRES: CheckInputs returned OK.
ConcatenatedInputs Concatenate(std::vector<BuildInput> inputs);

}  // namespace motiondb::core
