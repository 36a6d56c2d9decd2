// A recorded clip told from its own reference frame, so that takes can follow one another anywhere
// on the floor. Plain values; functions are safe to call from any thread.
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
  // frames x 3: where the reference frame is at the next frame, seen from this one: forward and
  // left (leg lengths), turn (rad). The last row repeats the one before.
  core::FrameMatrix step;

  double last_frame() const { return static_cast<double>(pose.rows() - 1); }
};

// `states` has two frames or more.
Take MakeTake(std::string label, std::string subject, const core::StateSequence& states);

// Left and right exchanged; `other_sides` as OtherSides gives it.
Take MirroredTake(const std::vector<int>& other_sides, const Take& take);

// Pose and step at a time between frames, `at` in [0, last_frame()]: cubic and linear.
void SampleTake(const Take& take, double at, Eigen::RowVectorXf& pose, Eigen::RowVector3f& step);

}  // namespace motiondb::tests
