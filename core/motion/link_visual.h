// Visual shapes of a robot's links, as its file gives them.
#pragma once

#include <Eigen/Geometry>
#include <optional>

namespace motiondb::core {

struct LinkVisual {
  enum class Geometry { kBox, kCylinder, kSphere };
  int joint = 0;  // of the skeleton; the shape is fixed in the frame of this joint
  Geometry geometry = Geometry::kBox;
  // Extents along the shape's own x, y and z, positive. A cylinder is round about z: twice its
  // radius, twice its radius, length. A sphere: three times its diameter.
  Eigen::Vector3d size_m = Eigen::Vector3d::Ones();
  Eigen::Isometry3d joint_from_shape = Eigen::Isometry3d::Identity();  // centre of the shape, m
  // Red, green, blue (sRGB) and opacity, 0 to 1; nothing if the file has no colour.
  std::optional<Eigen::Vector4d> color;
};

}  // namespace motiondb::core
