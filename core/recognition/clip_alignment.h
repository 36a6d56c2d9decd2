// Alignment of an observation with a stored clip: a hidden Markov model whose states are the clip's
// frames.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/model/metric_frames.h"
#include "core/motion/execution.h"

namespace motiondb::core {

// Forward algorithm: the sum over all paths of an observation through a clip's frames, in the model
// of AlignToClip. Call Begin, then AddFrame or AddRoots for each observed frame. Reusable; not
// thread-safe.
class PathSum {
 public:
  // Begins a clip of `count` strided frames.
  void Begin(Eigen::Index count, bool anchored);

  // Adds a frame with these squared distances (`count`) from the clip's frames.
  void AddFrame(const Eigen::Ref<const Eigen::ArrayXf>& squared_distances);

  // Faster form of AddFrame. `roots` (`count`): fourth roots of the densities, divided by the
  // density of the nearest frame. `nearest`: squared distance of that frame. `cut_off`: the result
  // of Roots, which raises small roots to exp(-80). If this may change the sum, IsExact returns
  // false: begin again with AddFrame.
  void AddRoots(const Eigen::Ref<const Eigen::ArrayXf>& roots, float nearest, bool cut_off = true);
  // Computes the roots. Returns whether some were raised.
  static bool Roots(const Eigen::Ref<const Eigen::ArrayXf>& squared_distances, float nearest,
                    Eigen::Ref<Eigen::ArrayXf> roots);
  bool IsExact() const;

  // Returns the natural logarithm of the sum.
  double LogEvidence() const;
  // Returns an upper bound of LogEvidence, given the sum of the frames' squared distances from the
  // clip's nearest frames.
  static double LogEvidenceBound(Eigen::Index count, double nearest_sum);

 private:
  // Sums over the paths that end in each frame, scaled to a maximum of 1, after two zeros. The
  // range of doubles is large enough for paths that become probable late.
  Eigen::ArrayXd ending_;
  Eigen::ArrayXd arrival_;  // sums over the paths that arrive at each frame
  Eigen::ArrayXd next_;     // buffer for the next ending_
  Eigen::Index count_ = 0;
  bool begun_ = false;
  // The true sums are ending_ * exp(log_sum_) * scale_.
  double log_sum_ = 0;
  double scale_ = 1;
  double sum_ = 1;  // sum of ending_, computed by AddRoots
  double raised_fraction_ =
      0;  // upper bound of the fraction of the sum that comes from raised roots
};

class ThrottledCancellation;

// Observed frames in blocks of kFrameLanes, for comparison with stored frames. Immutable.
class ObservedFrames {
 public:
  // `observed`: frames x K, in the metric.
  explicit ObservedFrames(const FrameMatrix& observed);

  int count() const { return frames_; }
  int block_count() const { return static_cast<int>(blocks_.size()); }
  int CountOf(int block) const;
  // Writes the squared distances between the stored `rows` and the frames of a block to `distances`
  // (rows x kFrameLanes).
  void ComputeDistances(const MetricFrames& stored, RowRange rows, int block,
                        Eigen::ArrayXXf& distances) const;

 private:
  int frames_ = 0;
  std::vector<FrameMatrix> blocks_;  // dimensions x kFrameLanes each
  Eigen::ArrayXf squared_norms_;
};

// The stored frame nearest to an observed one.
struct NearestFrame {
  float squared_distance = 0;
  int frame = 0;  // of the model
};

// Updates `nearest` if one of the stored `rows` is nearer to the observed frame.
// `squared_distances`: from these rows; `minimum`: their minimum.
void UpdateNearest(const MetricFrames& stored, RowRange rows,
                   const Eigen::Ref<const Eigen::ArrayXf>& squared_distances, float minimum,
                   NearestFrame& nearest);

struct ClipAlignment {
  double log_evidence = 0;
  std::vector<NearestFrame> nearest;  // one for each observed frame
};

// Aligns an observation (frames x K, in the metric, at the stride of `stored`) with stored `rows`:
// a clip or a part of it. With each observed frame the clip advances by 0, 1 or 2 strided frames
// with probability 0.2, 0.6, 0.2. The log density of an observed frame z in the clip's frame z_j is
// -|z - z_j|^2 / 6. Sums over all
// paths. A path may start and end at any frame; if `anchored`, a start at the j-th strided frame
// costs 2 j. O(observed frames * strided frames * K).
ClipAlignment AlignToClip(const MetricFrames& stored, RowRange rows, const FrameMatrix& observed,
                          bool anchored);

// AlignToClip for one observation and several clips or parts; reuses its memory. Not thread-safe.
class ClipAligner {
 public:
  ClipAligner(const FrameMatrix& observed, bool anchored);

  // Returns the log evidence, and updates `nearest` (one for each observed frame). If cancelled,
  // returns early with an invalid result.
  double Align(const MetricFrames& stored, RowRange rows, std::vector<NearestFrame>& nearest,
               const Cancelled& cancelled = {});

 private:
  double LogEvidenceByDistances(const MetricFrames& stored, RowRange rows,
                                ThrottledCancellation& cancellation);

  const ObservedFrames observed_;
  const bool anchored_;
  PathSum paths_;
  Eigen::ArrayXXf distances_;  // rows x frames of the block
  Eigen::ArrayXf roots_;
};

}  // namespace motiondb::core
