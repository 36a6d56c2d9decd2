#include <algorithm>
#include <cmath>

#include "core/motion/error.h"
#include "core/motion/frame_state.h"
#include "core/motion/states.h"

namespace motiondb::core {

absl::StatusOr<MarkerMotion> Resample(const MarkerMotion& motion, double frame_rate_hz) {
  if (!(frame_rate_hz > 0 && std::isfinite(frame_rate_hz) && motion.frame_rate_hz > 0 &&
        std::isfinite(motion.frame_rate_hz))) {
    return InvalidArgument("expected positive frame rates, got {} and {}", motion.frame_rate_hz,
                           frame_rate_hz);
  }
  const Eigen::Index frames = motion.positions_m.rows();
  if (frames < 2) return InvalidArgument("expected a motion of at least 2 frames, got {}", frames);
  if (std::abs(motion.frame_rate_hz - frame_rate_hz) < 1e-6) {
    MarkerMotion same = motion;
    same.frame_rate_hz = frame_rate_hz;
    return same;
  }
  const double step = motion.frame_rate_hz / frame_rate_hz;
  const double last = static_cast<double>(frames - 1);
  const double count = std::floor(last / step + 1e-6) + 1;
  if (count > 1e8) {
    return InvalidArgument("resampling from {} to {} Hz: expected at most 1e8 frames, got {}",
                           motion.frame_rate_hz, frame_rate_hz, count);
  }
  MarkerMotion resampled{motion.names, frame_rate_hz, {}};
  resampled.positions_m.resize(static_cast<Eigen::Index>(count), motion.positions_m.cols());
  const auto row = [&](Eigen::Index t) {
    return motion.positions_m.row(std::clamp<Eigen::Index>(t, 0, frames - 1));
  };
  for (Eigen::Index t = 0; t < resampled.positions_m.rows(); ++t) {
    const double at = std::min(static_cast<double>(t) * step, last);
    auto before = static_cast<Eigen::Index>(std::floor(at + 1e-9));
    const auto u = static_cast<float>(std::max(0.0, at - static_cast<double>(before)));
    if (u < 1e-6f) {  // exactly a source frame; its neighbours may be missing
      resampled.positions_m.row(t) = row(before);
      continue;
    }
    for (Eigen::Index c = 0; c < motion.positions_m.cols(); ++c) {
      resampled.positions_m(t, c) =
          CatmullRom(row(before - 1)[c], row(before)[c], row(before + 1)[c], row(before + 2)[c], u);
    }
  }
  return resampled;
}

absl::StatusOr<std::vector<std::string>> FillGaps(double max_gap_seconds, MarkerMotion& motion) {
  const Eigen::Index frames = motion.positions_m.rows();
  std::vector<std::string> notes;
  for (std::size_t m = 0; m < motion.names.size(); ++m) {
    auto marker = motion.positions_m.middleCols<3>(static_cast<Eigen::Index>(3 * m));
    const auto missing = [&](Eigen::Index t) { return marker.row(t).hasNaN(); };
    int filled = 0;
    for (Eigen::Index t = 0; t < frames; ++t) {
      if (!missing(t)) continue;
      const Eigen::Index begin = t;
      while (t < frames && missing(t)) ++t;
      if (begin == 0 && t == frames) {
        return InvalidArgument("marker '{}' is missing in all {} frames", motion.names[m], frames);
      }
      if (static_cast<double>(t - begin) > max_gap_seconds * motion.frame_rate_hz) {
        return InvalidArgument(
            "marker '{}' is missing from frame {} to {}: {:.2f} s, expected gaps up to {:.2f} s",
            motion.names[m], motion.first_frame + begin + 1, motion.first_frame + t,
            static_cast<double>(t - begin) / motion.frame_rate_hz, max_gap_seconds);
      }
      const Eigen::Index before = begin > 0 ? begin - 1 : t;
      const Eigen::Index after = t < frames ? t : begin - 1;
      for (Eigen::Index g = begin; g < t; ++g) {
        const float share =
            before == after ? 0
                            : static_cast<float>(g - before) / static_cast<float>(after - before);
        marker.row(g) = (1 - share) * marker.row(before) + share * marker.row(after);
      }
      filled += static_cast<int>(t - begin);
    }
    if (filled > 0) {
      notes.push_back(fmt::format("{} frames of '{}' filled", filled, motion.names[m]));
    }
  }
  return notes;
}

}  // namespace motiondb::core
