// Generation probabilities (section IV-B): the probability that a clip's graph generates a window.
#pragma once

#include <vector>

#include "absl/status/statusor.h"
#include "core/graph/transition_graph.h"
#include "core/motion/matrix.h"
#include "core/recognition/recognize.h"
#include "core/recognition/window_alignment.h"

namespace motiondb::core {

class ClipMask;
class Model;

// log P_o(x | k) of every node of a layer for the frames of a moving window; -infinity for nodes
// without frames of allowed clips. Each frame is computed once for all windows and clips. Not
// thread-safe.
class WindowEmission {
 public:
  // `observation`: scaled, frames x dimensions; the window has `frames` frames. `mask`: the clips
  // to use; null: all. The arguments must outlive this.
  WindowEmission(const Model& model, int layer, const FrameMatrix& observation, int frames,
                 const ClipMask* mask);

  // Moves the window to the frames [first, first + frames). `first` must not decrease from call to
  // call. If cancelled, returns early; the window is then invalid.
  void MoveTo(int first, const Cancelled& cancelled = {});

  // Shape: frames x nodes of the layer.
  const EmissionMatrix& log_density() const { return log_density_; }

  // Returns the rank of the window's FamiliarityScore under the graph of the allowed clips.
  double Familiarity() const;

  // Returns the sum over frames of log P(x): the denominator of eq. 8 with uniform P(k).
  double LogEvidence() const;

 private:
  const Model& model_;
  const int layer_;
  const FrameMatrix& observation_;
  const ClipMask* const mask_;
  EmissionMatrix log_density_;
  int first_ = 0;
  int computed_ = 0;
};

// Returns the log probability of each unit, in their order: eq. 7 with the posterior of eq. 8, on
// the layer of `emission`. CANCELLED.
absl::StatusOr<std::vector<UnitEvidence>> ScoreGeneration(const Model& model, int layer,
                                                          const WindowEmission& emission,
                                                          const LabelUnits& units,
                                                          const RecognizeOptions& options,
                                                          const Cancelled& cancelled);

}  // namespace motiondb::core
