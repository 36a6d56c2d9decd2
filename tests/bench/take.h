// A recorded clip in its own reference frame, so that takes can follow one another anywhere on the
// floor.
#pragma once

#include <string>
#include <vector>

#include "core/motion/states.h"

namespace motiondb::tests {

struct Take {
  std::string label;
  std::string subject;
  double leg_length_m = 0;
  core::FrameMatrix pose;  // frames x 3 N_v: positions in the reference frame, leg lengths
  // frames x 3: the next frame's reference frame seen from this one: forward and left (leg
  // lengths), turn (rad). The last row repeats the previous one.
  core::FrameMatrix step;

  double last_frame() const { return static_cast<double>(pose.rows() - 1); }
};

// `states` must have at least two frames.
Take MakeTake(std::string label, std::string subject, const core::StateSequence& states);

// Exchanges left and right; `other_sides` is from OtherSides.
Take MirroredTake(const std::vector<int>& other_sides, const Take& take);

// Interpolates pose (cubic) and step (linear) at a frame number `at` in [0, last_frame()].
void SampleTake(const Take& take, double at, Eigen::RowVectorXf& pose, Eigen::RowVector3f& step);

}  // namespace motiondb::tests
