// Inverse kinematics: marker positions -> joint angles on a skeleton, within its joints' limits.
// The function keeps no state and is safe to call from any thread. For frames as they come, see
// PoseTracker.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "absl/status/statusor.h"
#include "core/kinematics/marker_kinematics.h"
#include "core/kinematics/pose_solver.h"
#include "core/motion/cancellation.h"
#include "core/motion/motion.h"

namespace motiondb::core {

struct IkMotion {
  JointMotion motion;           // at the markers' frame rate
  std::vector<IkError> errors;  // of each frame
};

// All frames of a motion on the kinematics' markers, in its order, each as PoseTracker follows
// them; frames before the first marker have the first pose. INVALID_ARGUMENT if the markers are
// others or infinite, no frame has one that counts, or an option is out of range; CANCELLED if
// `cancelled` says so.
absl::StatusOr<IkMotion> SolveInverseKinematics(const MarkerKinematics& kinematics,
                                                const MarkerMotion& markers,
                                                const IkOptions& options = {},
                                                const Cancelled& cancelled = {});

// Poses that follow markers from frame to frame.
// Thread-compatible: one tracker a thread. It borrows the MarkerKinematics, which must outlive it.
class PoseTracker {
 public:
  // REQUIRES: options.marker_weights is empty or has one for each marker, not all of them zero.
  PoseTracker(const MarkerKinematics& kinematics, const IkOptions& options);

  // The pose of the last frame: placed, finite, within limits if they are respected.
  const MarkerPose& pose() const { return solver_.pose(); }
  bool has_begun() const { return has_begun_; }

  // Moves the pose to the markers of the next frame (1 x 3 * marker_count, m, world; NaN where one
  // is missing), in the sense of least squares. The first frame with a marker is searched for
  // without a pose before; each other starts from the one before it, and is searched for only if
  // that leaves it clearly worse off. What no marker tells stays as it was; targets out of reach
  // give the nearest pose. Angles run on: no whole turn lies between two frames. Takes no memory
  // but to search.
  IkError Follow(const Eigen::Ref<const Eigen::RowVectorXf>& markers_m);

 private:
  // From the last pose to the solver's targets.
  void FollowOn();

  PoseSolver solver_;
  PoseSearch search_;
  double smoothness_;
  bool has_begun_ = false;
  IkError last_error_;  // of the last frame with a marker
  Eigen::RowVectorXd last_angles_;
};

}  // namespace motiondb::core
