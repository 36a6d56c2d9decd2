// Links and joints of a robot, as its file gives them: visual shapes, motors and masses.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <optional>
#include <vector>

namespace motiondb::core {

// A visual shape of a link.
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

// Mass distribution of the link that moves with a joint, in the joint's frame.
struct LinkInertia {
  double mass_kg = 0;
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();       // centre of mass
  Eigen::Matrix3d inertia_kg_m2 = Eigen::Matrix3d::Zero();  // about the centre of mass
};

// Motors and masses.
struct RobotDynamics {
  // Of each degree of freedom of the skeleton; infinite: not given.
  Eigen::RowVectorXd max_speeds;   // rad/s, or m/s of a translation
  Eigen::RowVectorXd max_efforts;  // N m, or N of a translation
  // Of the link of each joint of the skeleton.
  std::vector<LinkInertia> links;

  bool has_masses() const {
    return std::any_of(links.begin(), links.end(),
                       [](const LinkInertia& link) { return link.mass_kg > 0; });
  }
};

}  // namespace motiondb::core
