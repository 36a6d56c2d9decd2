// A small synthetic body with virtual markers and motion, for the tests of kinematics.
#pragma once

#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <random>
#include <string>

#include "core/kinematics/marker_kinematics.h"
#include "core/motion/motion.h"

namespace motiondb::tests {

inline core::Dof Turn(const Eigen::Vector3d& axis, double lower = -INFINITY,
                      double upper = INFINITY) {
  return {.kind = core::Dof::Kind::kRotation, .axis = axis, .lower = lower, .upper = upper};
}

inline core::Dof Slide(const Eigen::Vector3d& axis) {
  return {.kind = core::Dof::Kind::kTranslation, .axis = axis};
}

// A free root whose rotations are left-handed because of its third axis, two legs with their own
// axes, a freely rotating spine, and a sliding neck. Hips and knees have limits.
inline std::shared_ptr<const core::Skeleton> Figure() {
  using Eigen::Vector3d;
  const Vector3d x = Vector3d::UnitX();
  const Vector3d y = Vector3d::UnitY();
  const Vector3d z = Vector3d::UnitZ();
  const Eigen::Matrix3d c = Eigen::AngleAxisd(0.4, Vector3d(1, 2, 3).normalized()).matrix();
  std::vector<core::Joint> joints = {
      {.name = "root",
       .offset_m = {0, 0, 0.9},
       .pre_rotation = c,
       .post_rotation = c.transpose(),
       .dofs = {Slide(y), Slide(x), Slide(z), Turn(z), Turn(y), Turn(x)}},
      {.name = "spine", .parent = 0, .offset_m = {0, 0, 0.2}, .dofs = {Turn(x), Turn(y), Turn(z)}},
      {.name = "neck", .parent = 1, .offset_m = {0, 0, 0.3}, .dofs = {Slide(z), Turn(y, -1, 1)}},
      {.name = "head", .parent = 2, .offset_m = {0.05, 0, 0.2}}};
  for (const double side : {0.1, -0.1}) {
    const std::string s = side > 0 ? "l" : "r";
    joints.push_back({.name = s + "hip",
                      .parent = 0,
                      .offset_m = {0, side, 0},
                      .pre_rotation = c,
                      .post_rotation = c.transpose(),
                      .dofs = {Turn(x, -1, 1), Turn(y, -2, 2), Turn(z, -1, 1)}});
    const int hip = static_cast<int>(joints.size()) - 1;
    joints.push_back({.name = s + "knee",
                      .parent = hip,
                      .offset_m = {0, 0, -0.4},
                      .dofs = {Turn(y, 0.05, 2.5)}});
    joints.push_back({.name = s + "ankle",
                      .parent = hip + 1,
                      .offset_m = {0, 0, -0.4},
                      .dofs = {Turn(y, -1, 1)}});
  }
  auto skeleton = core::Skeleton::Create("figure", std::move(joints));
  REQUIRE(skeleton.ok());
  return std::make_shared<core::Skeleton>(*std::move(skeleton));
}

// Markers at joints, between joints of different limbs, beyond a joint, and beside a link.
inline core::MarkerScheme FigureScheme() {
  core::MarkerScheme scheme;
  scheme.set.name = "figure";
  core::MarkerMapping mapping{"figure", {"root", "spine"}, {}};
  const auto add = [&](const std::string& name, std::vector<core::WeightedPoint> points,
                       const std::string& link = "", const Eigen::Vector3d& offset = {0, 0, 0}) {
    scheme.set.markers.push_back(name);
    mapping.rules.push_back({std::move(points), link, offset});
  };
  for (const std::string s : {"l", "r"}) {
    add(s + "Hip", {{s + "hip"}});
    add(s + "Knee", {{s + "knee"}});
    add(s + "Ankle", {{s + "ankle"}});
    add(s + "Shin", {{s + "knee", 0.5}, {s + "ankle", 0.5}}, s + "knee", {0.05, 0.05, 0});
    add(s + "Toe", {{s + "ankle"}}, s + "ankle", {0.2, 0, -0.05});
  }
  add("Belly", {{"spine", 0.6}, {"lhip", 0.2}, {"rhip", 0.2}}, "spine", {0.15, 0, 0});
  add("Back", {{"spine", -0.5}, {"neck", 1.5}}, "spine", {-0.1, 0.1, 0});
  add("Head", {{"head"}});
  add("Nose", {{"head"}}, "head", {0.15, 0, 0});
  add("Span", {{"lknee", 0.5}, {"head", 0.5}});
  scheme.set.landmarks = {0, 5, {{0, 1, 2}, {5, 6, 7}}};
  scheme.mappings.push_back(std::move(mapping));
  return scheme;
}

inline core::MarkerKinematics Kinematics(const core::MarkerScheme& scheme,
                                         std::shared_ptr<const core::Skeleton> skeleton,
                                         std::optional<double> leg_length_m = std::nullopt) {
  auto made = core::MarkerKinematics::Create(scheme, std::move(skeleton), leg_length_m);
  INFO(made.status());
  REQUIRE(made.ok());
  return *std::move(made);
}

// A robot's legs: joints of one rotation each, with limits, on a free base. At zero the legs are
// straight and the knees at their limits: a singular pose.
inline std::shared_ptr<const core::Skeleton> RobotLegs() {
  using Eigen::Vector3d;
  const Vector3d x = Vector3d::UnitX();
  const Vector3d y = Vector3d::UnitY();
  const Vector3d z = Vector3d::UnitZ();
  std::vector<core::Joint> joints = {
      {.name = "base", .dofs = {Slide(x), Slide(y), Slide(z), Turn(z), Turn(y), Turn(x)}}};
  const auto add = [&joints](const std::string& name, int parent, const Vector3d& offset,
                             std::vector<core::Dof> dofs) {
    joints.push_back({.name = name, .parent = parent, .offset_m = offset, .dofs = std::move(dofs)});
    return static_cast<int>(joints.size()) - 1;
  };
  for (const double side : {0.1, -0.1}) {
    const std::string s = side > 0 ? "l" : "r";
    int at = add(s + "hip_yaw", 0, {0, side, -0.1}, {Turn(z, -0.6, 0.6)});
    at = add(s + "hip_roll", at, {0, 0, 0}, {Turn(x, -0.5, 0.5)});
    at = add(s + "hip_pitch", at, {0, 0, 0}, {Turn(y, -1.6, 1.2)});
    at = add(s + "knee", at, {0, 0, -0.4}, {Turn(y, 0, 2.2)});
    at = add(s + "ankle", at, {0, 0, -0.4}, {Turn(y, -0.9, 0.6)});
    at = add(s + "foot_roll", at, {0, 0, -0.05}, {Turn(x, -0.4, 0.4)});
    add(s + "toe", at, {0.15, 0, 0}, {});
  }
  auto skeleton = core::Skeleton::Create("robot legs", std::move(joints));
  REQUIRE(skeleton.ok());
  return std::make_shared<core::Skeleton>(*std::move(skeleton));
}

inline core::MarkerScheme RobotScheme() {
  core::MarkerScheme scheme;
  scheme.set = {"robot", {"Pelvis"}, {1, 5, {{1, 2, 3}, {5, 6, 7}}}};
  core::MarkerMapping mapping{"robot", {"base"}, {{{{"base"}}}}};
  for (const std::string s : {"l", "r"}) {
    for (const std::string joint : {"hip_pitch", "knee", "ankle", "toe"}) {
      scheme.set.markers.push_back(s + joint);
      mapping.rules.push_back({{{s + joint}}});
    }
  }
  scheme.mappings.push_back(std::move(mapping));
  return scheme;
}

// Unrelated poses: each angle is random within its limits and at most `reach` (rad, m) from zero.
inline core::JointMotion RandomPoses(std::shared_ptr<const core::Skeleton> skeleton, int frames,
                                     double reach) {
  core::JointMotion poses{skeleton, 60, core::JointMatrix(frames, skeleton->dof_count())};
  const core::JointLimits limits = core::LimitsOf(*skeleton);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> number(0, 1);
  for (int frame = 0; frame < frames; ++frame) {
    for (int c = 0; c < skeleton->dof_count(); ++c) {
      const double lower = std::max(limits.lower[c], -reach);
      const double upper = std::min(limits.upper[c], reach);
      poses.angles(frame, c) = lower + number(random) * (upper - lower);
    }
  }
  return poses;
}

// A smooth motion within all limits. Unlimited degrees of freedom swing by up to 1.2, and the root
// also makes full turns about its first axis.
inline core::JointMotion Swing(std::shared_ptr<const core::Skeleton> skeleton, int frames,
                               double frame_rate_hz = 60) {
  core::JointMotion motion{skeleton, frame_rate_hz,
                           core::JointMatrix(frames, skeleton->dof_count())};
  std::mt19937 random(11);
  std::uniform_real_distribution<double> number(0, 1);
  int column = 0;
  for (const core::Joint& joint : skeleton->joints()) {
    for (const core::Dof& dof : joint.dofs) {
      const bool free = std::isinf(dof.lower) || std::isinf(dof.upper);
      const double middle = free ? 0 : (dof.lower + dof.upper) / 2;
      const double reach = free ? 1.2 : 0.45 * (dof.upper - dof.lower);
      const double speed = 1 + 3 * number(random);
      const double phase = 6 * number(random);
      for (int frame = 0; frame < frames; ++frame) {
        motion.angles(frame, column) =
            middle + reach * std::sin(speed * frame / frame_rate_hz + phase);
      }
      ++column;
    }
  }
  return motion;
}

inline core::MarkerMotion MarkersOf(const core::MarkerScheme& scheme,
                                    const core::JointMotion& motion,
                                    std::optional<double> leg_length_m = std::nullopt) {
  auto markers = core::ApplyScheme(scheme, motion, leg_length_m);
  INFO(markers.status());
  REQUIRE(markers.ok());
  return *std::move(markers);
}

}  // namespace motiondb::tests
