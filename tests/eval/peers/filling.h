// Peers of filling in missing markers. Safe to call from any thread.
#pragma once

#include "core/motion/states.h"
#include "tests/eval/peers/frame_distances.h"
#include "tests/eval/peers/peer.h"

namespace motiondb::tests {

// Marker positions in the world (m, frames x 3 N_v): a missing marker is on the line from where it
// was last seen to where it is next seen; where it has only one of them, there; NaN where it is
// never seen.
core::FrameMatrix FillByInterpolation(const core::StateSequence& observation);

// The missing markers of each frame as the stored frame has them that is nearest by the numbers
// present.
class FillFromNearest {
 public:
  explicit FillFromNearest(const ClipSet& training);

  // As above.
  core::FrameMatrix Fill(const core::StateSequence& observation) const;

 private:
  PeerScale scale_;
  core::FrameMatrix states_;  // not scaled
  StoredFrames stored_;       // scaled
};

}  // namespace motiondb::tests
