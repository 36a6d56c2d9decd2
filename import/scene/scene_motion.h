// Joint motion of a take, from the poses of the joints in its frames.
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "core/format/motion_file.h"
#include "core/motion/matrix.h"
#include "core/motion/motion.h"
#include "import/scene/scene_skeleton.h"
#include "import/scene/scene_timing.h"
#include "import/scene/scene_tracks.h"

namespace motiondb::importer {

// Poses of a scene's joints as rotations and positions, without scales.
//
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

// The parts of a take from which its motion is made. Each must outlive the TakeSampler.
struct SampledTake {
  std::string_view file_name;
  const SceneSkeleton& skeleton;
  const std::vector<JointTrack>& tracks;
  const SceneTiming& timing;
};

// Samples a take twice: first to see which joints slide and which order of rotations suits them,
// then to write their angles. So it needs no memory for all poses.
class TakeSampler {
 public:
  explicit TakeSampler(const SampledTake& take);

  // INVALID_ARGUMENT, with node and frame, if a position is not finite. O(frames x joints).
  absl::Status Measure();

  // Positions of the joints in frames spread over the take, relative to the root's first one, in
  // the scene's axes and unit: at most 32 rows x 3 * joints. REQUIRES: Measure.
  core::FrameMatrix SamplePositions() const;

  // Returns the motion in the world (m, z up). A joint has three rotations if it has a channel or
  // its rotation is not constant, and three translations if its offset varies by more than 1e-6 of
  // the figure's size. Zero rotations are those of the nodes without the take. REQUIRES: Measure.
  absl::StatusOr<core::JointMotion> Motion(const core::SourceReport& report,
                                           double metres_per_scene_unit) const;

 private:
  // What the take does with a joint, relative to its parent.
  struct JointUse {
    Eigen::Isometry3d rest = Eigen::Isometry3d::Identity();
    Eigen::Isometry3d first = Eigen::Isometry3d::Identity();
    double slide = 0;  // greatest distance from the first offset
    bool rotates = false;
    double lock_zxy = 0;  // greatest cosine between first and last axis: 1 is gimbal lock
    double lock_zyx = 0;
  };

  double TicksOf(int frame) const;
  void Add(const Eigen::Isometry3d& local, JointUse& use) const;
  bool Slides(const JointUse& use) const { return use.slide > 1e-6 * size_; }
  core::Joint MakeJoint(std::size_t j, const Eigen::Matrix3d& world_from_scene,
                        double metres_per_unit) const;

  SampledTake take_;
  std::vector<JointUse> uses_;
  double size_ = 0;  // of the figure: diagonal of the box around the joints in the first frame
};

}  // namespace motiondb::importer
