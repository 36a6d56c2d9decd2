#include "core/planning/root_correction.h"

#include <algorithm>
#include <cmath>

namespace motiondb::core {
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
