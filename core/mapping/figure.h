// The figure of a person in a motion: which joint or marker is at which point of the body.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/mapping/joint_names.h"
#include "core/motion/motion.h"

namespace motiondb::core {

// A joint or marker at a point of the body; index -1: none.
struct RolePoint {
  int index = -1;
  // Probability that the choice is correct, judged from name and structure.
  double confidence = 0;

  bool is_found() const { return index >= 0; }
};

struct Figure {
  std::vector<std::string> names;  // joints or markers of the motion
  // [role][0]: the middle or the left side, [role][1]: the right side.
  std::array<std::array<RolePoint, 2>, kRoleCount> points;
  // Joints from the pelvis to the base of the neck, in order; without hips and neck.
  std::vector<int> spine;
  // Why the motion cannot be mapped; empty if it can.
  std::string problem;

  const RolePoint& at(Role role, Side side = Side::kNone) const {
    return points[static_cast<std::size_t>(role)][side == Side::kRight ? 1 : 0];
  }
  RolePoint& at(Role role, Side side = Side::kNone) {
    return points[static_cast<std::size_t>(role)][side == Side::kRight ? 1 : 0];
  }
};

// Without these there is no figure.
inline constexpr Role kNecessaryRoles[] = {Role::kHip,      Role::kKnee,  Role::kAnkle,
                                           Role::kShoulder, Role::kElbow, Role::kWrist};

// Returns whether all necessary roles have a point.
bool IsComplete(const Figure& figure);

// Positions (m or any unit, any axes) of all points in some frames spread over a motion, and the
// hierarchy, if there is one.
struct PointCloud {
  std::vector<std::string> names;
  std::vector<int> parents;  // -1: a root; empty: no hierarchy
  std::vector<Eigen::Matrix3Xd> frames;
  // world_from_joint of each frame and joint; empty without hierarchy.
  std::vector<std::vector<Eigen::Matrix3d>> rotations;

  int count() const { return static_cast<int>(names.size()); }
};

// Returns at most `max_frames` frames, spread evenly. O(joints) for each.
PointCloud SamplePoints(const Motion& motion, int max_frames = 24);

// Finds the figure from the names, the branching of the hierarchy and the lengths of its bones.
// Independent of the unit and of the axes, which may not be known yet. If names of sides contradict
// the direction of feet and knees, `problem` says so: sides are never guessed.
Figure FindFigure(const PointCloud& points);

// Lowest confidence at which a role counts as found.
inline constexpr double kMinRoleConfidence = 0.5;

// The two searches of FindFigure, before sides are checked.

// Finds legs, arms, trunk and head in a hierarchy by names and bones. Limbs without names of sides
// are in any order. Nothing if no two pairs of limbs are like legs and arms.
std::optional<Figure> FindInHierarchy(const PointCloud& points,
                                      const std::vector<NameMeaning>& meanings);

// Finds points by their names alone.
Figure FindByNames(const PointCloud& points, const std::vector<NameMeaning>& meanings);

}  // namespace motiondb::core
