// Pose history of a moment: the current pose and the poses every 0.04 s before, in the current
// reference frame, in leg lengths. Prediction compares moments by this history.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/motion/states.h"

namespace motiondb::core {

struct ModelParts;

// A motion as poses relative to any of its frames. A view: the model or observation must outlive
// it.
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

inline constexpr double kLagSeconds = 0.04;
inline constexpr int kLags = 9;

// Returns the history, (1 + kLags) x 3 N_v, the current pose first.
FrameMatrix HistoryAt(const Track& track, int frame);

// Returns the input of the motion prior, (1 + kLags) 3 N_v numbers: the pose with a small weight,
// and the movements from lag to lag, the latest with the largest weight.
Eigen::RowVectorXf MotionFeatures(const FrameMatrix& history);

// Returns the key of a moment, 12 N_v numbers: the pose, and the movements over the last 1, 3 and 8
// lags, divided by the square root of the number of markers. The distance of two keys is the
// distance of a typical marker.
Eigen::RowVectorXf HistoryKey(const FrameMatrix& history);
// As above, from the four necessary poses only.
Eigen::RowVectorXf HistoryKeyAt(const Track& track, int frame);

}  // namespace motiondb::core
