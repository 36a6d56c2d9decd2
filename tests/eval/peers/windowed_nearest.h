// Peer: the label of the nearest stored window by exhaustive search.
#pragma once

#include "tests/eval/peers/frame_distances.h"
#include "tests/eval/peers/peer.h"

namespace motiondb::tests {

// Returns the minimum mean squared difference (values present) between the window `observed` and a
// stored run of equal length. If fewer frames are stored, compares all of them with as many frames
// of the window. O(observed x stored frames x dimensions).
double NearestWindow(const StoredFrames& stored, const core::FrameMatrix& observed);

class WindowedNearest : public Peer {
 public:
  explicit WindowedNearest(core::Scaling scaling) : scaling_(scaling) {}

  absl::Status Learn(const ClipSet& training, const std::vector<std::string>& labels) override;
  // Returns minus the distance of each label's nearest window. A longer observation is split into
  // windows of 0.4 s every 0.1 s; their distances are averaged.
  std::vector<double> Score(const core::StateSequence& observation, Extent extent) const override;
  double model_bytes() const override;

 private:
  const core::Scaling scaling_;
  PeerScale scale_;
  std::size_t label_count_ = 0;
  std::vector<StoredFrames> clips_;
  std::vector<int> labels_;  // of clips_
};

}  // namespace motiondb::tests
