// Colours of the materials of a URDF file.
#pragma once

#include <Eigen/Core>
#include <map>
#include <optional>
#include <string_view>

#include "absl/status/statusor.h"

namespace tinyxml2 {
class XMLElement;
}  // namespace tinyxml2

namespace motiondb::core {

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

}  // namespace motiondb::core
