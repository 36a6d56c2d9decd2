// What stands on the floor. Plain values; functions are safe to call from any thread.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace motiondb::core {

struct Disc {
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();  // m
  double radius_m = 0;
};

// The area inside a closed line that does not cross itself, corners in either order.
struct Polygon {
  std::vector<Eigen::Vector2d> corners;  // m, at least three
};

struct Obstacles {
  std::vector<Disc> discs;
  std::vector<Polygon> polygons;
  double clearance_m = 0.3;  // that the root keeps from them

  bool empty() const { return discs.empty() && polygons.empty(); }
};

// Distance (m) from a point to the nearest obstacle; negative inside one, infinite where there are
// none. O(corners).
double Distance(const Obstacles& obstacles, const Eigen::Vector2d& point);

}  // namespace motiondb::core
