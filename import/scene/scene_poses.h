// Poses of a scene's joints as rotations and positions, without scales.
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <vector>

#include "import/scene/scene_skeleton.h"
#include "import/scene/scene_tracks.h"

namespace motiondb::importer {

// A joint's pose in the scene has the position of its node, and the orthonormal part of its
// transform: the rotation nearest to it, or, if it mirrors, to its negative. Where a scale is zero,
// the rotation is the parent's.
class ScenePoses {
 public:
  // The arguments must outlive this object. REQUIRES: a track for each joint.
  ScenePoses(const SceneSkeleton& skeleton, const std::vector<JointTrack>& tracks);

  // Evaluates the nodes' own transforms, without the take.
  void EvaluateRest();
  // Evaluates the take; times ascend. O(joints).
  void Evaluate(double ticks);

  // Pose of joint `j` relative to its parent joint, or to the scene for the root.
  const Eigen::Isometry3d& local(std::size_t j) const { return local_[j]; }
  Eigen::Vector3d position(std::size_t j) const { return in_scene_[j].translation(); }

  // Index of a joint whose position is not finite or above 1e15, or -1.
  int FindOverflow() const;

 private:
  template <typename LocalOf>
  void EvaluateWith(const LocalOf& local_of);

  const SceneSkeleton& skeleton_;
  const std::vector<JointTrack>& tracks_;
  std::vector<TrackCursor> cursors_;
  std::vector<Eigen::Affine3d> in_scene_;  // with scales
  std::vector<Eigen::Matrix3d> rotations_;
  std::vector<Eigen::Isometry3d> local_;
};

}  // namespace motiondb::importer
