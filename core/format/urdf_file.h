// Links and joints of a URDF file, unconverted. urdf_reader.h connects them.
#pragma once

#include <Eigen/Core>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/format/motion_file.h"
#include "core/format/urdf_elements.h"
#include "core/motion/robot.h"

namespace motiondb::core {

struct UrdfLink {
  int line = 0;
  std::string name;                 // UTF-8, as all names here
  LinkInertia inertia;              // in the link's frame; mass 0: not given
  std::vector<LinkVisual> visuals;  // in the link's frame, without a joint; see ReadLinkVisuals
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
  UrdfOrigin origin;                                // of the child in the parent's frame
  Eigen::Vector3d axis = Eigen::Vector3d::UnitX();  // unit length, in the child's frame
  double lower = 0;                                 // rad or m; revolute and prismatic only
  double upper = 0;
  // Revolute, continuous and prismatic only; infinite: not given, or given as 0.
  double max_speed = std::numeric_limits<double>::infinity();   // rad/s or m/s
  double max_effort = std::numeric_limits<double>::infinity();  // N m or N
  std::optional<UrdfMimic> mimic;
};

struct UrdfFile {
  std::string name;  // the robot's
  std::vector<UrdfLink> links;
  std::vector<UrdfJoint> joints;
  int invalid_visual_links = 0;    // links without visuals because one of them is invalid
  std::string first_visual_error;  // of these links
};

// Reads XML of at most 4 MiB with one <robot>, names, known joint types, finite numbers, nonzero
// axes, ordered limits, and masses, speeds and efforts of at least 0; INVALID_ARGUMENT names file,
// line and the expected content. Ignores meshes, transmissions and simulator elements. An invalid
// visual shape is no error, because the motion does not depend on it: its link has no visuals.
// Rejects a document type, because its entities would not be expanded.
absl::StatusOr<UrdfFile> ReadUrdfFile(SourceFile file);

}  // namespace motiondb::core
