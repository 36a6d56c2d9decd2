// Which stored frames recognition compares: about 30 a second. Plain value.
#pragma once

#include <vector>

namespace motiondb::core {

struct ModelClip;

// Frames from one compared to the next: 2 at 60 Hz, 1 below 45 Hz.
int FrameStride(double frame_rate_hz);

// Every stride-th frame of each clip, from its first.
struct StridedFrames {
  std::vector<int> frame;  // row -> frame of the model
  std::vector<int> begin;  // clip c has the rows [begin[c], begin[c + 1])

  int count(int clip) const { return begin[clip + 1] - begin[clip]; }
};
StridedFrames StrideFrames(const std::vector<ModelClip>& clips, double frame_rate_hz);

}  // namespace motiondb::core
