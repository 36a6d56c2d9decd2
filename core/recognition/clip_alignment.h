// How well a stored clip's own course explains an observation: a hidden Markov model whose states
// are the clip's frames. Safe to call from any thread.
#pragma once

#include <vector>

#include "core/model/metric_frames.h"

namespace motiondb::core {

// The stored frame that an observed one is most like.
struct NearestFrame {
  float squared_distance = 0;
  int frame = 0;  // of the model
};

struct ClipAlignment {
  double log_evidence = 0;
  std::vector<NearestFrame> nearest;  // one for each observed frame
};

// `observed`: frames x K, in the metric, at the stride of `stored`. From frame to frame the clip
// moves on by 0, 1 or 2 of its strided frames with probability 0.2, 0.6, 0.2; frame z is seen for
// z_j with log density -|z - z_j|^2 / 6; all paths are summed. Any start and any end; `anchored`, a
// start at the clip's j-th strided frame costs 2 j. O(frames * frames * K).
ClipAlignment AlignToClip(const MetricFrames& stored, int clip, const FrameMatrix& observed,
                          bool anchored);

}  // namespace motiondb::core
