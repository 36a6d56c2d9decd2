// Builds a model from the states of clips: scale, tree, node statistics, graphs, familiarity,
// motion prior, metric. Or extends a model by clips without a build: their frames descend the
// existing tree.
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/model/label_tracks.h"
#include "core/model/model.h"
#include "core/motion/execution.h"
#include "core/motion/states.h"

namespace motiondb::core {

// A clip as input of a build or an extension.
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

// Called repeatedly on the calling thread with the progress (0 to 1) and the current stage. Returns
// false to cancel the build.
using BuildProgress = std::function<bool(double fraction, std::string_view stage)>;

// Returns the model of the clips. It depends only on the inputs and their order, not on the number
// of threads. INVALID_ARGUMENT as CheckInputs; CANCELLED.
absl::StatusOr<Model> BuildModel(const BuildSettings& settings, const MarkerSet& marker_set,
                                 std::vector<BuildInput> inputs, const ParallelFor& parallel,
                                 const BuildProgress& progress);

// Returns the model with `inputs` appended. Each frame descends the tree by the thresholds (section
// III-B) and is counted in node statistics and transition graphs (eq. 6). The scale, the
// thresholds, the metric, the motion prior, the familiarity and the calibration do not change.
// Shares the memory of the stored states with `base`, which does not change. INVALID_ARGUMENT as
// BuildModel; FAILED_PRECONDITION if the base has no split thresholds (built by an older version).
// O(added * depth * dimensions + frames + branches).
absl::StatusOr<Model> ExtendModel(const Model& base, std::vector<BuildInput> inputs,
                                  const ParallelFor& parallel);

// Difference between a model and a build of the same clips. Fractions, 0 to 1.
struct ModelDrift {
  double added = 0;  // fraction of frames added after the build
  double stale = 0;  // see DriftFraction (core/tree/tree_builder.h)

  // Returns whether a build is needed: more than 10 % of the frames were added, or more than 5 %
  // are in nodes that a build would split.
  bool IsLarge() const { return added > 0.1 || stale > 0.05; }
};
ModelDrift MeasureDrift(const Model& model, const ParallelFor& parallel);

}  // namespace motiondb::core
