// How probable it is that a layer's nodes, and each clip's graph on them, generate a window.
#pragma once

#include <vector>

#include "absl/status/statusor.h"
#include "core/graph/generation.h"
#include "core/motion/matrix.h"
#include "core/recognition/recognize.h"

namespace motiondb::core {

// log P_o(x | k) of every node of a layer for the frames of a window that moves along: each frame
// is computed once, however many windows and clips it serves. Not thread-safe; what it is made of
// must outlive it.
class Model;

class WindowEmission {
 public:
  // `observation` is scaled, frames x dimensions; the window has `frames` frames.
  WindowEmission(const Model& model, int layer, const FrameMatrix& observation, int frames);

  // Moves to the frames [first, first + rows). Windows must come in ascending order. Once cancelled
  // it returns early, and the window is of no use.
  void MoveTo(int first, const Cancelled& cancelled = {});

  // frames x nodes of the layer.
  const EmissionMatrix& log_density() const { return log_density_; }

  // The sum over frames of log P(x), eq. 8's denominator with P(k) uniform.
  double LogEvidence() const;

 private:
  const Model& model_;
  const int layer_;
  const FrameMatrix& observation_;
  EmissionMatrix log_density_;
  int first_ = 0;
  int computed_ = 0;
};

// How probable it is that each clip's graph generates a window (section IV-B). Safe to call from
// any thread.

// One score for each of `clips` (indices into Model::clips()), in their order: eq. 7 with eq. 8's
// posterior, on the layer that `emission` is of. CANCELLED, soon.
absl::StatusOr<std::vector<ClipScore>> ScoreGeneration(const Model& model, int layer,
                                                       const WindowEmission& emission,
                                                       const std::vector<int>& clips,
                                                       const RecognizeOptions& options,
                                                       const Cancelled& cancelled);

// Most probable first; equals stay in order.
void SortByGeneration(std::vector<ClipScore>& scores);

}  // namespace motiondb::core
