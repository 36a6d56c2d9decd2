#include "core/observe/observed_states.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "core/motion/error.h"
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

namespace {

constexpr double kMaxRatio = 100;
constexpr double kSameRateHz = 1e-6;
constexpr float kMissing = std::numeric_limits<float>::quiet_NaN();

}  // namespace

absl::StatusOr<MarkerStream> MarkerStream::Create(const MarkerScheme& scheme,
                                                  const std::vector<std::string>& marker_names,
                                                  double from_hz, double to_hz) {
  if (!(from_hz >= to_hz / kMaxRatio && from_hz <= to_hz * kMaxRatio)) {
    return FieldViolation("frame_rate_hz", "expected {} to {} for a model of {} Hz, got {}",
                          to_hz / kMaxRatio, to_hz * kMaxRatio, to_hz, from_hz);
  }
  MarkerStream stream;
  MOTIONDB_ASSIGN_OR_RETURN(stream.mapping_, BindMapping(scheme, marker_names));
  if (stream.mapping_.has_offsets) {
    return InvalidArgument("mapping '{}' has offsets in link frames, but the stream has no links",
                           stream.mapping_.name);
  }
  stream.step_ = std::abs(from_hz - to_hz) < kSameRateHz ? 1 : from_hz / to_hz;
  stream.missing_.setConstant(static_cast<Eigen::Index>(3 * marker_names.size()), kMissing);
  stream.made_.setZero(3 * scheme.set.marker_count());
  stream.rows_.assign(kRows, stream.made_);
  return stream;
}

void MarkerStream::Push(const Eigen::Ref<const Eigen::RowVectorXf>& positions_m) {
  Eigen::RowVectorXf& mapped = rows_[static_cast<std::size_t>(taken_ % kRows)];
  mapped.setZero();
  for (std::size_t m = 0; m < mapping_.rules.size(); ++m) {
    auto marker = mapped.segment<3>(static_cast<Eigen::Index>(3 * m));
    for (const auto& [point, weight] : mapping_.rules[m].points) {
      marker += static_cast<float>(weight) * positions_m.segment<3>(3 * point);
    }
    // A marker with one missing coordinate is missing.
    if (mapping_.rules[m].points.empty() || marker.hasNaN()) marker.setConstant(kMissing);
  }
  ++taken_;
}

const Eigen::RowVectorXf& MarkerStream::Row(std::int64_t frame) const {
  return rows_[static_cast<std::size_t>(std::max<std::int64_t>(frame, 0) % kRows)];
}

const Eigen::RowVectorXf* MarkerStream::Next() {
  const double at = static_cast<double>(given_) * step_;
  const auto before = static_cast<std::int64_t>(std::floor(at + 1e-9));
  const auto u = static_cast<float>(std::max(0.0, at - static_cast<double>(before)));
  if (u < 1e-6F) {  // exactly a source frame; its neighbours may be missing
    if (before >= taken_) return nullptr;
    made_ = Row(before);
  } else {
    if (before + 2 >= taken_) return nullptr;
    for (Eigen::Index c = 0; c < made_.size(); ++c) {
      made_[c] =
          CatmullRom(Row(before - 1)[c], Row(before)[c], Row(before + 1)[c], Row(before + 2)[c], u);
    }
  }
  ++given_;
  return &made_;
}

void MarkerStream::Restart() {
  taken_ = 0;
  given_ = 0;
}

}  // namespace motiondb::core
