// Parts that several elements of a URDF file have.
#pragma once

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <span>
#include <string_view>
#include <utility>

#include "absl/status/status.h"
#include "core/motion/error.h"

namespace tinyxml2 {
class XMLElement;
}  // namespace tinyxml2

namespace motiondb::core {

// Line of an element in its file, from 1.
int UrdfLine(const tinyxml2::XMLElement& element);

// Returns INVALID_ARGUMENT "FILE:LINE: ..." at an element.
template <typename... Args>
absl::Status UrdfError(std::string_view file_name, const tinyxml2::XMLElement& element,
                       fmt::format_string<Args...> format, Args&&... args) {
  return InvalidArgument("{}:{}: {}", file_name, UrdfLine(element),
                         fmt::format(format, std::forward<Args>(args)...));
}

// Reads an attribute that is as many finite numbers as `values`, separated by blanks. Without the
// attribute, the values stay unchanged. INVALID_ARGUMENT.
absl::Status ReadUrdfNumbers(std::string_view file_name, const tinyxml2::XMLElement& element,
                             const char* attribute, std::span<double* const> values);

// The same for one vector.
absl::Status ReadUrdfVector(std::string_view file_name, const tinyxml2::XMLElement& element,
                            const char* attribute, Eigen::Vector3d& value);

// The pose of an element in its parent's frame.
struct UrdfOrigin {
  Eigen::Vector3d xyz_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d rpy_rad = Eigen::Vector3d::Zero();  // about the parent's fixed x, y and z
};

// Reads the <origin> in an element; the identity without one. INVALID_ARGUMENT.
absl::Status ReadUrdfOrigin(std::string_view file_name, const tinyxml2::XMLElement& element,
                            UrdfOrigin& origin);

// Returns the rotation of URDF's rpy (rad): roll, pitch and yaw about the parent's fixed x, y and
// z.
Eigen::Matrix3d FromRollPitchYaw(const Eigen::Vector3d& rpy);

}  // namespace motiondb::core
