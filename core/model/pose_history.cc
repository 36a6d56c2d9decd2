#include "core/model/pose_history.h"

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

namespace {

// Chosen by leave-one-out over 25 clips at 25 Hz (docs/benchmarks.md). The error hardly changes
// near these values.
constexpr float kPose = 0.1F;
constexpr float kLatestStep = 3;
constexpr float kStepDecay = 0.7F;
constexpr float kKeyPose = 0.5F;
struct KeyMove {
  int lags;
  float weight;
};
constexpr KeyMove kKeyMoves[] = {{1, 4}, {3, 2}, {8, 0.7F}};

// Returns the key from the current pose and a function that returns the pose at a lag.
template <typename PoseAt>
Eigen::RowVectorXf MakeKey(const Eigen::RowVectorXf& now, const PoseAt& pose_at) {
  const Eigen::Index numbers = now.size();
  Eigen::RowVectorXf key(4 * numbers);
  key.head(numbers) = kKeyPose * now;
  Eigen::Index at = numbers;
  for (const KeyMove& move : kKeyMoves) {
    key.segment(at, numbers) = move.weight * (now - pose_at(move.lags));
    at += numbers;
  }
  return key / std::sqrt(static_cast<float>(numbers) / 3);
}

}  // namespace

FrameMatrix HistoryAt(const Track& track, int frame) {
  const double frames = kLagSeconds * track.frame_rate_hz();
  const Eigen::RowVectorXf now = track.SeenFrom(frame, 0);
  FrameMatrix history(1 + kLags, now.size());
  history.row(0) = now;
  for (int lag = 1; lag <= kLags; ++lag) history.row(lag) = track.SeenFrom(frame, -lag * frames);
  return history;
}

Eigen::RowVectorXf MotionFeatures(const FrameMatrix& history) {
  const Eigen::Index numbers = history.cols();
  Eigen::RowVectorXf features(history.size());
  features.head(numbers) = kPose * history.row(0);
  float weight = kLatestStep;
  for (Eigen::Index lag = 1; lag < history.rows(); ++lag) {
    features.segment(lag * numbers, numbers) = weight * (history.row(lag - 1) - history.row(lag));
    weight *= kStepDecay;
  }
  return features;
}

Eigen::RowVectorXf HistoryKey(const FrameMatrix& history) {
  return MakeKey(history.row(0), [&](int lags) { return history.row(lags); });
}

Eigen::RowVectorXf HistoryKeyAt(const Track& track, int frame) {
  const double frames = kLagSeconds * track.frame_rate_hz();
  return MakeKey(track.SeenFrom(frame, 0),
                 [&](int lags) { return track.SeenFrom(frame, -lags * frames); });
}

}  // namespace motiondb::core
