// A peer: a simple, exact recognition method that the database is compared with.
#pragma once

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "core/motion/states.h"
#include "core/tree/feature_scale.h"
#include "tests/support/corpus.h"

namespace motiondb::tests {

// The part of a motion that is observed.
enum class Extent {
  kWindow,  // a part from anywhere
  kWhole,   // the whole motion
  kPrefix,  // its beginning
};

class Peer {
 public:
  virtual ~Peer() = default;

  // Learns the clips, at least one of each of `labels`. Called once.
  virtual absl::Status Learn(const ClipSet& training, const std::vector<std::string>& labels) = 0;

  // Returns the score of each label (higher is better) in the order passed to Learn. The
  // observation is not scaled and may have NaN. Thread-safe after Learn.
  virtual std::vector<double> Score(const core::StateSequence& observation,
                                    Extent extent) const = 0;

  // Returns the memory needed to answer.
  virtual double model_bytes() const = 0;
};

// Scales states as core::Scaling, fitted to the training clips.
class PeerScale {
 public:
  PeerScale() = default;
  PeerScale(core::Scaling scaling, const ClipSet& training);

  core::FrameMatrix Apply(const core::StateSequence& sequence) const;

 private:
  core::FeatureScale scale_;
  Eigen::RowVectorXf mean_;  // subtracted, so that sums of squares stay small
};

// Returns the index of a clip's label in `labels`.
int LabelIndex(const EvalClip& clip, const std::vector<std::string>& labels);

}  // namespace motiondb::tests
