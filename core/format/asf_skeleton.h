// An ASF file's bones -> a Skeleton, and where the values of an AMC file go in its joint angles.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/format/asf_file.h"
#include "core/motion/skeleton.h"

namespace motiondb::core {

// Where one value of a bone's line in an AMC file goes.
struct AmcValue {
  int column = -1;  // degree of freedom of the skeleton; -1: none, the value is dropped
  bool is_rotation = true;
};

struct AmcBone {
  std::string name;
  std::vector<AmcValue> values;
};

struct AsfSkeleton {
  Skeleton skeleton;           // metres, z up
  std::vector<AmcBone> bones;  // those of the ASF, in its order
  bool drops_stretch = false;  // some bone changes its length, which a skeleton cannot
};

// Joint "x" is at the start of bone x (its parent's tip) and carries its rotation, within the axes
// C of the bone: C R C^-1. Every bone without children gets a joint "x_end" at its tip. Values
// listed as rx ry rz combine as Rz Ry Rx.
absl::StatusOr<AsfSkeleton> BuildAsfSkeleton(const AsfFile& file, double metres_per_unit,
                                             const Eigen::Matrix3d& world_from_file);

}  // namespace motiondb::core
