#include "core/format/urdf_materials.h"

#include <tinyxml2.h>

#include <array>

#include "core/format/urdf_elements.h"
#include "core/motion/error.h"

namespace motiondb::core {
namespace {

using tinyxml2::XMLElement;

std::string_view NameOfMaterial(const XMLElement& material) {
  const char* const name = material.Attribute("name");
  return name == nullptr ? std::string_view() : name;
}

absl::StatusOr<std::optional<Eigen::Vector4d>> ReadColor(std::string_view file_name,
                                                         const XMLElement& color) {
  if (color.Attribute("rgba") == nullptr) {
    return UrdfError(file_name, color, "expected <color> to have rgba, found none");
  }
  Eigen::Vector4d rgba = Eigen::Vector4d::Zero();
  const std::array<double*, 4> values = {&rgba[0], &rgba[1], &rgba[2], &rgba[3]};
  MOTIONDB_RETURN_IF_ERROR(ReadUrdfNumbers(file_name, color, "rgba", values));
  if (rgba.minCoeff() >= 0 && rgba.maxCoeff() <= 1) return rgba;
  return UrdfError(file_name, color, "expected rgba of <color> from 0 to 1, found {} {} {} {}",
                   rgba[0], rgba[1], rgba[2], rgba[3]);
}

}  // namespace

UrdfMaterials::UrdfMaterials(std::string_view file_name, const XMLElement& robot)
    : file_name_(file_name) {
  Add(robot);
  for (const XMLElement* link = robot.FirstChildElement("link"); link != nullptr;
       link = link->NextSiblingElement("link")) {
    for (const XMLElement* visual = link->FirstChildElement("visual"); visual != nullptr;
         visual = visual->NextSiblingElement("visual")) {
      Add(*visual);
    }
  }
}

absl::StatusOr<std::optional<Eigen::Vector4d>> UrdfMaterials::ColorOf(
    const XMLElement& visual) const {
  const XMLElement* const material = visual.FirstChildElement("material");
  if (material == nullptr) return std::nullopt;
  const XMLElement* color = material->FirstChildElement("color");
  if (color == nullptr) {
    const auto named = colors_.find(NameOfMaterial(*material));
    if (named == colors_.end()) return std::nullopt;
    color = named->second;
  }
  return ReadColor(file_name_, *color);
}

void UrdfMaterials::Add(const XMLElement& owner) {
  for (const XMLElement* material = owner.FirstChildElement("material"); material != nullptr;
       material = material->NextSiblingElement("material")) {
    const XMLElement* const color = material->FirstChildElement("color");
    const std::string_view name = NameOfMaterial(*material);
    if (color != nullptr && !name.empty()) colors_.emplace(name, color);
  }
}

}  // namespace motiondb::core
