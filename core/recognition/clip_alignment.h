// How well a stored clip's own course explains an observation: a hidden Markov model whose states
// are the clip's frames. The functions are safe to call from any thread.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/model/metric_frames.h"
#include "core/motion/cancellation.h"
#include "core/recognition/path_sum.h"

namespace motiondb::core {

class Patience;

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

// The same of one observation and clip after clip, in memory that is used again. Not thread-safe.
class ClipAligner {
 public:
  ClipAligner(const FrameMatrix& observed, bool anchored);

  // The clip's log evidence. Where it has nearer frames than `nearest` (one for each observed
  // frame), they take that place. Once cancelled it returns early, with what is of no use.
  double Align(const MetricFrames& stored, int clip, std::vector<NearestFrame>& nearest,
               const Cancelled& cancelled = {});

 private:
  // Squared distances (frames x count) of a block's frames to the clip's.
  void ComputeDistances(const MetricFrames& stored, int first, int count, int block);
  double LogEvidenceByDistances(const MetricFrames& stored, int first, int count,
                                Patience& patience);
  int FramesOf(int block) const;

  const int frames_;
  const bool anchored_;
  // Blocks of kFrameLanes observed frames, each dimensions x kFrameLanes, and their squared norms.
  std::vector<FrameMatrix> observed_;
  Eigen::ArrayXf observed_norms_;
  PathSum paths_;
  Eigen::ArrayXXf distances_;  // clip's frames x block's
  Eigen::ArrayXf roots_;
};

}  // namespace motiondb::core
