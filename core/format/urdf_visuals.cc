#include "core/format/urdf_visuals.h"

#include <tinyxml2.h>

#include <array>
#include <optional>

#include "core/format/urdf_elements.h"
#include "core/format/urdf_materials.h"
#include "core/motion/error.h"

namespace motiondb::core {
namespace {

using tinyxml2::XMLElement;
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
