// The floor that a plan leads over: poses on it, what stands on it, and the way round.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <numbers>
#include <vector>

#include "absl/status/status.h"

namespace motiondb::core {

// A pose on the floor: where a reference frame is and where it faces. Plain values; functions are
// safe to call from any thread.

// Origin (m) and heading (rad, counter-clockwise about z) of a frame, in some other frame.
struct FloorPose {
  double x = 0;
  double y = 0;
  double heading = 0;
};

// `inner`, given in the frame that `outer` places, placed where `outer` is.
inline FloorPose operator*(const FloorPose& outer, const FloorPose& inner) {
  const double c = std::cos(outer.heading);
  const double s = std::sin(outer.heading);
  return {outer.x + c * inner.x - s * inner.y, outer.y + s * inner.x + c * inner.y,
          outer.heading + inner.heading};
}

// `pose` as seen from `frame`: frame * RelativeTo(frame, pose) == pose.
inline FloorPose RelativeTo(const FloorPose& frame, const FloorPose& pose) {
  const double c = std::cos(frame.heading);
  const double s = std::sin(frame.heading);
  const double dx = pose.x - frame.x;
  const double dy = pose.y - frame.y;
  return {c * dx + s * dy, -s * dx + c * dy, pose.heading - frame.heading};
}

// Angle (rad) brought to [-pi, pi].
inline double WrapAngle(double angle) {
  // Most are wrapped already, and std::remainder is slow.
  return std::abs(angle) <= std::numbers::pi ? angle : std::remainder(angle, 2 * std::numbers::pi);
}

// What stands on the floor. Plain values; functions are safe to call from any thread.
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

// INVALID_ARGUMENT, saying which corners, for a polygon with a corner that is not finite, with
// fewer than three different corners in a row, or whose line crosses, touches or goes back along
// itself. A corner that repeats the one before it, or the first at the end, does no harm. O(n log
// n) for n corners of shapes as people draw them, O(n^2) for the worst.
absl::Status CheckPolygon(const Polygon& polygon);

// The floor as a grid around obstacles: how far it is to the goal round them, a lower bound that
// guides the search, and a fast answer to whether a point is clear of them. Immutable; safe to
// share between threads. The obstacles must outlive it.
class FloorField {
 public:
  // Shortest ways over a grid of the floor around start and goal, leaving out cells that lie wholly
  // too near to an obstacle. Without obstacles, and beyond the grid, it is the straight line. Cells
  // get coarser where there are many or many corners, so that the work is bounded.
  FloorField(const Obstacles& obstacles, const Eigen::Vector2d& start, const Eigen::Vector2d& goal);

  // Metres from a point to the goal, never more than the way is long; infinite where there is none.
  double DistanceToGoal(const Eigen::Vector2d& point) const;

  // Distance(obstacles, point) >= distance_m, without looking at the obstacles for most points.
  bool Keeps(const Eigen::Vector2d& point, double distance_m) const;

 private:
  int IndexAt(const Eigen::Vector2d& point) const;

  const Obstacles& obstacles_;
  Eigen::Vector2d goal_;
  Eigen::Vector2d origin_ = Eigen::Vector2d::Zero();
  double cell_m_ = 0;  // 0: no grid
  int columns_ = 0;
  int rows_ = 0;
  bool enclosed_ = false;             // no way leads from the goal to the grid's edge
  std::vector<float> to_obstacle_m_;  // from each cell's middle
  std::vector<float> to_goal_m_;
};

}  // namespace motiondb::core
