#include "core/model/track.h"

#include <algorithm>
#include <cmath>

#include "core/model/model.h"

namespace motiondb::core {

Track::Track(const ModelParts& model, int clip)
    : states_(model.states.view()),
      root_path_(model.root_path),
      divisor_(model.scale.divisor),
      leg_length_m_(model.clips[clip].leg_length_m),
      frame_rate_hz_(model.settings.frame_rate_hz),
      first_(model.clips[clip].first_frame),
      count_(model.clips[clip].frame_count) {}

Track::Track(const StateSequence& observation)
    : states_(observation.states.data(), observation.states.rows(), observation.states.cols()),
      root_path_(observation.root_path),
      divisor_(Eigen::RowVectorXf::Ones(observation.states.cols())),
      leg_length_m_(observation.leg_length_m),
      frame_rate_hz_(observation.frame_rate_hz),
      first_(0),
      count_(observation.frame_count()) {}

Eigen::RowVectorXf Track::PoseAt(int from, int frame) const {
  const double turn = root_path_(frame, 2) - root_path_(from, 2);
  const double dx = (root_path_(frame, 0) - root_path_(from, 0)) / leg_length_m_;
  const double dy = (root_path_(frame, 1) - root_path_(from, 1)) / leg_length_m_;
  const double cf = std::cos(root_path_(from, 2));
  const double sf = std::sin(root_path_(from, 2));
  const auto ox = static_cast<float>(cf * dx + sf * dy);
  const auto oy = static_cast<float>(-sf * dx + cf * dy);
  const auto c = static_cast<float>(std::cos(turn));
  const auto s = static_cast<float>(std::sin(turn));
  Eigen::RowVectorXf positions(states_.cols() / 2);
  const float* state = states_.row(frame).data();
  for (Eigen::Index m = 0; m < positions.size() / 3; ++m) {
    const float x = state[6 * m] * divisor_[6 * m];
    const float y = state[6 * m + 1] * divisor_[6 * m + 1];
    positions[3 * m] = ox + c * x - s * y;
    positions[3 * m + 1] = oy + s * x + c * y;
    positions[3 * m + 2] = state[6 * m + 2] * divisor_[6 * m + 2];
  }
  return positions;
}

Eigen::RowVectorXf Track::SeenFrom(int from, double offset_frames) const {
  const double position =
      std::clamp(from + offset_frames, static_cast<double>(first_), end() - 1.0);
  const int before = static_cast<int>(std::floor(position + 1e-6));
  const auto fraction = static_cast<float>(position - before);
  if (fraction < 1e-5F) return PoseAt(from, before);
  return (1 - fraction) * PoseAt(from, before) + fraction * PoseAt(from, before + 1);
}

}  // namespace motiondb::core
