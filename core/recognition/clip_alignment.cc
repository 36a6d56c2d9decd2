#include "core/recognition/clip_alignment.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/model/squared_distances.h"

namespace motiondb::core {
namespace {

constexpr double kTemper = 3;  // a stored frame stands for more than itself: variances are tripled
constexpr double kLateStart = 2;
constexpr Eigen::Index kReach = 2;  // the furthest step
constexpr double kStay = 0.2;
constexpr double kNext = 0.6;
constexpr double kSkip = 0.2;
constexpr double kAlive = 1e-290;  // of the most probable frame: what is less is let go
constexpr float kUnreached = std::numeric_limits<float>::max();
constexpr Eigen::Index kRows = 64;  // observed frames whose distances are computed at a time

}  // namespace

ClipAlignment AlignToClip(const MetricFrames& stored, int clip, const FrameMatrix& observed,
                          bool anchored) {
  const Eigen::Index first = stored.rows.begin[clip];
  const Eigen::Index count = stored.rows.count(clip);
  // Sums over the paths that end in each frame, the greatest being 1, behind two places where none
  // does. Doubles reach so far below it that a path which catches up late is not lost.
  Eigen::ArrayXd ending = Eigen::ArrayXd::Zero(kReach + count);
  Eigen::ArrayXd arrival = Eigen::ArrayXd::Ones(count);
  if (anchored) {
    arrival =
        Eigen::ArrayXd::LinSpaced(count, 0, -kLateStart * static_cast<double>(count - 1)).exp();
  }
  ClipAlignment alignment;
  for (Eigen::Index begin = 0; begin < observed.rows(); begin += kRows) {
    const FrameMatrix squared = SquaredDistances(
        observed.middleRows(begin, std::min(kRows, observed.rows() - begin)),
        stored.projected.middleRows(first, count), stored.squared_norms.segment(first, count));
    for (Eigen::Index t = 0; t < squared.rows(); ++t) {
      const auto distances = squared.row(t).transpose().array();
      Eigen::Index nearest = 0;
      const float distance = distances.minCoeff(&nearest);
      alignment.nearest.push_back({distance, stored.rows.frame[first + nearest]});
      if (begin + t > 0) {
        arrival = kStay * ending.tail(count) + kNext * ending.segment(kReach - 1, count) +
                  kSkip * ending.head(count);
      }
      // Densities relative to that of the nearest frame which can be arrived at: one is left.
      const double reached = (arrival > kAlive).select(distances, kUnreached).minCoeff();
      ending.tail(count) =
          (arrival > kAlive)
              .select(arrival * ((reached - distances.cast<double>()) / (2 * kTemper)).exp(), 0.0);
      const double peak = ending.maxCoeff();
      ending /= peak;
      alignment.log_evidence += std::log(peak) - reached / (2 * kTemper);
    }
  }
  alignment.log_evidence += std::log(ending.sum());
  return alignment;
}

}  // namespace motiondb::core
