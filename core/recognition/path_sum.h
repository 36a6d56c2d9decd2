// The sum over all ways through a clip's frames that an observation may have taken, frame by frame.
// Scratch for one alignment after the other; not thread-safe.
#pragma once

#include <Eigen/Core>

namespace motiondb::core {

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
  static double LogEvidenceAtMost(Eigen::Index count, double nearest_sum);

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

}  // namespace motiondb::core
