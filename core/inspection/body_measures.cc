#include "core/inspection/body_measures.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/motion/quantile.h"

namespace motiondb::core {
namespace {

using Position = Eigen::Vector3d;

class Positions {
 public:
  explicit Positions(const MarkerMotion& motion) : motion_(motion) {}

  Position At(Eigen::Index frame, std::string_view marker) const {
    const auto found = std::ranges::find(motion_.names, marker) - motion_.names.begin();
    return motion_.positions_m.row(frame).segment<3>(3 * found).transpose().cast<double>();
  }

  // Median distance of two markers.
  std::optional<double> Distance(std::string_view a, std::string_view b) const {
    std::vector<double> distances;
    for (Eigen::Index t = 0; t < motion_.positions_m.rows(); ++t) {
      const double distance = (At(t, a) - At(t, b)).norm();
      if (std::isfinite(distance)) distances.push_back(distance);
    }
    if (distances.empty()) return std::nullopt;
    return Quantile(distances, 0.5);
  }

 private:
  const MarkerMotion& motion_;
};

// Adds the horizontal speeds of a marker in the frames in which it is near the floor.
void AddSpeedsOnFloor(const MarkerMotion& motion, std::string_view marker, double leg_length_m,
                      std::vector<double>& speeds) {
  constexpr double kNear = 0.02;       // above its lowest height, in leg lengths
  constexpr double kLowest = 0.05;     // fraction of frames
  constexpr double kMinSeconds = 0.1;  // on the floor
  const Positions positions(motion);
  const auto frames = static_cast<int>(motion.positions_m.rows());
  std::vector<double> heights;
  for (int t = 0; t < frames; ++t) {
    const double height = positions.At(t, marker).z();
    if (std::isfinite(height)) heights.push_back(height);
  }
  if (heights.empty()) return;
  const double limit = Quantile(heights, kLowest) + kNear * leg_length_m;
  const auto is_low = [&](int t) { return positions.At(t, marker).z() <= limit; };
  const int min_frames = std::max(2, static_cast<int>(kMinSeconds * motion.frame_rate_hz));
  for (int first = 0; first < frames;) {
    int end = first;
    while (end < frames && is_low(end)) ++end;
    for (int t = first + 1; end - first >= min_frames && t < end; ++t) {
      const Position step = positions.At(t, marker) - positions.At(t - 1, marker);
      speeds.push_back(step.head<2>().norm() * motion.frame_rate_hz);
    }
    first = end + 1;
  }
}

}  // namespace

std::optional<double> Stature(const MarkerMotion& motion, double leg_length_m) {
  constexpr double kAnkleHeight = 0.039;  // of the stature: Winter, after Drillis and Contini
  const Positions positions(motion);
  double length = leg_length_m;
  constexpr const char* kLine[] = {"Pelvis", "Waist", "Spine", "Neck", "Head", "HeadTop"};
  for (std::size_t i = 1; i < std::size(kLine); ++i) {
    const auto segment = positions.Distance(kLine[i - 1], kLine[i]);
    if (!segment) return std::nullopt;
    length += *segment;
  }
  return length / (1 - kAnkleHeight);
}

std::optional<double> FootSlide(const MarkerMotion& motion, double leg_length_m) {
  std::vector<double> speeds;
  for (const char* const marker : {"LHeel", "RHeel", "LToe", "RToe"}) {
    AddSpeedsOnFloor(motion, marker, leg_length_m, speeds);
  }
  if (speeds.empty()) return std::nullopt;
  return Quantile(speeds, 0.5);
}

}  // namespace motiondb::core
