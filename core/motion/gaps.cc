#include <cmath>

#include "core/motion/error.h"
#include "core/motion/states.h"

namespace motiondb::core {

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
            "marker '{}' is missing from frame {} to {}: {:.2f} s, gaps up to {:.2f} s are filled",
            motion.names[m], begin + 1, t, static_cast<double>(t - begin) / motion.frame_rate_hz,
            max_gap_seconds);
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
