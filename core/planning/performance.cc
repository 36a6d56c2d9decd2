#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/kinematics/inverse_kinematics.h"
#include "core/kinematics/marker_kinematics.h"
#include "core/model/model.h"
#include "core/motion/error.h"
#include "core/planning/root_correction.h"
#include "core/planning/synthesis.h"

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

// Returns the contacts at another frame rate, by nearest frame.
ContactMatrix Resampled(const ContactMatrix& contacts, double from_hz, double to_hz,
                        Eigen::Index frames) {
  ContactMatrix resampled(frames, contacts.cols());
  for (Eigen::Index t = 0; t < frames; ++t) {
    const auto nearest =
        static_cast<Eigen::Index>(std::llround(static_cast<double>(t) * from_hz / to_hz));
    resampled.row(t) = contacts.row(std::min(nearest, contacts.rows() - 1));
  }
  return resampled;
}

// If the end is between two frames, appends it as a last frame, because it was requested.
void HoldEnd(const MarkerMotion& from, MarkerMotion& resampled) {
  const Eigen::Index last = resampled.positions_m.rows() - 1;
  const double cut = static_cast<double>(from.positions_m.rows() - 1) / from.frame_rate_hz -
                     static_cast<double>(last) / resampled.frame_rate_hz;
  if (cut * from.frame_rate_hz < 0.5) return;
  resampled.positions_m.conservativeResize(last + 2, Eigen::NoChange);
  resampled.positions_m.row(last + 1) = from.positions_m.row(from.positions_m.rows() - 1);
}

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
  planned.quality.joint_limit_violations = CountLimitViolations(solved.motion, kLimitTolerance);
  MOTIONDB_ASSIGN_OR_RETURN(planned.markers,
                            ApplyScheme(scheme, solved.motion, body.leg_length_m()));
  planned.joints = std::move(solved.motion);
  return absl::OkStatus();
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
  const auto add = [&](std::string what) {
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
  planned.outcome = missing.empty() ? PlanOutcome::kExact : PlanOutcome::kApproximate;
}

}  // namespace

absl::Status RetargetToBody(const MarkerScheme& scheme, const Body& body,
                            const PlanProblem& problem, SynthesisedMotion motion,
                            const Cancelled& cancelled, PlannedMotion& planned) {
  const double model_rate = motion.markers.frame_rate_hz;
  const double rate = problem.frame_rate_hz > 0 ? problem.frame_rate_hz : model_rate;
  MOTIONDB_ASSIGN_OR_RETURN(planned.markers, Resample(motion.markers, rate));
  HoldEnd(motion.markers, planned.markers);
  if (body.kinematics()) {
    MOTIONDB_RETURN_IF_ERROR(SolveJoints(scheme, body, problem, cancelled, planned));
  }
  MOTIONDB_ASSIGN_OR_RETURN(planned.root, ReferenceFrames(scheme.set, planned.markers));
  MeasurePath(problem, planned);
  planned.quality.motion = MeasureQuality(
      body.feet(), planned.markers,
      Resampled(motion.contacts, model_rate, rate, planned.markers.positions_m.rows()),
      body.leg_length_m(), planned.joints ? &*planned.joints : nullptr);
  Judge(problem, planned);
  return absl::OkStatus();
}

}  // namespace motiondb::core
