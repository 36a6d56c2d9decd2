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

namespace {

// Returns the path with a fraction of the correction: rotated step by step, then shifted.
CorrectedRoot Apply(const std::vector<FloorPose>& root, const std::vector<double>& progress,
                    const FloorPose& goal, double turn, double share) {
  CorrectedRoot corrected{.poses = {root.front()}};
  for (std::size_t t = 1; t < root.size(); ++t) {
    const FloorPose step = RelativeTo(root[t - 1], root[t]);
    FloorPose from = corrected.poses.back();
    from.heading = root[t - 1].heading + share * progress[t - 1] * turn;
    FloorPose to = from * step;
    to.heading = root[t].heading + share * progress[t] * turn;
    corrected.poses.push_back(to);
  }
  const double dx = share * (goal.x - corrected.poses.back().x);
  const double dy = share * (goal.y - corrected.poses.back().y);
  for (std::size_t t = 0; t < root.size(); ++t) {
    FloorPose& pose = corrected.poses[t];
    pose.x += progress[t] * dx;
    pose.y += progress[t] * dy;
    if (t > 0) {
      const FloorPose& before = corrected.poses[t - 1];
      corrected.length_m += std::hypot(pose.x - before.x, pose.y - before.y);
    }
    corrected.largest_shift_m =
        std::max(corrected.largest_shift_m, std::hypot(pose.x - root[t].x, pose.y - root[t].y));
  }
  corrected.turn_rad = std::abs(share * turn);
  return corrected;
}

}  // namespace

GoalError ErrorAt(const FloorPose& end, const FloorPose& goal) {
  return {std::hypot(goal.x - end.x, goal.y - end.y),
          std::abs(WrapAngle(goal.heading - end.heading))};
}

GoalError ErrorAfterCorrection(const FloorPose& end, double length_m, const FloorPose& goal) {
  const GoalError error = ErrorAt(end, goal);
  const double allowed = kMaxCorrection * length_m;
  const double turn = std::min(error.heading_rad, allowed);
  // A rotation spread over the path bends it by up to an eighth of its length per radian.
  const double shift = std::max(0.0, allowed - turn * length_m / 8);
  return {std::max(0.0, error.position_m - shift), error.heading_rad - turn};
}

CorrectedRoot CorrectRoot(const std::vector<FloorPose>& root, const FloorPose& goal) {
  std::vector<double> progress(root.size(), 0.0);
  for (std::size_t t = 1; t < root.size(); ++t) {
    progress[t] =
        progress[t - 1] + std::hypot(root[t].x - root[t - 1].x, root[t].y - root[t - 1].y);
  }
  const double length = progress.back();
  if (!(length > 0)) return {.poses = root};
  for (double& share : progress) share /= length;

  const double max_turn = kMaxCorrection * length;
  const double turn =
      std::clamp(WrapAngle(goal.heading - root.back().heading), -max_turn, max_turn);
  double share = 1;
  CorrectedRoot corrected = Apply(root, progress, goal, turn, share);
  // The shift is nearly proportional to the share, so a few iterations satisfy the limit.
  for (int i = 0; i < 20; ++i) {
    const double allowed = kMaxCorrection * std::min(length, corrected.length_m);
    if (corrected.largest_shift_m <= allowed) break;
    share *= 0.99 * allowed / corrected.largest_shift_m;
    corrected = Apply(root, progress, goal, turn, share);
  }
  return corrected;
}

}  // namespace motiondb::core
