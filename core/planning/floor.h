// The floor of a plan: poses, obstacles and distances around them.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <numbers>
#include <vector>

#include "absl/status/status.h"

namespace motiondb::core {

// A pose on the floor: origin (m) and heading (rad, counter-clockwise about z) of a frame, relative
// to another frame.
struct FloorPose {
  double x = 0;
  double y = 0;
  double heading = 0;
};

// Composes poses: `inner` is relative to `outer`.
inline FloorPose operator*(const FloorPose& outer, const FloorPose& inner) {
  const double c = std::cos(outer.heading);
  const double s = std::sin(outer.heading);
  return {outer.x + c * inner.x - s * inner.y, outer.y + s * inner.x + c * inner.y,
          outer.heading + inner.heading};
}

// Returns `pose` relative to `frame`: frame * RelativeTo(frame, pose) == pose.
inline FloorPose RelativeTo(const FloorPose& frame, const FloorPose& pose) {
  const double c = std::cos(frame.heading);
  const double s = std::sin(frame.heading);
  const double dx = pose.x - frame.x;
  const double dy = pose.y - frame.y;
  return {c * dx + s * dy, -s * dx + c * dy, pose.heading - frame.heading};
}

// Wraps an angle (rad) to [-pi, pi].
inline double WrapAngle(double angle) {
  // Fast path: std::remainder is slow, and most angles are wrapped already.
  return std::abs(angle) <= std::numbers::pi ? angle : std::remainder(angle, 2 * std::numbers::pi);
}

// A circular obstacle.
struct Disc {
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();  // m
  double radius_m = 0;
};

// The area inside a simple closed polyline, corners in either order.
struct Polygon {
  std::vector<Eigen::Vector2d> corners;  // m, at least three
};

struct Obstacles {
  std::vector<Disc> discs;
  std::vector<Polygon> polygons;
  double clearance_m = 0.3;  // minimum distance of the root

  bool empty() const { return discs.empty() && polygons.empty(); }
};

// Returns the distance (m) from a point to the nearest obstacle; negative inside, infinite without
// obstacles. O(corners).
double Distance(const Obstacles& obstacles, const Eigen::Vector2d& point);

// INVALID_ARGUMENT, naming corners, if a corner is not finite, fewer than three successive corners
// differ, or sides cross, touch or overlap. Repeated successive corners, also last and first, are
// valid. O(n log n) for typical shapes of n corners, O(n^2) at worst.
absl::Status CheckPolygon(const Polygon& polygon);

// A grid of the floor around obstacles: a lower bound of the distance to the goal, which guides the
// search, and fast clearance checks. Immutable. The obstacles must outlive it.
class FloorField {
 public:
  // Computes shortest paths over a grid around start and goal, without cells that are entirely too
  // near to an obstacle. Without obstacles, and outside the grid, distances are straight lines.
  // Cells are coarser for large areas or many corners, to bound the work.
  FloorField(const Obstacles& obstacles, const Eigen::Vector2d& start, const Eigen::Vector2d& goal);

  // Returns a lower bound of the path length (m) from a point to the goal; infinite if there is no
  // path.
  double DistanceToGoal(const Eigen::Vector2d& point) const;

  // Whether Distance(obstacles, point) >= distance_m; does not examine the obstacles for most
  // points.
  bool HasClearance(const Eigen::Vector2d& point, double distance_m) const;

 private:
  int IndexAt(const Eigen::Vector2d& point) const;

  const Obstacles& obstacles_;
  Eigen::Vector2d goal_;
  Eigen::Vector2d origin_ = Eigen::Vector2d::Zero();
  double cell_m_ = 0;  // 0: no grid
  int columns_ = 0;
  int rows_ = 0;
  bool enclosed_ = false;             // no path from the goal to the grid's edge
  std::vector<float> to_obstacle_m_;  // from each cell's centre
  std::vector<float> to_goal_m_;
};

}  // namespace motiondb::core
