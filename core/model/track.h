// A motion as poses relative to any of its frames, for pose histories and predictions. A view: the
// model or observation must outlive it.
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

  // Frames first to end - 1, as numbered in the model or observation.
  int first() const { return first_; }
  int end() const { return first_ + count_; }
  double frame_rate_hz() const { return frame_rate_hz_; }

  // Returns the marker positions (3 N_v, leg lengths) `offset_frames` frames after frame `from`, in
  // the reference frame of `from`. Interpolates between frames; constant before the first and after
  // the last frame. NaN: missing marker.
  Eigen::RowVectorXf SeenFrom(int from, double offset_frames) const;

 private:
  // As SeenFrom, for an integer frame.
  Eigen::RowVectorXf PoseAt(int from, int frame) const;

  Eigen::Map<const FrameMatrix> states_;
  const RootPath& root_path_;
  Eigen::RowVectorXf divisor_;  // 6 N_v: scale of the states
  double leg_length_m_;
  double frame_rate_hz_;
  int first_;
  int count_;
};

}  // namespace motiondb::core
