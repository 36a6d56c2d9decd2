// The floor as a grid around obstacles: how far it is to the goal round them, a lower bound that
// guides the search, and a fast answer to whether a point is clear of them. Immutable; safe to
// share between threads. The obstacles must outlive it.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/planning/obstacles.h"

namespace motiondb::core {

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
