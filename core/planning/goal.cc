#include "core/planning/goal.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string_view>

namespace motiondb::core {
namespace {

constexpr double kAimMargin = 0.02;  // m of extra clearance at the end

}  // namespace

std::string WhyUnreachable(const PlanProblem& problem, const StoredFloor& floor) {
  const FloorPose& goal = problem.goal;
  const double clearance = problem.obstacles.clearance_m;
  const auto too_near = [&](std::string_view what, double distance) {
    return distance < 0 ? fmt::format("the {} is inside an obstacle", what)
                        : fmt::format("the {} is {:.3g} m from an obstacle, expected {:.3g}", what,
                                      distance, clearance);
  };
  const double goal_distance = Distance(problem.obstacles, {goal.x, goal.y});
  if (goal_distance + problem.position_tolerance_m < clearance) {
    return too_near("goal", goal_distance);
  }
  const double start_distance = Distance(problem.obstacles, {0, 0});
  if (start_distance < clearance) return too_near("start", start_distance);
  const double reach = floor.top_speed_m_s() * problem.max_duration_seconds;
  const double distance_m = std::hypot(goal.x, goal.y);
  if (distance_m - problem.position_tolerance_m > reach) {
    return fmt::format(
        "the goal is {:.2f} m away, the fastest stored motion covers {:.2f} m in {:.3g} s",
        distance_m, reach, problem.max_duration_seconds);
  }
  const double turn = std::abs(WrapAngle(goal.heading));
  const double max_turn = floor.top_turn_rad_s() * problem.max_duration_seconds;
  if (turn - problem.heading_tolerance_rad > max_turn) {
    return fmt::format(
        "the goal's heading differs by {:.2f} rad, the fastest stored motion turns {:.2f} rad in "
        "{:.3g} s",
        turn, max_turn, problem.max_duration_seconds);
  }
  return {};
}

FloorPose AimFor(const PlanProblem& problem) {
  const auto is_clear = [&](const FloorPose& pose) {
    return Distance(problem.obstacles, {pose.x, pose.y}) >=
           problem.obstacles.clearance_m + kAimMargin;
  };
  constexpr int kRings = 8;
  constexpr int kBearings = 32;
  for (int ring = 0; ring <= kRings; ++ring) {
    const double away = problem.position_tolerance_m * ring / (kRings + 1);
    for (int i = 0; i < kBearings; ++i) {
      const double bearing = 2 * std::numbers::pi * i / kBearings;
      const FloorPose aim{problem.goal.x + away * std::cos(bearing),
                          problem.goal.y + away * std::sin(bearing), problem.goal.heading};
      if (is_clear(aim)) return aim;
    }
  }
  return problem.goal;
}

}  // namespace motiondb::core
