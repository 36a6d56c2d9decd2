#include "core/planning/time_stretch.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "core/motion/forward_kinematics.h"

namespace motiondb::core {
namespace {

// The three axes of a joint with free rotation, and their first column.
struct FreeRotation {
  std::array<Eigen::Vector3d, 3> axes;
  int column;

  FreeRotation(const Skeleton& skeleton, int joint) {
    const std::vector<Dof>& dofs = skeleton.joints()[joint].dofs;
    const int first = static_cast<int>(dofs.size()) - 3;
    column = skeleton.first_dof(joint) + first;
    for (int i = 0; i < 3; ++i) axes[i] = dofs[first + i].axis;
  }

  Eigen::Quaterniond At(const Eigen::Ref<const Eigen::RowVectorXd>& pose) const {
    Eigen::Quaterniond turn = Eigen::Quaterniond::Identity();
    for (int i = 0; i < 3; ++i) turn = turn * Eigen::AngleAxisd(pose[column + i], axes[i]);
    return turn;
  }
};

Eigen::Quaterniond FromRotationVector(const Eigen::Vector3d& turn) {
  const double angle = turn.norm();
  if (angle == 0) return Eigen::Quaterniond::Identity();
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle, turn / angle));
}

template <typename Visit>
void ForEachFreeRotation(const MarkerKinematics& kinematics, Visit visit) {
  for (int j = 0; j < kinematics.skeleton()->joint_count(); ++j) {
    if (kinematics.TurnsFreely(j)) visit(FreeRotation(*kinematics.skeleton(), j));
  }
}

}  // namespace

JointMatrix PoseSteps(const MarkerKinematics& kinematics, const JointMatrix& poses) {
  const Eigen::Index steps = poses.rows() - 1;
  JointMatrix differences = poses.bottomRows(steps) - poses.topRows(steps);
  ForEachFreeRotation(kinematics, [&](const FreeRotation& rotation) {
    Eigen::Quaterniond before = rotation.At(poses.row(0));
    for (Eigen::Index t = 0; t < steps; ++t) {
      const Eigen::Quaterniond after = rotation.At(poses.row(t + 1));
      const Eigen::AngleAxisd turn(before.conjugate() * after);  // at most half a turn
      differences.row(t).segment<3>(rotation.column) = turn.angle() * turn.axis().transpose();
      before = after;
    }
  });
  return differences;
}

JointPath::JointPath(const MarkerKinematics& kinematics, JointMatrix poses)
    : kinematics_(kinematics), poses_(std::move(poses)), steps_(PoseSteps(kinematics, poses_)) {}

Eigen::RowVectorXd JointPath::At(double place, const Eigen::RowVectorXd& previous) const {
  const Eigen::Index last = steps_.rows() - 1;
  const Eigen::Index i = std::clamp<Eigen::Index>(static_cast<Eigen::Index>(place), 0, last);
  const double f = place - static_cast<double>(i);
  // Cumulative form of the spline: a start pose and shares of three steps. The path continues
  // straight beyond its ends.
  const double shares[] = {(-1 + 3 * f - 3 * f * f + f * f * f) / 6,
                           (1 + 3 * f + 3 * f * f - 2 * f * f * f) / 6, f * f * f / 6};
  const Eigen::Index rows[] = {std::max<Eigen::Index>(i - 1, 0), i, std::min(i + 1, last)};
  Eigen::RowVectorXd pose = poses_.row(i);
  for (int k = 0; k < 3; ++k) pose += shares[k] * steps_.row(rows[k]);
  // The pose is between the control points; rounding must not exceed their limits.
  const auto hull = poses_.middleRows(rows[0], std::min(i + 2, last + 1) - rows[0] + 1);
  pose = pose.cwiseMax(hull.colwise().minCoeff()).cwiseMin(hull.colwise().maxCoeff());
  ForEachFreeRotation(kinematics_, [&](const FreeRotation& rotation) {
    const auto step = [&](int k) {
      return FromRotationVector(shares[k] *
                                steps_.row(rows[k]).segment<3>(rotation.column).transpose());
    };
    const Eigen::Quaterniond turn = rotation.At(poses_.row(i)) * step(0) * step(1) * step(2);
    const Eigen::Vector3d before = previous.segment<3>(rotation.column).transpose();
    pose.segment<3>(rotation.column) =
        AnglesAboutAxes(turn.toRotationMatrix(), rotation.axes, before).transpose();
  });
  return pose;
}

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
