#include "core/observe/observed_states.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace motiondb::core {
namespace {

// As ReferenceFrames: below this part of its length on the floor, the line between the hips does
// not tell the front.
constexpr double kMinFloorShare = 0.2;

}  // namespace

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
  const Eigen::Vector3d left = Marker(frame, set_.landmarks.left_hip).cast<double>().transpose();
  const Eigen::Vector3d right = Marker(frame, set_.landmarks.right_hip).cast<double>().transpose();
  const Eigen::Vector3d across = left - right;
  const double on_floor = across.head<2>().norm();
  const bool turned = on_floor > 0 && on_floor >= kMinFloorShare * across.norm();
  auto root = root_path_.row(frame % root_path_.rows());
  if (frame == 0) {
    if (!turned) return false;
    root.setZero();
  } else {
    root = root_path_.row((frame - 1) % root_path_.rows());
  }
  if (across.allFinite()) root.head<2>() = (0.5 * (left + right)).head<2>().transpose();
  if (turned) {
    const double raw = std::atan2(across.y(), across.x()) - std::numbers::pi / 2;
    root[2] += std::remainder(raw - root[2], 2 * std::numbers::pi);
  }
  return true;
}

void ObservedStates::MakeState(std::int64_t frame) {
  const auto root = root_path_.row(frame % root_path_.rows());
  const Eigen::Matrix2d turn = Eigen::Rotation2Dd(-root[2]).toRotationMatrix();
  const Eigen::Vector3d origin(root[0], root[1], 0);
  auto state = states_.row(frame % states_.rows());
  const auto put = [&](Eigen::Index column, Eigen::Vector3d v) {
    v.head<2>() = turn * v.head<2>();
    state.segment<3>(column) = (v / leg_length_m_).cast<float>().transpose();
  };
  for (Eigen::Index m = 0; m < set_.marker_count(); ++m) {
    const Eigen::Vector3d here = Marker(frame, m).cast<double>().transpose();
    put(6 * m, here - origin);
    // The neighbours that are there; the frame itself stands in for one that is not.
    double span = 0;
    const auto neighbour = [&](std::int64_t n) -> Eigen::Vector3d {
      if (n < 0 || n > next_ || Marker(n, m).hasNaN()) return here;
      span += 1;
      return Marker(n, m).cast<double>().transpose();
    };
    const Eigen::Vector3d before = neighbour(frame - 1);
    const Eigen::Vector3d after = neighbour(frame + 1);
    put(6 * m + 3, span > 0 ? Eigen::Vector3d((after - before) * frame_rate_hz_ / span)
                            : Eigen::Vector3d::Constant(std::nan("")));
  }
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
