// Peer: the label of the nearest stored clip by dynamic time warping. Windows match a part of a
// clip, prefixes its beginning.
#pragma once

#include "tests/eval/peers/frame_distances.h"
#include "tests/eval/peers/peer.h"

namespace motiondb::tests {

struct WarpEnds {
  bool free_start = false;  // the path may begin at any stored frame
  bool free_end = false;    // the path may end at any stored frame
};

// Returns the minimum cost of a warping path through `costs` (observed x stored frames), from the
// first to the last observed frame. Steps: (1, 0), (0, 1) and (1, 1); each cell counts once.
// O(cells).
double WarpCost(const core::FrameMatrix& costs, WarpEnds ends);

class SubsequenceDtw : public Peer {
 public:
  explicit SubsequenceDtw(core::Scaling scaling) : scaling_(scaling) {}

  absl::Status Learn(const ClipSet& training, const std::vector<std::string>& labels) override;
  // Returns minus the cost per frame of each label's nearest clip. The local cost is the mean
  // squared difference of the values present. The cost is divided by the frames of both motions for
  // whole clips, by the observed frames otherwise.
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
