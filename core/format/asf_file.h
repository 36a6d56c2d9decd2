// The contents of an ASF (Acclaim skeleton) file, in the file's own units and terms; and its
// conversion to a Skeleton.
#pragma once

#include <Eigen/Core>
#include <array>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/format/motion_file.h"
#include "core/motion/motion.h"

namespace motiondb::core {

// One value of a bone in each frame of an AMC file.
struct AsfChannel {
  enum class Kind { kTranslation, kRotation, kStretch };
  Kind kind = Kind::kRotation;
  int axis = 0;                                             // 0 x, 1 y, 2 z; unused for kStretch
  double lower = -std::numeric_limits<double>::infinity();  // in the file's units
  double upper = std::numeric_limits<double>::infinity();
};

// A bone, or the root, which has direction and length zero.
struct AsfBone {
  std::string name;                                     // UTF-8
  int parent = -1;                                      // index into AsfFile::bones
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();  // unit length, from start to tip
  double length = 0;
  Eigen::Vector3d axis_angles =
      Eigen::Vector3d::Zero();  // about axis_order's axes, the first is applied first
  std::array<int, 3> axis_order = {0, 1, 2};
  std::vector<AsfChannel> channels;  // in the order in which an AMC lists their values
};

struct AsfFile {
  std::string name;
  std::optional<double> length_unit;  // `length` of :units
  bool degrees = true;                // `angle` of :units
  Eigen::Vector3d root_position = Eigen::Vector3d::Zero();
  std::vector<AsfBone> bones;  // the root first, a parent before its children
};

// The file may be compressed with gzip. Unknown sections are skipped. Errors: see ReadMotionFile.
absl::StatusOr<AsfFile> ReadAsf(SourceFile file);

// Destination of one value of a bone's line in an AMC file.
struct AmcValue {
  int column = -1;  // degree of freedom of the skeleton; -1: the value is ignored
  bool is_rotation = true;
};

struct AmcBone {
  std::string name;
  std::vector<AmcValue> values;
};

struct AsfSkeleton {
  Skeleton skeleton;           // metres, z up
  std::vector<AmcBone> bones;  // in the order of the ASF
  bool drops_stretch = false;  // a bone changes its length, which skeletons do not support
};

// Converts an ASF file's bones to a Skeleton and the layout of AMC values. Joint "x" is at the
// start of bone x (its parent's tip) and carries its rotation in the axes C of the bone: C R C^-1.
// Every bone without children gets a joint "x_end" at its tip. Values listed as rx ry rz combine as
// Rz Ry Rx.
absl::StatusOr<AsfSkeleton> BuildAsfSkeleton(const AsfFile& file, double metres_per_unit,
                                             const Eigen::Matrix3d& world_from_file);

}  // namespace motiondb::core
