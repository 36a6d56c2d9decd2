// A peer: another way to recognize motion, plain and exact, that the database is measured against.
#pragma once

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "core/motion/states.h"
#include "core/tree/feature_scale.h"
#include "tests/support/corpus.h"

namespace motiondb::tests {

// What part of a motion an observation is.
enum class Extent {
  kWindow,  // a part from anywhere
  kWhole,   // all of it
  kPrefix,  // its beginning
};

class Peer {
 public:
  virtual ~Peer() = default;

  // Learns the clips, of which there is at least one of each of `labels`. Once.
  virtual absl::Status Learn(const ClipSet& training, const std::vector<std::string>& labels) = 0;

  // For each label how well it fits, the higher the better, in the order given to Learn. The
  // observation (not scaled) may have NaN. Safe to call from any thread once Learn is over.
  virtual std::vector<double> Score(const core::StateSequence& observation,
                                    Extent extent) const = 0;

  // What it keeps in memory to answer.
  virtual double model_bytes() const = 0;
};

// States brought to one scale, learned from training clips: divided as core::Scaling says.
class PeerScale {
 public:
  PeerScale() = default;
  PeerScale(core::Scaling scaling, const ClipSet& training);

  core::FrameMatrix Apply(const core::StateSequence& sequence) const;

 private:
  core::FeatureScale scale_;
  Eigen::RowVectorXf mean_;  // taken away, so that sums of squares stay small
};

// The index of a clip's label among `labels`.
int LabelIndex(const EvalClip& clip, const std::vector<std::string>& labels);

}  // namespace motiondb::tests
