// Motors and masses of a robot, as its file gives them.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <vector>

namespace motiondb::core {

// Mass distribution of the link that moves with a joint, in the joint's frame.
struct LinkInertia {
  double mass_kg = 0;
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();       // centre of mass
  Eigen::Matrix3d inertia_kg_m2 = Eigen::Matrix3d::Zero();  // about the centre of mass
};

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
