#include "core/kinematics/inverse_kinematics.h"

#include <algorithm>
#include <cmath>

#include "core/kinematics/pose_tracker.h"
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
  if (sum == 0) return InvalidArgument("marker_weights: expected one above 0, found none");
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
    return InvalidArgument("inverse kinematics: a marker position is infinite");
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
      return absl::CancelledError(fmt::format("inverse kinematics stopped at frame {}", frame));
    }
    const bool had_begun = tracker.has_begun();
    solved.errors.push_back(tracker.Follow(markers.positions_m.row(frame)));
    solved.motion.angles.row(frame) = tracker.pose().angles;
    if (!had_begun && tracker.has_begun()) {
      solved.motion.angles.topRows(frame).rowwise() = tracker.pose().angles;
    }
  }
  if (!tracker.has_begun()) {
    return InvalidArgument("inverse kinematics: no frame has a marker that counts");
  }
  return solved;
}

}  // namespace motiondb::core
