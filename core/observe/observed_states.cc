#include "core/observe/observed_states.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/motion/frame_state.h"

namespace motiondb::core {
ObservedStates::ObservedStates(MarkerSet set, double frame_rate_hz, int capacity)
    : set_(std::move(set)), frame_rate_hz_(frame_rate_hz) {
  const int rows = std::max(capacity, 3);
  positions_.setZero(rows, 3 * set_.marker_count());
  root_path_.setZero(rows, 3);
  states_.setZero(rows, set_.dimension_count());
}

int ObservedStates::kept() const {
  return static_cast<int>(std::min<std::int64_t>(next_, states_.rows()));
}

bool ObservedStates::Place(std::int64_t frame) {
  const HipLine hips = ReadHips(Marker(frame, set_.landmarks.left_hip).cast<double>().transpose(),
                                Marker(frame, set_.landmarks.right_hip).cast<double>().transpose());
  auto root = root_path_.row(frame % root_path_.rows());
  if (frame == 0) {
    if (!hips.turned) return false;
    root.setZero();
  } else {
    root = root_path_.row((frame - 1) % root_path_.rows());
  }
  if (hips.placed) root.head<2>() = hips.middle.transpose();
  if (hips.turned) root[2] += std::remainder(hips.heading - root[2], 2 * std::numbers::pi);
  return true;
}

void ObservedStates::MakeState(std::int64_t frame) {
  const auto marker_at = [&](int offset, Eigen::Index m) -> Eigen::Vector3d {
    const std::int64_t n = frame + offset;
    if (n < 0 || n > next_) return Eigen::Vector3d::Constant(std::nan(""));
    return Marker(n, m).cast<double>().transpose();
  };
  MakeFrameState(marker_at, root_path_.row(frame % root_path_.rows()).transpose(), frame_rate_hz_,
                 leg_length_m_, states_.row(frame % states_.rows()));
}

bool ObservedStates::Push(const Eigen::Ref<const Eigen::RowVectorXf>& positions_m) {
  positions_.row(next_ % positions_.rows()) = positions_m;
  if (!Place(next_)) return false;
  if (next_ > 0) MakeState(next_ - 1);
  MakeState(next_);
  ++next_;
  return true;
}

StateSequence ObservedStates::Last(int frames) const {
  StateSequence last{frame_rate_hz_, leg_length_m_, FrameMatrix(frames, states_.cols()),
                     RootPath(frames, 3)};
  for (int i = 0; i < frames; ++i) {
    const std::int64_t at = (next_ - frames + i) % states_.rows();
    last.states.row(i) = states_.row(at);
    last.root_path.row(i) = root_path_.row(at);
  }
  return last;
}

MarkerMotion ObservedStates::LastPositions(int frames) const {
  MarkerMotion last{set_.markers, frame_rate_hz_, FrameMatrix(frames, positions_.cols())};
  for (int i = 0; i < frames; ++i) {
    last.positions_m.row(i) = positions_.row((next_ - frames + i) % positions_.rows());
  }
  return last;
}

}  // namespace motiondb::core
