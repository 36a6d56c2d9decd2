// Generation probabilities (section IV-B): the probability that a clip's graph generates a window.
#pragma once

#include <vector>

#include "absl/status/statusor.h"
#include "core/graph/generation.h"
#include "core/motion/matrix.h"
#include "core/recognition/recognize.h"

namespace motiondb::core {

class Model;

// log P_o(x | k) of every node of a layer for the frames of a moving window. Each frame is computed
// once for all windows and clips. Not thread-safe.
class WindowEmission {
 public:
  // `observation`: scaled, frames x dimensions; the window has `frames` frames. The model and the
  // observation must outlive this.
  WindowEmission(const Model& model, int layer, const FrameMatrix& observation, int frames);

  // Moves the window to the frames [first, first + frames). `first` must not decrease from call to
  // call. If cancelled, returns early; the window is then invalid.
  void MoveTo(int first, const Cancelled& cancelled = {});

  // Shape: frames x nodes of the layer.
  const EmissionMatrix& log_density() const { return log_density_; }

  // Returns the sum over frames of log P(x): the denominator of eq. 8 with uniform P(k).
  double LogEvidence() const;

 private:
  const Model& model_;
  const int layer_;
  const FrameMatrix& observation_;
  EmissionMatrix log_density_;
  int first_ = 0;
  int computed_ = 0;
};

// Returns one score for each of `clips` (indices into Model::clips()), in their order: eq. 7 with
// the posterior of eq. 8, on the layer of `emission`. CANCELLED.
absl::StatusOr<std::vector<ClipScore>> ScoreGeneration(const Model& model, int layer,
                                                       const WindowEmission& emission,
                                                       const std::vector<int>& clips,
                                                       const RecognizeOptions& options,
                                                       const Cancelled& cancelled);

// Sorts by descending probability; stable.
void SortByGeneration(std::vector<ClipScore>& scores);

}  // namespace motiondb::core
