// The kinematics that a URDF file writes down: links and joints, as the file has them. What hangs
// on what is for urdf_reader.h to find out. Plain values; safe to call from any thread.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/format/motion_file.h"

namespace motiondb::core {

struct UrdfLink {
  int line = 0;
  std::string name;  // UTF-8, as every name here
};

// The joint's value is multiplier * (the master's value) + offset.
struct UrdfMimic {
  std::string master;
  double multiplier = 1;
  double offset = 0;  // rad or m
};

struct UrdfJoint {
  enum class Type { kRevolute, kContinuous, kPrismatic, kFixed, kFloating, kPlanar };
  int line = 0;
  std::string name;
  Type type = Type::kFixed;
  std::string parent;
  std::string child;
  Eigen::Vector3d xyz_m = Eigen::Vector3d::Zero();    // the child's origin in the parent's frame
  Eigen::Vector3d rpy_rad = Eigen::Vector3d::Zero();  // about the parent's fixed x, y and z
  Eigen::Vector3d axis = Eigen::Vector3d::UnitX();    // unit length, in the child's frame
  double lower = 0;                                   // rad or m; of revolute and prismatic alone
  double upper = 0;
  std::optional<UrdfMimic> mimic;
};

struct UrdfFile {
  std::string name;  // the robot's
  std::vector<UrdfLink> links;
  std::vector<UrdfJoint> joints;
};

// INVALID_ARGUMENT names file, line and what was expected: XML of at most 4 MiB, one <robot>,
// names, known joint types, numbers that are finite, an axis of some length, limits in order. What
// is not kinematics (masses, meshes, transmissions, a simulator's own elements) is passed over. A
// document type is refused: entities that it declares would stay unread.
absl::StatusOr<UrdfFile> ReadUrdfFile(SourceFile file);

}  // namespace motiondb::core
