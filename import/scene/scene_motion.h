// Joint motion of a take.
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
