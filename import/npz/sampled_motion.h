// Joint motion from the sampled poses of a file: transforms of the joints in each frame, instead of
// angles about known axes.
#pragma once

#include <Eigen/Geometry>
#include <functional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/motion/motion.h"

namespace motiondb::importer {

struct SampledJoint {
  std::string name;
  int parent = -1;                                     // precedes the joint; -1 for a root
  Eigen::Vector3d offset_m = Eigen::Vector3d::Zero();  // rest position in the parent's frame
  // Rest orientation in the parent's frame: at zero angles the joint has this orientation.
  Eigen::Matrix3d rest_rotation = Eigen::Matrix3d::Identity();
};

// Returns parent_from_joint (world_from_joint of a root) of a joint in a frame, m.
using SampledPose = std::function<Eigen::Isometry3d(int joint, Eigen::Index frame)>;

// Returns the motion on a skeleton of these joints. Each joint has three rotations about the axes
// of its rest frame, in the order (xyz, yzx or zxy) that stays furthest from gimbal lock in the
// clip; angles are continuous over frames. Roots, and joints whose position changes by more than a
// nanometre, have three translations too; any other joint has its position of the first frame as
// offset. Joint positions and rotations are preserved to rounding. Calls `pose` twice for each
// joint and frame. INVALID_ARGUMENT as Skeleton::Create. REQUIRES: frames > 0; the poses are finite
// and their linear parts are rotations.
absl::StatusOr<core::JointMotion> MotionOfSamples(std::string name,
                                                  const std::vector<SampledJoint>& joints,
                                                  Eigen::Index frames, double frame_rate_hz,
                                                  const SampledPose& pose);

}  // namespace motiondb::importer
