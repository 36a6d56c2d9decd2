#include "core/inference/clip_alignment.h"

#include <algorithm>
#include <cmath>

namespace motiondb::core {
namespace {

constexpr float kTemper = 3;  // a stored frame stands for more than itself: variances are tripled
constexpr float kLateStart = 2;
constexpr Eigen::Index kReach = 2;  // the furthest step
const float kStay = std::log(0.2F);
const float kNext = std::log(0.6F);
const float kSkip = std::log(0.2F);
constexpr float kNever = -1e30F;    // adds up without overflow
constexpr Eigen::Index kRows = 64;  // observed frames whose distances are computed at a time

// Squared distances of observed to stored rows.
FrameMatrix SquaredDistances(const FrameMatrix& observed, const MetricFrames& stored, int clip) {
  const int begin = stored.rows.begin[clip];
  const int count = stored.rows.count(clip);
  FrameMatrix squared = -2 * observed * stored.projected.middleRows(begin, count).transpose();
  squared.colwise() += observed.rowwise().squaredNorm();
  squared.rowwise() += stored.squared_norms.segment(begin, count).transpose();
  return squared.cwiseMax(0);
}

}  // namespace

ClipAlignment AlignToClip(const MetricFrames& stored, int clip, const FrameMatrix& observed,
                          bool anchored) {
  const Eigen::Index count = stored.rows.count(clip);
  // Log of the sum over paths that end in each frame, behind two places where none does.
  Eigen::ArrayXf ending = Eigen::ArrayXf::Constant(kReach + count, kNever);
  Eigen::ArrayXf peak(count);
  Eigen::ArrayXf arrival(count);
  ClipAlignment alignment;
  for (Eigen::Index begin = 0; begin < observed.rows(); begin += kRows) {
    const FrameMatrix squared = SquaredDistances(
        observed.middleRows(begin, std::min(kRows, observed.rows() - begin)), stored, clip);
    for (Eigen::Index t = 0; t < squared.rows(); ++t) {
      Eigen::Index nearest = 0;
      const float distance = squared.row(t).minCoeff(&nearest);
      alignment.nearest.push_back({distance, stored.rows.frame[stored.rows.begin[clip] + nearest]});
      if (begin + t > 0) {
        const auto stay = ending.tail(count) + kStay;
        const auto next = ending.segment(kReach - 1, count) + kNext;
        const auto skip = ending.head(count) + kSkip;
        // Of the three terms of the sum, the greatest is taken out and counts for 1.
        peak = stay.max(next).max(skip);
        const auto middle = stay.min(next).max(stay.max(next).min(skip));
        const auto least = stay.min(next).min(skip);
        arrival = peak + (1 + (middle - peak).exp() + (least - peak).exp()).log();
      } else if (anchored) {
        arrival = Eigen::ArrayXf::LinSpaced(count, 0, -kLateStart * static_cast<float>(count - 1));
      } else {
        arrival.setZero();
      }
      ending.tail(count) = arrival - squared.row(t).transpose().array() / (2 * kTemper);
    }
  }
  const float best = ending.maxCoeff();
  alignment.log_evidence = best + std::log((ending - best).exp().sum());
  return alignment;
}

}  // namespace motiondb::core
