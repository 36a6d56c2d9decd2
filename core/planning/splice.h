// Playing runs of stored frames one after the other as one motion: at each join the run that ends
// fades into the one that begins. Safe to call from any thread.
#pragma once

#include <vector>

#include "core/planning/stored_floor.h"

namespace motiondb::core {

// One run is left after frame `leave`, and the next goes on after frame `enter`, which is most like
// it. From `half_window` frames before to as many after, both are played at once, the first fading
// into the second; both clips have these frames.
struct Join {
  int leave = 0;
  int enter = 0;
  int half_window = 0;
};

// Frames start, start + 1 ... joins[0].leave, joins[0].enter + 1 ... end. Windows do not overlap.
struct SplicedPath {
  int start = 0;
  std::vector<Join> joins;
  int end = 0;
};

// What is played at one frame: mostly a stored frame, within a join two.
struct PlayedFrame {
  int main = 0;      // the one that weighs more
  int fading = -1;   // the other; -1 outside joins
  double share = 0;  // of the fading one, below or at 0.5
};

std::vector<PlayedFrame> PlayedFrames(const SplicedPath& path);

// How the root moves from frame leave - half_window to enter + half_window: steps of both runs,
// one fading into the other.
FloorPose AcrossJoin(const StoredFloor& floor, const Join& join);

// Reference frames at each played frame, the first at the origin.
std::vector<FloorPose> PlayedRoot(const StoredFloor& floor, const SplicedPath& path);

}  // namespace motiondb::core
