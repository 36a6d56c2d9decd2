#include "tests/bench/take.h"

#include <algorithm>
#include <cmath>

#include "core/motion/mirror.h"

namespace motiondb::tests {

Take MakeTake(std::string label, std::string subject, const core::StateSequence& states) {
  Take take{std::move(label), std::move(subject), states.leg_length_m, {}, {}};
  const Eigen::Index frames = states.states.rows();
  const Eigen::Index markers = states.states.cols() / 6;
  take.pose.resize(frames, 3 * markers);
  for (Eigen::Index m = 0; m < markers; ++m) {
    take.pose.middleCols<3>(3 * m) = states.states.middleCols<3>(6 * m);
  }
  take.step.resize(frames, 3);
  for (Eigen::Index t = 0; t + 1 < frames; ++t) {
    const Eigen::RowVector3d moved = states.root_path.row(t + 1) - states.root_path.row(t);
    const Eigen::Vector2d seen =
        Eigen::Rotation2Dd(-states.root_path(t, 2)) * moved.head<2>().transpose();
    take.step.row(t) << static_cast<float>(seen.x() / take.leg_length_m),
        static_cast<float>(seen.y() / take.leg_length_m), static_cast<float>(moved[2]);
  }
  take.step.row(frames - 1) = take.step.row(frames - 2);
  return take;
}

Take MirroredTake(const std::vector<int>& other_sides, const Take& take) {
  Take mirrored = take;
  mirrored.pose = core::MirrorPositions(other_sides, take.pose);
  mirrored.step.rightCols<2>() *= -1;
  return mirrored;
}

void SampleTake(const Take& take, double at, Eigen::RowVectorXf& pose, Eigen::RowVector3f& step) {
  const Eigen::Index last = take.pose.rows() - 1;
  const auto before = std::min(static_cast<Eigen::Index>(at), last - 1);
  const auto u = static_cast<float>(at - static_cast<double>(before));
  // Catmull-Rom weights, which sum to 1; the end frames are repeated.
  const float u2 = u * u;
  const float u3 = u2 * u;
  pose.noalias() =
      (-0.5f * u + u2 - 0.5f * u3) * take.pose.row(std::max<Eigen::Index>(before, 1) - 1);
  pose.noalias() += (1 - 2.5f * u2 + 1.5f * u3) * take.pose.row(before);
  pose.noalias() += (0.5f * u + 2 * u2 - 1.5f * u3) * take.pose.row(before + 1);
  pose.noalias() += (0.5f * u3 - 0.5f * u2) * take.pose.row(std::min(before + 2, last));
  step = (1 - u) * take.step.row(before) + u * take.step.row(before + 1);
}

}  // namespace motiondb::tests
