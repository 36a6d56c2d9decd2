#include "core/format/urdf_elements.h"

#include <tinyxml2.h>

#include <array>

#include "core/format/text_scanner.h"

namespace motiondb::core {

int UrdfLine(const tinyxml2::XMLElement& element) { return element.GetLineNum(); }

absl::Status ReadUrdfNumbers(std::string_view file_name, const tinyxml2::XMLElement& element,
                             const char* attribute, std::span<double* const> values) {
  const char* text = element.Attribute(attribute);
  if (text == nullptr) return absl::OkStatus();
  TextScanner scanner({.name = file_name, .bytes = text});
  bool complete = true;
  for (double* value : values) complete = complete && scanner.TryNumber(*value);
  if (complete && scanner.AtEnd()) return absl::OkStatus();
  return UrdfError(file_name, element, "expected {} finite number{} as {} of <{}>, found '{}'",
                   values.size(), values.size() == 1 ? "" : "s", attribute, element.Name(),
                   Shown(text));
}

absl::Status ReadUrdfVector(std::string_view file_name, const tinyxml2::XMLElement& element,
                            const char* attribute, Eigen::Vector3d& value) {
  const std::array<double*, 3> values = {&value.x(), &value.y(), &value.z()};
  return ReadUrdfNumbers(file_name, element, attribute, values);
}

absl::Status ReadUrdfOrigin(std::string_view file_name, const tinyxml2::XMLElement& element,
                            UrdfOrigin& origin) {
  const tinyxml2::XMLElement* const given = element.FirstChildElement("origin");
  if (given == nullptr) return absl::OkStatus();
  MOTIONDB_RETURN_IF_ERROR(ReadUrdfVector(file_name, *given, "xyz", origin.xyz_m));
  return ReadUrdfVector(file_name, *given, "rpy", origin.rpy_rad);
}

Eigen::Matrix3d FromRollPitchYaw(const Eigen::Vector3d& rpy) {
  return (Eigen::AngleAxisd(rpy.z(), Eigen::Vector3d::UnitZ()) *
          Eigen::AngleAxisd(rpy.y(), Eigen::Vector3d::UnitY()) *
          Eigen::AngleAxisd(rpy.x(), Eigen::Vector3d::UnitX()))
      .toRotationMatrix();
}

}  // namespace motiondb::core
