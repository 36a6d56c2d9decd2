#include "core/observe/marker_stream.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/motion/catmull_rom.h"
#include "core/motion/error.h"

namespace motiondb::core {
namespace {

constexpr double kMostRatio = 100;
constexpr double kSameRate_hz = 1e-6;
constexpr float kMissing = std::numeric_limits<float>::quiet_NaN();

}  // namespace

absl::StatusOr<MarkerStream> MarkerStream::Create(const MarkerScheme& scheme,
                                                  const std::vector<std::string>& marker_names,
                                                  double from_hz, double to_hz) {
  if (!(from_hz >= to_hz / kMostRatio && from_hz <= to_hz * kMostRatio)) {
    return InvalidArgument("frame_rate_hz: expected {} to {} beside a model of {} Hz, got {}",
                           to_hz / kMostRatio, to_hz * kMostRatio, to_hz, from_hz);
  }
  MarkerStream stream;
  MOTIONDB_ASSIGN_OR_RETURN(stream.mapping_, BindMapping(scheme, marker_names));
  if (stream.mapping_.has_offsets) {
    return InvalidArgument("mapping '{}' has offsets in link frames, which bare markers lack",
                           stream.mapping_.name);
  }
  stream.step_ = std::abs(from_hz - to_hz) < kSameRate_hz ? 1 : from_hz / to_hz;
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
    // A marker is there or not, whole.
    if (marker.hasNaN()) marker.setConstant(kMissing);
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
  if (u < 1e-6F) {  // a frame that came, though its neighbours may be missing
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
