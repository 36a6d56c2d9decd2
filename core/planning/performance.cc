#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/kinematics/inverse_kinematics.h"
#include "core/kinematics/marker_kinematics.h"
#include "core/model/model.h"
#include "core/motion/error.h"
#include "core/planning/goal.h"
#include "core/planning/synthesis.h"
#include "core/planning/time_stretch.h"

namespace motiondb::core {
namespace {

// Weights of inverse kinematics: feet and hips determine balance and arrival, especially on a body
// of other proportions.
constexpr double kFootWeight = 20;
constexpr double kHipWeight = 10;
// Skeletons of people have joints, such as the spine, that markers barely determine.
constexpr double kPeopleSmoothness = 1e-3;
constexpr double kLimitTolerance = 1e-9;  // rad or m, rounding

std::vector<double> MarkerWeights(const MarkerSet& set, const Feet& feet) {
  std::vector<double> weights(static_cast<std::size_t>(set.marker_count()), 1.0);
  for (const Foot& foot : feet) {
    for (const int marker : foot.foot_markers) weights[marker] = kFootWeight;
  }
  weights[set.landmarks.left_hip] = kHipWeight;
  weights[set.landmarks.right_hip] = kHipWeight;
  return weights;
}

// Returns the contacts at places between frames of `contacts`: a marker is in contact between two
// frames if it is in both.
ContactMatrix ContactsAt(const ContactMatrix& contacts, const std::vector<double>& places) {
  constexpr double kRounding = 1e-6;
  const auto last = static_cast<double>(contacts.rows() - 1);
  ContactMatrix between(static_cast<Eigen::Index>(places.size()), contacts.cols());
  for (Eigen::Index t = 0; t < between.rows(); ++t) {
    const double before = std::clamp(std::floor(places[t] + kRounding), 0.0, last);
    const double after = std::clamp(std::ceil(places[t] - kRounding), 0.0, last);
    between.row(t) = contacts.row(static_cast<Eigen::Index>(before)) &&
                     contacts.row(static_cast<Eigen::Index>(after));
  }
  return between;
}

// Resamples the markers of a motion. If its end is between two frames, appends it as a last frame,
// because it was requested. Returns the frame of `motion` of each planned frame.
absl::StatusOr<std::vector<double>> ResampleMarkers(const MarkerMotion& motion, double rate_hz,
                                                    PlannedMotion& planned) {
  MOTIONDB_ASSIGN_OR_RETURN(planned.markers, Resample(motion, rate_hz));
  FrameMatrix& positions_m = planned.markers.positions_m;
  const double step = motion.frame_rate_hz / rate_hz;
  const Eigen::Index last = positions_m.rows() - 1;
  const Eigen::Index end = motion.positions_m.rows() - 1;
  if (static_cast<double>(end) - static_cast<double>(last) * step >= 0.5) {
    positions_m.conservativeResize(last + 2, Eigen::NoChange);
    positions_m.row(last + 1) = motion.positions_m.row(end);
  }
  std::vector<double> frames;
  for (Eigen::Index t = 0; t < positions_m.rows(); ++t) {
    frames.push_back(std::min(static_cast<double>(t) * step, static_cast<double>(end)));
  }
  return frames;
}

// Solves the joint angles for planned.markers.
absl::Status SolveJoints(const MarkerScheme& scheme, const Body& body, const PlanProblem& problem,
                         const Cancelled& cancelled, PlannedMotion& planned) {
  const IkOptions options{
      .respect_limits = problem.respect_joint_limits,
      .marker_weights = MarkerWeights(scheme.set, body.feet()),
      .smoothness = problem.flat_soles ? IkOptions{}.smoothness : kPeopleSmoothness};
  MOTIONDB_ASSIGN_OR_RETURN(
      IkMotion solved,
      SolveInverseKinematics(*body.kinematics(), planned.markers, options, cancelled));
  double squared = 0;
  for (const IkError& error : solved.errors) squared += error.rms_m * error.rms_m;
  planned.quality.marker_fit_rms_m =
      std::sqrt(squared / static_cast<double>(std::max<std::size_t>(1, solved.errors.size())));
  planned.joints = std::move(solved.motion);
  return absl::OkStatus();
}

RateLimits LimitsFrom(const PlanProblem& problem, const RobotDynamics* dynamics,
                      const Skeleton& skeleton) {
  return LimitRates(skeleton, dynamics, problem.speed_limit_scale,
                    problem.max_joint_acceleration.value_or(0));
}

// Solves the joint angles, stretches their time for limits, and counts what is beyond limits.
// Returns the frame of `motion` of each planned frame.
absl::StatusOr<std::vector<double>> RetargetToSkeleton(const MarkerScheme& scheme, const Body& body,
                                                       const PlanProblem& problem,
                                                       const SynthesisedMotion& motion,
                                                       double rate_hz, const Cancelled& cancelled,
                                                       PlannedMotion& planned) {
  const double model_rate_hz = motion.markers.frame_rate_hz;
  const Skeleton& skeleton = *body.kinematics()->skeleton();
  const RobotDynamics* respected = problem.respect_joint_limits ? problem.dynamics.get() : nullptr;
  const RateLimits limits = LimitsFrom(problem, respected, skeleton);
  std::vector<double> frames;
  if (AnyLimit(limits)) {
    // Poses at a rate that divides the motion; the path through them is smooth, so a higher rate
    // than the model's has no use.
    const double last = static_cast<double>(motion.markers.positions_m.rows() - 1);
    const double intervals = std::ceil(last * std::min(1.0, rate_hz / model_rate_hz));
    const double pose_rate_hz = model_rate_hz * (intervals / last);
    MOTIONDB_ASSIGN_OR_RETURN(planned.markers, Resample(motion.markers, pose_rate_hz));
    MOTIONDB_RETURN_IF_ERROR(SolveJoints(scheme, body, problem, cancelled, planned));
    StretchedMotion stretched = StretchTime(*body.kinematics(), *planned.joints, limits, rate_hz,
                                            problem.max_duration_seconds);
    frames = std::move(stretched.places);
    for (double& frame : frames) frame *= model_rate_hz / pose_rate_hz;
    planned.joints = std::move(stretched.motion);
    planned.slowed = std::move(stretched.slowed);
    planned.cut = stretched.cut;
    planned.quality.needed_seconds = stretched.needed_seconds;
  } else {
    MOTIONDB_ASSIGN_OR_RETURN(frames, ResampleMarkers(motion.markers, rate_hz, planned));
    MOTIONDB_RETURN_IF_ERROR(SolveJoints(scheme, body, problem, cancelled, planned));
  }
  MOTIONDB_ASSIGN_OR_RETURN(planned.markers,
                            ApplyScheme(scheme, *planned.joints, body.leg_length_m()));
  planned.quality.joint_limit_violations = CountLimitViolations(*planned.joints, kLimitTolerance);
  planned.quality.rate_violations = CountRateViolations(
      *body.kinematics(), *planned.joints, LimitsFrom(problem, problem.dynamics.get(), skeleton));
  return frames;
}

void MeasurePath(const PlanProblem& problem, PlannedMotion& planned) {
  PlanQuality& quality = planned.quality;
  const RootPath& root = planned.root;
  const Eigen::Index last = root.rows() - 1;
  const GoalError error = ErrorAt({root(last, 0), root(last, 1), root(last, 2)}, problem.goal);
  quality.position_error_m = error.position_m;
  quality.heading_error_rad = error.heading_rad;
  quality.duration_seconds = static_cast<double>(last) / planned.markers.frame_rate_hz;
  double clearance = std::numeric_limits<double>::infinity();
  for (Eigen::Index t = 0; t <= last; ++t) {
    const Eigen::Vector2d position = root.row(t).head<2>();
    if (t > 0) quality.length_m += (position - root.row(t - 1).head<2>().transpose()).norm();
    if (!problem.obstacles.empty()) {
      clearance = std::min(clearance, Distance(problem.obstacles, position));
    }
  }
  if (!problem.obstacles.empty()) quality.smallest_clearance_m = clearance;
}

void Judge(const PlanProblem& problem, PlannedMotion& planned) {
  const PlanQuality& quality = planned.quality;
  std::string& missing = planned.missing;
  const auto add = [&](const std::string& what) {
    if (!missing.empty()) missing += "; ";
    missing += what;
  };
  if (quality.position_error_m > problem.position_tolerance_m) {
    add(fmt::format("ends {:.3g} m from the goal, expected at most {:.3g}",
                    quality.position_error_m, problem.position_tolerance_m));
  }
  if (quality.heading_error_rad > problem.heading_tolerance_rad) {
    add(fmt::format("heading differs by {:.3g} rad from the goal's, expected at most {:.3g}",
                    quality.heading_error_rad, problem.heading_tolerance_rad));
  }
  if (quality.smallest_clearance_m &&
      *quality.smallest_clearance_m < problem.obstacles.clearance_m) {
    add(fmt::format("passes an obstacle at {:.3g} m, expected at least {:.3g}",
                    *quality.smallest_clearance_m, problem.obstacles.clearance_m));
  }
  if (planned.cut) {
    add(fmt::format("needs {:.3g} s within the joint limits, expected at most {:.3g}",
                    quality.needed_seconds, problem.max_duration_seconds));
  }
  planned.outcome = missing.empty() ? PlanOutcome::kExact : PlanOutcome::kApproximate;
}

}  // namespace

absl::Status RetargetToBody(const MarkerScheme& scheme, const Body& body,
                            const PlanProblem& problem, const SynthesisedMotion& motion,
                            const Cancelled& cancelled, PlannedMotion& planned) {
  const double model_rate_hz = motion.markers.frame_rate_hz;
  const double rate_hz = problem.frame_rate_hz.value_or(model_rate_hz);
  planned.quality.recorded_seconds =
      static_cast<double>(motion.markers.positions_m.rows() - 1) / model_rate_hz;
  std::vector<double> frames;
  if (body.kinematics()) {
    MOTIONDB_ASSIGN_OR_RETURN(
        frames, RetargetToSkeleton(scheme, body, problem, motion, rate_hz, cancelled, planned));
  } else {
    MOTIONDB_ASSIGN_OR_RETURN(frames, ResampleMarkers(motion.markers, rate_hz, planned));
  }
  MOTIONDB_ASSIGN_OR_RETURN(planned.root, ReferenceFrames(scheme.set, planned.markers));
  MeasurePath(problem, planned);
  planned.contacts = ContactsAt(motion.contacts, frames);
  planned.quality.motion =
      MeasureQuality(body.feet(), planned.markers, planned.contacts, body.leg_length_m(),
                     planned.joints ? &*planned.joints : nullptr);
  Judge(problem, planned);
  return absl::OkStatus();
}

}  // namespace motiondb::core
