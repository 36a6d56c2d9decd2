// One motion as poses that can be seen from any of its frames: what a key to the future and the
// future itself are made of. A view; what it looks at must outlive it. Safe to share.
#pragma once

#include <Eigen/Core>

#include "core/motion/states.h"

namespace motiondb::core {

struct ModelParts;

class Track {
 public:
  // A stored clip (index into `clips`).
  Track(const ModelParts& model, int clip);
  // An observation, not scaled.
  explicit Track(const StateSequence& observation);

  // Frames [first, end) in the numbering of its owner.
  int first() const { return first_; }
  int end() const { return first_ + count_; }
  double frame_rate_hz() const { return frame_rate_hz_; }

  // Marker positions (3 N_v, leg lengths) `frames_on` frames after frame `from` (a fraction is
  // interpolated; before the first frame or after the last it is that frame's), in the reference
  // frame of `from`. NaN where a marker is missing.
  Eigen::RowVectorXf SeenFrom(int from, double frames_on) const;

 private:
  // Of one frame, by itself.
  Eigen::RowVectorXf Whole(int from, int frame) const;

  Eigen::Map<const FrameMatrix> states_;
  const RootPath& root_path_;
  Eigen::RowVectorXf divisor_;  // 6 N_v: what states were divided by
  double leg_length_m_;
  double frame_rate_hz_;
  int first_;
  int count_;
};

}  // namespace motiondb::core
