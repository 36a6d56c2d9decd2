// Peer: the label of the nearest stored window, frame by frame, of all that there are.
#pragma once

#include "tests/eval/peers/frame_distances.h"
#include "tests/eval/peers/peer.h"

namespace motiondb::tests {

// The smallest mean squared difference (over the numbers present) between the window `observed`
// and a run of as many stored frames. Where fewer are stored, their mean against as many of the
// window's frames. O(observed x stored frames x dimensions).
double NearestWindow(const StoredFrames& stored, const core::FrameMatrix& observed);

class WindowedNearest : public Peer {
 public:
  explicit WindowedNearest(core::Scaling scaling) : scaling_(scaling) {}

  absl::Status Learn(const ClipSet& training, const std::vector<std::string>& labels) override;
  // Minus the distance of each label's nearest window. A longer observation is cut into windows of
  // 0.4 s every 0.1 s and their distances are averaged.
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
