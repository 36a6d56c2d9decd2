#include "core/motion/past.h"

#include <algorithm>
#include <cmath>

#include "core/motion/floor_origin.h"

namespace motiondb::core {

StateSequence PastAt(const StateSequence& observation, int frame, int history) {
  const int count = std::min(history, frame + 1);
  const int first = frame + 1 - count;
  StateSequence past{observation.frame_rate_hz, observation.leg_length_m,
                     observation.states.middleRows(first, count),
                     observation.root_path.middleRows(first, count)};
  if (frame == 0 || frame + 1 == observation.frame_count()) return past;

  StateSequence last_two{observation.frame_rate_hz, observation.leg_length_m,
                         observation.states.middleRows(frame - 1, 2),
                         observation.root_path.middleRows(frame - 1, 2)};
  const Eigen::Vector2d origin = NearestCorner(last_two.root_path.row(0).head<2>().transpose());
  last_two.root_path.leftCols<2>().rowwise() -= origin.transpose();
  const FrameMatrix positions = WorldPositions(last_two);
  const double c = std::cos(observation.root_path(frame, 2));
  const double s = std::sin(observation.root_path(frame, 2));
  const auto to_states = static_cast<float>(observation.frame_rate_hz / observation.leg_length_m);
  for (Eigen::Index m = 0; m < positions.cols() / 3; ++m) {
    const Eigen::RowVector3f v =
        (positions.row(1) - positions.row(0)).segment<3>(3 * m) * to_states;
    past.states.row(count - 1).segment<3>(6 * m + 3) << static_cast<float>(c * v.x() + s * v.y()),
        static_cast<float>(-s * v.x() + c * v.y()), v.z();
  }
  return past;
}

}  // namespace motiondb::core
