// The points of the body that were found in a motion, for people who look at a file.
#pragma once

#include <string>
#include <vector>

#include "core/mapping/figure.h"

namespace motiondb::core {

struct FoundRole {
  int point = -1;    // joint or marker
  std::string role;  // "left knee", or the anatomical landmark of an optical marker
  double confidence = 0;
};

// Returns the roles that MapAutomatically uses, also uncertain ones.
std::vector<FoundRole> FindRoles(const PointCloud& points);

}  // namespace motiondb::core
