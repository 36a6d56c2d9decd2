// Inverse kinematics: marker positions to joint angles on a skeleton, within joint limits. For
// streams, see PoseTracker.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "absl/status/statusor.h"
#include "core/kinematics/marker_kinematics.h"
#include "core/kinematics/pose_solver.h"
#include "core/motion/execution.h"
#include "core/motion/motion.h"

namespace motiondb::core {

struct IkMotion {
  JointMotion motion;           // at the markers' frame rate
  std::vector<IkError> errors;  // of each frame
};

// Solves all frames of a motion with PoseTracker. `markers`: the kinematics' markers, in its order.
// Frames before the first marker get the first pose. INVALID_ARGUMENT if the markers differ or are
// infinite, no frame has a marker with a weight, or an option is out of range; CANCELLED.
absl::StatusOr<IkMotion> SolveInverseKinematics(const MarkerKinematics& kinematics,
                                                const MarkerMotion& markers,
                                                const IkOptions& options = {},
                                                const Cancelled& cancelled = {});

// Tracks a pose from frame to frame. The MarkerKinematics must outlive the tracker.
class PoseTracker {
 public:
  // REQUIRES: options.marker_weights is empty or has one for each marker, not all of them 0.
  PoseTracker(const MarkerKinematics& kinematics, const IkOptions& options);

  // The pose of the last frame: placed, finite, within limits if they are respected.
  const MarkerPose& pose() const { return solver_.pose(); }
  bool has_begun() const { return has_begun_; }

  // Fits the pose to the markers of the next frame (1 x 3 * marker_count, m, world; NaN: missing)
  // by least squares. The first frame with a marker uses a global search; later frames start from
  // the previous pose and search only if the fit is clearly worse. Coordinates that no marker
  // determines keep their values; unreachable targets yield the nearest pose. Angles are continuous
  // over frames. Allocates memory only in searches. Returns the error of the fit.
  IkError Follow(const Eigen::Ref<const Eigen::RowVectorXf>& markers_m);

 private:
  // Solves from the last pose.
  void FollowFromLastPose();

  PoseSolver solver_;
  PoseSearch search_;
  double smoothness_;
  bool has_begun_ = false;
  IkError last_error_;  // error of the last frame with a marker
  Eigen::RowVectorXd last_angles_;
};

}  // namespace motiondb::core
