// One stored clip beside the frames of a moving window: each distance is computed once. Not
// thread-safe.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "core/observe/metric_window.h"
#include "core/recognition/clip_alignment.h"
#include "core/recognition/path_sum.h"

namespace motiondb::core {

class Model;

class KeptClip {
 public:
  // Takes a clip of the model, and forgets what it had. A window has at most so many frames.
  void Take(const Model& model, int clip, int window_frames);
  int clip() const { return clip_; }

  // Sees the window's frame (`ring`: its number % the window's frames), if it has not yet, and says
  // which of the clip's frames is nearest.
  const NearestFrame& See(const Model& model, std::size_t ring, const MetricFrame& frame);

  // As AlignToClip for the frames at `rings`, in their order, all of them seen. False where only
  // AlignToClip itself can tell; `paths` is scratch.
  bool LogEvidence(std::span<const std::size_t> rings, PathSum& paths, double& log_evidence) const;
  // It is at most this.
  double LogEvidenceAtMost(std::span<const std::size_t> rings) const;

  std::int64_t last_asked = 0;  // for its owner

 private:
  int clip_ = -1;
  std::vector<std::int64_t> version_;  // of the frame seen at each place of the ring
  std::vector<NearestFrame> nearest_;
  Eigen::ArrayXXf roots_;  // clip's frames x ring: PathSum::Roots
  Eigen::ArrayXf distances_;
};

}  // namespace motiondb::core
