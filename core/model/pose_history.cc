#include "core/model/pose_history.h"

#include <cmath>

namespace motiondb::core {
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
