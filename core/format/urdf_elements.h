// Elements of a URDF file: numbers and poses, colours of materials, and visual shapes of links.
#pragma once

#include <fmt/format.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>
#include <map>
#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/motion/error.h"
#include "core/motion/robot.h"

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

// The materials with a <color> of a file: those in <robot>, then those in the <visual> elements of
// its links. Of materials with the same name, the first one counts.
class UrdfMaterials {
 public:
  // Both must outlive the object.
  UrdfMaterials(std::string_view file_name, const tinyxml2::XMLElement& robot);

  // Returns the colour of a <visual>: red, green, blue (sRGB) and opacity, 0 to 1. It is that of
  // the <material> in the element, otherwise that of the material with its name. Returns nothing if
  // there is none: no <material>, an unknown name, or a texture. INVALID_ARGUMENT names file, line
  // and the expected content: `rgba` is four numbers from 0 to 1.
  absl::StatusOr<std::optional<Eigen::Vector4d>> ColorOf(const tinyxml2::XMLElement& visual) const;

 private:
  void Add(const tinyxml2::XMLElement& owner);

  std::string_view file_name_;
  std::map<std::string_view, const tinyxml2::XMLElement*> colors_;  // <color> by material name
};

// Sizes of shapes and their distances from the link, along an axis.
inline constexpr double kMaxVisualLength_m = 100;
// Of all links of a file: a picture places each of them.
inline constexpr std::size_t kMaxVisuals = 1000;

// Returns the shapes of a <link>, in its frame (`joint` is not set): all of its <visual> elements,
// or none if one of them has no box, cylinder or sphere, because the others alone would mislead.
// INVALID_ARGUMENT names file, line and the expected content: numbers are finite, sizes above 0 and
// at most kMaxVisualLength_m, colours as in UrdfMaterials; with the `read_count` shapes of the
// links before, there are at most kMaxVisuals.
absl::StatusOr<std::vector<LinkVisual>> ReadLinkVisuals(std::string_view file_name,
                                                        const tinyxml2::XMLElement& link,
                                                        const UrdfMaterials& materials,
                                                        std::size_t read_count);

}  // namespace motiondb::core
