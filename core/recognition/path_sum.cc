#include "core/recognition/path_sum.h"

#include <cmath>
#include <limits>

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
constexpr float kLeastLogRoot = -80;  // near the end of what a float holds
constexpr double kExact = 250;        // of 4 * 80: what roots blur is e^-70 of the sum

// Of each frame, from the sums over the paths that end in each, behind two places.
auto Arrivals(const Eigen::ArrayXd& ending, Eigen::Index count) {
  return kStay * ending.tail(count) + kNext * ending.segment(kReach - 1, count) +
         kSkip * ending.head(count);
}

}  // namespace

void PathSum::Begin(Eigen::Index count, bool anchored) {
  count_ = count;
  begun_ = false;
  log_sum_ = 0;
  ending_.setZero(kReach + count);
  next_.setZero(kReach + count);
  arrival_.setOnes(count);
  if (anchored) {
    arrival_ =
        Eigen::ArrayXd::LinSpaced(count, 0, -kLateStart * static_cast<double>(count - 1)).exp();
  }
}

void PathSum::See(const Eigen::Ref<const Eigen::ArrayXf>& squared_distances) {
  if (begun_) arrival_ = Arrivals(ending_, count_);
  begun_ = true;
  // Densities relative to that of the nearest frame which can be arrived at: one is left.
  const double reached = (arrival_ > kAlive).select(squared_distances, kUnreached).minCoeff();
  ending_.tail(count_) =
      (arrival_ > kAlive)
          .select(arrival_ * ((reached - squared_distances.cast<double>()) / (2 * kTemper)).exp(),
                  0.0);
  const double peak = ending_.maxCoeff();
  ending_ /= peak;
  log_sum_ += std::log(peak) - reached / (2 * kTemper);
}

void PathSum::SeeRoots(const Eigen::Ref<const Eigen::ArrayXf>& roots, float nearest) {
  // The sum falls from frame to frame; as long as IsExact, it is far from what a double cannot
  // hold.
  const auto densities = roots.cast<double>().square().square();
  if (begun_) {
    next_.tail(count_) = Arrivals(ending_, count_) * densities;
  } else {
    next_.tail(count_) = arrival_ * densities;
  }
  begun_ = true;
  ending_.swap(next_);
  log_sum_ -= nearest / (2 * kTemper);
}

void PathSum::Roots(const Eigen::Ref<const Eigen::ArrayXf>& squared_distances, float nearest,
                    Eigen::Ref<Eigen::ArrayXf> roots) {
  constexpr auto kScale = static_cast<float>(1 / (4 * 2 * kTemper));
  roots = ((nearest - squared_distances) * kScale).max(kLeastLogRoot).exp();
}

bool PathSum::IsExact() const { return std::log(ending_.sum()) > -kExact; }

double PathSum::LogEvidence() const { return log_sum_ + std::log(ending_.sum()); }

double PathSum::LogEvidenceAtMost(Eigen::Index count, double nearest_sum) {
  return std::log(static_cast<double>(count)) - nearest_sum / (2 * kTemper);
}

}  // namespace motiondb::core
