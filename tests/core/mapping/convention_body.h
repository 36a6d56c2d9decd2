// A recorded person whose points are at the sites of the convention tables.
#pragma once

#include <Eigen/Core>
#include <map>
#include <string>
#include <vector>

#include "core/mapping/figure.h"
#include "core/motion/motion.h"

namespace motiondb::tests {

// A convention of conventions/skeleton_conventions.h.
struct Convention {
  std::string name;
  bool is_hierarchy = false;
  std::vector<std::string> joints;
  std::vector<int> parents;
  std::vector<std::string> sites;
};

// Reads tables; fails the test on an error.
std::vector<Convention> ReadConventions(std::string_view tables);

// One frame of standard34 markers, and any site of the body relative to them.
class ConventionBody {
 public:
  // `markers`: on the standard set; `leg_length_m` of the person.
  ConventionBody(const core::MarkerMotion& markers, Eigen::Index frame, double leg_length_m);

  const Eigen::Vector3d& marker(const std::string& name) const { return markers_.at(name); }
  // Position of a site (m); fails the test if it is unknown.
  Eigen::Vector3d Site(const std::string& site) const;

 private:
  Eigen::Vector3d Between(const std::string& site) const;
  Eigen::Vector3d AlongSpine(double share) const;
  Eigen::Vector3d Finger(const std::string& side, int finger, int segment) const;
  // Displacement in leg lengths: to the front, upwards along the trunk, and to the left.
  Eigen::Vector3d Moved(const Eigen::Vector3d& from, double front, double up, double left) const;

  std::map<std::string, Eigen::Vector3d> markers_;
  double leg_;
  Eigen::Vector3d front_;
  Eigen::Vector3d up_;
  Eigen::Vector3d left_;
};

// Returns the points of a convention on bodies, one for each frame.
core::PointCloud PointsOf(const Convention& convention, const std::vector<ConventionBody>& bodies);

}  // namespace motiondb::tests
