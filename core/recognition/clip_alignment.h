// How well a stored clip's own course explains an observation, by the sum over all ways through it.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/model/metric_frames.h"
#include "core/motion/cancellation.h"

namespace motiondb::core {

// The sum over all ways through a clip's frames that an observation may have taken, frame by frame.
// Scratch for one alignment after the other; not thread-safe.

// The model of AlignToClip (clip_alignment.h): Begin, then See each observed frame, all in the same
// way.
class PathSum {
 public:
  // A clip of `count` strided frames.
  void Begin(Eigen::Index count, bool anchored);

  // A frame at these squared distances (`count`) from the clip's.
  void See(const Eigen::Ref<const Eigen::ArrayXf>& squared_distances);

  // The same, faster, from the fourth roots (`count`) of the densities relative to the nearest
  // frame's, and the squared distance of that. Roots of frames that are too far off are cut off at
  // what a float holds: where ways through these may count, IsExact is false, and See has to be
  // used.
  void SeeRoots(const Eigen::Ref<const Eigen::ArrayXf>& roots, float nearest, bool cut_off = true);
  // Returns whether some are cut off.
  static bool Roots(const Eigen::Ref<const Eigen::ArrayXf>& squared_distances, float nearest,
                    Eigen::Ref<Eigen::ArrayXf> roots);
  bool IsExact() const;

  // Natural log of the sum.
  double LogEvidence() const;
  // It is not above this for frames whose squared distances to the clip's nearest sum up to
  // `nearest_sum`.
  static double LogEvidenceBound(Eigen::Index count, double nearest_sum);

 private:
  // Sums over the paths that end in each frame, the greatest being 1, behind two places where none
  // does. Doubles reach so far below it that a path which catches up late is not lost.
  Eigen::ArrayXd ending_;
  Eigen::ArrayXd arrival_;  // sums over the paths that arrive at each frame
  Eigen::ArrayXd next_;     // as ending_
  Eigen::Index count_ = 0;
  bool begun_ = false;
  // What `ending_` is to be multiplied with: the logarithm of one part, and the other.
  double log_sum_ = 0;
  double scale_ = 1;
  double sum_ = 1;   // of `ending_`, from roots
  double blur_ = 0;  // at most so much of the sum is from roots that are cut off
};

// How well a stored clip's own course explains an observation: a hidden Markov model whose states
// are the clip's frames. The functions are safe to call from any thread.
class ThrottledCancellation;

// Observed frames as they are compared with stored ones: in blocks of kFrameLanes. Immutable.
class ObservedFrames {
 public:
  // `observed`: frames x K, in the metric.
  explicit ObservedFrames(const FrameMatrix& observed);

  int count() const { return frames_; }
  int block_count() const { return static_cast<int>(blocks_.size()); }
  int CountOf(int block) const;
  // Replaces `distances` (the clip's strided frames x kFrameLanes) by the squared distances of a
  // block's frames to them.
  void ComputeDistances(const MetricFrames& stored, int clip, int block,
                        Eigen::ArrayXXf& distances) const;

 private:
  int frames_ = 0;
  std::vector<FrameMatrix> blocks_;  // dimensions x kFrameLanes each
  Eigen::ArrayXf squared_norms_;
};

// The stored frame that an observed one is most like.
struct NearestFrame {
  float squared_distance = 0;
  int frame = 0;  // of the model
};

// Puts the frame nearest to an observed one, if it is nearer than `nearest`, in its place.
// `squared_distances` are those to the clip's strided frames, `least` is the least of them.
void TakeNearer(const MetricFrames& stored, int clip,
                const Eigen::Ref<const Eigen::ArrayXf>& squared_distances, float least,
                NearestFrame& nearest);

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
  double LogEvidenceByDistances(const MetricFrames& stored, int clip,
                                ThrottledCancellation& cancellation);

  const ObservedFrames observed_;
  const bool anchored_;
  PathSum paths_;
  Eigen::ArrayXXf distances_;  // clip's frames x block's
  Eigen::ArrayXf roots_;
};

}  // namespace motiondb::core
