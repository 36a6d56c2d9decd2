#include "core/format/urdf_elements.h"

#include <tinyxml2.h>

#include <array>
#include <optional>

#include "core/format/text_scanner.h"
#include "core/motion/error.h"

namespace motiondb::core {

using tinyxml2::XMLElement;

int UrdfLine(const XMLElement& element) { return element.GetLineNum(); }

absl::Status ReadUrdfNumbers(std::string_view file_name, const XMLElement& element,
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

absl::Status ReadUrdfVector(std::string_view file_name, const XMLElement& element,
                            const char* attribute, Eigen::Vector3d& value) {
  const std::array<double*, 3> values = {&value.x(), &value.y(), &value.z()};
  return ReadUrdfNumbers(file_name, element, attribute, values);
}

absl::Status ReadUrdfOrigin(std::string_view file_name, const XMLElement& element,
                            UrdfOrigin& origin) {
  const XMLElement* const given = element.FirstChildElement("origin");
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

namespace {

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

namespace {

using Geometry = LinkVisual::Geometry;

// The only child of <geometry> that counts; null without one.
const XMLElement* GeometryOf(const XMLElement& visual) {
  const XMLElement* const geometry = visual.FirstChildElement("geometry");
  return geometry == nullptr ? nullptr : geometry->FirstChildElement();
}

std::optional<Geometry> KindOf(const XMLElement& geometry) {
  const std::string_view name = geometry.Name();
  if (name == "box") return Geometry::kBox;
  if (name == "cylinder") return Geometry::kCylinder;
  if (name == "sphere") return Geometry::kSphere;
  return std::nullopt;
}

// Reads the extents of a shape.
absl::Status ReadSize(std::string_view file_name, const XMLElement& geometry, LinkVisual& visual) {
  Eigen::Vector3d& size = visual.size_m;
  size.setZero();
  if (visual.geometry == Geometry::kBox) {
    MOTIONDB_RETURN_IF_ERROR(ReadUrdfVector(file_name, geometry, "size", size));
  } else {
    double radius = 0;
    const std::array<double*, 1> radius_only = {&radius};
    MOTIONDB_RETURN_IF_ERROR(ReadUrdfNumbers(file_name, geometry, "radius", radius_only));
    size.setConstant(2 * radius);
  }
  if (visual.geometry == Geometry::kCylinder) {
    size.z() = 0;
    const std::array<double*, 1> length = {&size.z()};
    MOTIONDB_RETURN_IF_ERROR(ReadUrdfNumbers(file_name, geometry, "length", length));
  }
  if (size.minCoeff() > 0 && size.maxCoeff() <= kMaxVisualLength_m) return absl::OkStatus();
  return UrdfError(file_name, geometry,
                   "expected a {} with sizes above 0 and at most {} m, found {} x {} x {} m",
                   geometry.Name(), kMaxVisualLength_m, size.x(), size.y(), size.z());
}

}  // namespace

absl::StatusOr<std::vector<LinkVisual>> ReadLinkVisuals(std::string_view file_name,
                                                        const XMLElement& link,
                                                        const UrdfMaterials& materials,
                                                        std::size_t read_count) {
  std::vector<LinkVisual> visuals;
  for (const XMLElement* element = link.FirstChildElement("visual"); element != nullptr;
       element = element->NextSiblingElement("visual")) {
    const XMLElement* const geometry = GeometryOf(*element);
    const auto kind = geometry == nullptr ? std::nullopt : KindOf(*geometry);
    if (!kind) return std::vector<LinkVisual>();
    if (read_count + visuals.size() == kMaxVisuals) {
      return UrdfError(file_name, *element, "expected at most {} visual shapes, found one more",
                       kMaxVisuals);
    }
    LinkVisual& visual = visuals.emplace_back();
    visual.geometry = *kind;
    MOTIONDB_RETURN_IF_ERROR(ReadSize(file_name, *geometry, visual));
    UrdfOrigin origin;
    MOTIONDB_RETURN_IF_ERROR(ReadUrdfOrigin(file_name, *element, origin));
    if (!(origin.xyz_m.cwiseAbs().maxCoeff() <= kMaxVisualLength_m)) {
      return UrdfError(file_name, *element, "expected a shape at most {} m from its link",
                       kMaxVisualLength_m);
    }
    visual.joint_from_shape.linear() = FromRollPitchYaw(origin.rpy_rad);
    visual.joint_from_shape.translation() = origin.xyz_m;
    MOTIONDB_ASSIGN_OR_RETURN(visual.color, materials.ColorOf(*element));
  }
  return visuals;
}

}  // namespace motiondb::core
