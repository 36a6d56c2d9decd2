// Peers of the estimation of missing markers.
#pragma once

#include "core/motion/states.h"
#include "tests/eval/peers/frame_distances.h"
#include "tests/eval/peers/peer.h"

namespace motiondb::tests {

// Returns marker positions in the world (m, frames x 3 N_v). A missing marker is interpolated
// linearly between the frames before and after with it, or copied from the only one. NaN if it is
// never seen.
core::FrameMatrix FillByInterpolation(const core::StateSequence& observation);

// Copies the missing markers of each frame from the nearest stored frame, by the numbers present.
class FillFromNearest {
 public:
  explicit FillFromNearest(const ClipSet& training);

  // Returns positions as above.
  core::FrameMatrix Fill(const core::StateSequence& observation) const;

 private:
  PeerScale scale_;
  core::FrameMatrix states_;  // not scaled
  StoredFrames stored_;       // scaled
};

}  // namespace motiondb::tests
