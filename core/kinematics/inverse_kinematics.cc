#include "core/kinematics/inverse_kinematics.h"

#include <algorithm>
#include <cmath>

#include "core/motion/error.h"

namespace motiondb::core {

namespace {

absl::Status CheckOptions(const MarkerKinematics& kinematics, const IkOptions& options) {
  const std::vector<double>& weights = options.marker_weights;
  if (!weights.empty() && weights.size() != kinematics.marker_names().size()) {
    return InvalidArgument("marker_weights: expected one for each of the {} markers, found {}",
                           kinematics.marker_count(), weights.size());
  }
  double sum = weights.empty() ? 1 : 0;
  for (std::size_t m = 0; m < weights.size(); ++m) {
    if (!(weights[m] >= 0 && std::isfinite(weights[m]))) {
      return InvalidArgument("marker_weights: expected 0 or more for marker '{}', found {}",
                             kinematics.marker_names()[m], weights[m]);
    }
    sum += weights[m];
  }
  if (sum == 0) return InvalidArgument("marker_weights: expected at least one above 0");
  if (!(options.smoothness >= 0 && std::isfinite(options.smoothness))) {
    return InvalidArgument("smoothness: expected 0 or more, found {}", options.smoothness);
  }
  return absl::OkStatus();
}

absl::Status CheckMarkers(const MarkerKinematics& kinematics, const MarkerMotion& markers) {
  if (markers.names != kinematics.marker_names()) {
    return InvalidArgument(
        "inverse kinematics: expected the {} markers of the scheme, in its order",
        kinematics.marker_count());
  }
  if (markers.positions_m.cols() != 3 * kinematics.marker_count()) {
    return InvalidArgument("inverse kinematics: expected {} columns, found {}",
                           3 * kinematics.marker_count(), markers.positions_m.cols());
  }
  if (markers.positions_m.array().isInf().any()) {
    return InvalidArgument("inverse kinematics: expected finite marker positions or NaN");
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<IkMotion> SolveInverseKinematics(const MarkerKinematics& kinematics,
                                                const MarkerMotion& markers,
                                                const IkOptions& options,
                                                const Cancelled& cancelled) {
  MOTIONDB_RETURN_IF_ERROR(CheckOptions(kinematics, options));
  MOTIONDB_RETURN_IF_ERROR(CheckMarkers(kinematics, markers));
  const Eigen::Index frames = markers.positions_m.rows();
  IkMotion solved{.motion = {.skeleton = kinematics.skeleton(),
                             .frame_rate_hz = markers.frame_rate_hz,
                             .angles = JointMatrix(frames, kinematics.dof_count())},
                  .errors = {}};
  PoseTracker tracker(kinematics, options);
  for (Eigen::Index frame = 0; frame < frames; ++frame) {
    if (cancelled && cancelled()) {
      return absl::CancelledError(
          fmt::format("inverse kinematics was cancelled at frame {}", frame));
    }
    const bool had_begun = tracker.has_begun();
    solved.errors.push_back(tracker.Follow(markers.positions_m.row(frame)));
    solved.motion.angles.row(frame) = tracker.pose().angles;
    if (!had_begun && tracker.has_begun()) {
      solved.motion.angles.topRows(frame).rowwise() = tracker.pose().angles;
    }
  }
  if (!tracker.has_begun()) {
    return InvalidArgument("inverse kinematics: expected a frame with a marker of weight above 0");
  }
  return solved;
}

namespace {

constexpr int kFrameIterations = 30;
constexpr int kFirstAttempts = 12;
constexpr int kLaterAttempts = 6;
// At this error (m, rms) the pull is twice that of a perfect fit.
constexpr double kMisfit = 0.005;
// A pose found by search must have at most this fraction of the error to justify a jump.
constexpr double kWorthAJump = 0.5;

// The largest error exceeds twice the previous frame's by more than 5 mm.
bool ClearlyWorse(const IkError& error, const IkError& before) {
  return error.largest_m > 2 * before.largest_m + 0.005;
}

// Markers that cannot be fitted constrain the pose less, and several poses fit almost equally. A
// pull that grows with the squared error avoids jumps between these poses.
double Pull(double smoothness, const IkError& before) {
  const double misfit = before.rms_m / kMisfit;
  return smoothness * (1 + misfit * misfit);
}

}  // namespace

PoseTracker::PoseTracker(const MarkerKinematics& kinematics, const IkOptions& options)
    : solver_(kinematics, options), search_(kinematics), smoothness_(options.smoothness) {}

IkError PoseTracker::Follow(const Eigen::Ref<const Eigen::RowVectorXf>& markers_m) {
  solver_.Aim(markers_m);
  if (!solver_.has_targets()) return {};
  if (has_begun_) {
    FollowFromLastPose();
    solver_.UnwrapAngles(last_angles_);
  } else {
    search_.Run(kFirstAttempts, solver_);
    has_begun_ = true;
  }
  last_angles_ = pose().angles;
  last_error_ = solver_.Error();
  return last_error_;
}

void PoseTracker::FollowFromLastPose() {
  solver_.Descend(search_.whole(), kFrameIterations, Pull(smoothness_, last_error_));
  if (!ClearlyWorse(solver_.Error(), last_error_)) return;
  // The markers moved further than the pull allows.
  solver_.Descend(search_.whole(), kFrameIterations, 0);
  const IkError followed = solver_.Error();
  if (!ClearlyWorse(followed, last_error_)) return;
  // No descent leads there: search.
  const Eigen::RowVectorXd angles = pose().angles;
  search_.Run(kLaterAttempts, solver_);
  if (!(solver_.Error().rms_m < kWorthAJump * followed.rms_m)) solver_.Stand(angles);
}

}  // namespace motiondb::core
