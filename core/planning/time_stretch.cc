#include "core/planning/time_stretch.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/planning/joint_path.h"

namespace motiondb::core {
namespace {

// Share of the limits that the time law uses, and that samples may reach: they are sent in single
// precision.
constexpr double kUsed = 0.995;
constexpr double kReached = 0.998;
constexpr double kRounding = 1e-6;  // of a number of frames

// Largest ratios to the limits.
struct Excess {
  double speed = 0;
  double acceleration = 0;
};

// Calls both functions with the ratio to the limit of each first and second difference.
template <typename VisitSpeed, typename VisitAcceleration>
void CompareRates(const JointMatrix& steps, double rate_hz, const RateLimits& limits,
                  VisitSpeed visit_speed, VisitAcceleration visit_acceleration) {
  for (Eigen::Index c = 0; c < steps.cols(); ++c) {
    if (std::isinf(limits.speed[c]) && std::isinf(limits.acceleration[c])) continue;
    const double speed_unit = rate_hz / limits.speed[c];
    const double acceleration_unit = rate_hz * rate_hz / limits.acceleration[c];
    for (Eigen::Index t = 0; t < steps.rows(); ++t) {
      visit_speed(speed_unit * std::abs(steps(t, c)));
      if (t > 0) visit_acceleration(acceleration_unit * std::abs(steps(t, c) - steps(t - 1, c)));
    }
  }
}

Excess LargestExcess(const JointMatrix& steps, double rate_hz, const RateLimits& limits) {
  Excess excess;
  CompareRates(
      steps, rate_hz, limits, [&](double ratio) { excess.speed = std::max(excess.speed, ratio); },
      [&](double ratio) { excess.acceleration = std::max(excess.acceleration, ratio); });
  return excess;
}

// Factor of time that removes the excess: accelerations decrease with its square.
double NeededFactor(const Excess& excess) {
  return std::max(excess.speed, std::sqrt(excess.acceleration)) / kReached;
}

StretchedMotion Sample(const JointPath& path, const TimeLaw& law, const JointMotion& recorded,
                       double frame_rate_hz, double max_seconds) {
  StretchedMotion sampled{.motion = {recorded.skeleton, frame_rate_hz, {}}};
  sampled.needed_seconds = law.duration_seconds();
  const double needed = std::round(law.duration_seconds() * frame_rate_hz);
  const double most = std::ceil(max_seconds * frame_rate_hz - kRounding);
  sampled.cut = needed > most;
  const auto last = static_cast<Eigen::Index>(std::min(needed, most));
  sampled.motion.angles.resize(last + 1, recorded.angles.cols());
  Eigen::RowVectorXd pose = recorded.angles.row(0);
  for (Eigen::Index t = 0; t <= last; ++t) {
    sampled.places.push_back(law.PlaceAt(static_cast<double>(t) / frame_rate_hz));
    pose = path.At(sampled.places.back(), pose);
    sampled.motion.angles.row(t) = pose;
  }
  for (const SlowedPart& part : law.slowed()) {
    if (part.start_seconds * frame_rate_hz < static_cast<double>(last)) {
      sampled.slowed.push_back(part);
    }
  }
  return sampled;
}

}  // namespace

RateLimits LimitRates(const Skeleton& skeleton, const RobotDynamics* dynamics, double speed_scale,
                      double max_acceleration) {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  RateLimits limits;
  limits.speed = Eigen::RowVectorXd::Constant(skeleton.dof_count(), kNone);
  if (dynamics != nullptr) limits.speed = speed_scale * dynamics->max_speeds;
  limits.acceleration = Eigen::RowVectorXd::Constant(
      skeleton.dof_count(), max_acceleration > 0 ? max_acceleration : kNone);
  const auto root = static_cast<Eigen::Index>(skeleton.joints()[0].dofs.size());
  limits.speed.head(root).setConstant(kNone);
  limits.acceleration.head(root).setConstant(kNone);
  return limits;
}

bool AnyLimit(const RateLimits& limits) {
  return limits.speed.array().isFinite().any() || limits.acceleration.array().isFinite().any();
}

RateViolations CountRateViolations(const MarkerKinematics& kinematics, const JointMotion& motion,
                                   const RateLimits& limits) {
  RateViolations violations;
  CompareRates(
      PoseSteps(kinematics, motion.angles), motion.frame_rate_hz, limits,
      [&](double ratio) { violations.speeds += !(ratio <= 1); },
      [&](double ratio) { violations.accelerations += !(ratio <= 1); });
  return violations;
}

StretchedMotion StretchTime(const MarkerKinematics& kinematics, const JointMotion& recorded,
                            const RateLimits& limits, double frame_rate_hz, double max_seconds) {
  const JointPath path(kinematics, recorded.angles);
  TimeLaw law(path.steps(), recorded.frame_rate_hz,
              {kUsed * limits.speed, kUsed * limits.acceleration});
  const Excess recorded_excess = LargestExcess(path.steps(), recorded.frame_rate_hz, limits);
  if (law.as_recorded() && frame_rate_hz == recorded.frame_rate_hz &&
      NeededFactor(recorded_excess) <= 1) {
    StretchedMotion same{.motion = recorded};
    for (Eigen::Index t = 0; t < recorded.angles.rows(); ++t) {
      same.places.push_back(static_cast<double>(t));
    }
    same.needed_seconds = law.duration_seconds();
    return same;
  }
  // The law bounds coordinates with free rotation only approximately: check the samples.
  constexpr int kMaxChecks = 10;
  StretchedMotion sampled;
  for (int check = 0; check < kMaxChecks; ++check) {
    // The end is at a sample; a shorter last step would be a sudden stop.
    const double frames = law.duration_seconds() * frame_rate_hz;
    law.Slow(std::max(1.0, std::ceil(frames - kRounding)) / frames);
    sampled = Sample(path, law, recorded, frame_rate_hz, max_seconds);
    const double factor = NeededFactor(
        LargestExcess(PoseSteps(kinematics, sampled.motion.angles), frame_rate_hz, limits));
    if (factor <= 1) break;
    law.Slow(factor);
  }
  return sampled;
}

}  // namespace motiondb::core
