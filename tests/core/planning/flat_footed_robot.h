// A robot with a walker's legs in other proportions and flat soles, for planning on skeletons.
#pragma once

#include <catch2/catch.hpp>
#include <memory>
#include <string>
#include <vector>

#include "core/motion/marker_set.h"
#include "tests/core/planning/walking_figure.h"

namespace motiondb::tests {

inline constexpr double kRobotLeg_m = 0.5;     // thigh plus shin
inline constexpr double kRobotAnkle_m = 0.04;  // height of the ankles above the soles

// `hip_turn`: limit (rad) of each leg's turn to the left and right.
inline std::shared_ptr<const core::Skeleton> FlatFootedRobot(double hip_turn = 0.8) {
  using Eigen::Vector3d;
  const auto turn = [](const Vector3d& axis, double lower, double upper) {
    return core::Dof{core::Dof::Kind::kRotation, axis, lower, upper};
  };
  std::vector<core::Joint> joints;
  core::Joint base{.name = "base"};
  for (int axis = 0; axis < 3; ++axis) {
    base.dofs.push_back({core::Dof::Kind::kTranslation, Vector3d::Unit(axis)});
  }
  for (const int axis : {2, 1, 0}) {
    base.dofs.push_back({core::Dof::Kind::kRotation, Vector3d::Unit(axis)});
  }
  joints.push_back(base);
  joints.push_back({.name = "head", .parent = 0, .offset_m = {0, 0, 0.45}});
  for (const double side : {1.0, -1.0}) {
    const std::string name = side > 0 ? "left" : "right";
    const auto add = [&](const std::string& part, int parent, const Vector3d& offset,
                         std::vector<core::Dof> dofs) {
      joints.push_back(
          {.name = name + part, .parent = parent, .offset_m = offset, .dofs = std::move(dofs)});
      return static_cast<int>(joints.size()) - 1;
    };
    const int hip = add("_hip", 0, {0, 0.07 * side, 0},
                        {turn(Vector3d::UnitZ(), -hip_turn, hip_turn),
                         turn(Vector3d::UnitX(), -0.5, 0.5), turn(Vector3d::UnitY(), -1.5, 0.8)});
    const int knee = add("_knee", hip, {0, 0, -0.27}, {turn(Vector3d::UnitY(), 0, 2.2)});
    add("_ankle", knee, {0, 0, -0.23},
        {turn(Vector3d::UnitY(), -1, 1), turn(Vector3d::UnitX(), -0.4, 0.4)});
  }
  auto skeleton = core::Skeleton::Create("robot", std::move(joints));
  INFO(skeleton.status());
  REQUIRE(skeleton.ok());
  return std::make_shared<core::Skeleton>(*std::move(skeleton));
}

// The walker's markers on that robot.
inline core::MarkerScheme RobotScheme() {
  core::MarkerScheme scheme{.set = WalkerSet(),
                            .mappings = {{.name = "robot", .signature = {"base", "head"}}}};
  std::vector<core::MarkerRule>& rules = scheme.mappings.front().rules;
  rules.push_back({.points = {{"head"}}});
  for (const std::string side : {"left", "right"}) {
    const std::string hip = side + "_hip";
    const std::string knee = side + "_knee";
    const std::string ankle = side + "_ankle";
    rules.push_back({.points = {{hip}}});
    rules.push_back({.points = {{hip, 0.5}, {knee, 0.5}}});
    rules.push_back({.points = {{knee}}});
    rules.push_back({.points = {{knee, 0.5}, {ankle, 0.5}}});
    rules.push_back({.points = {{ankle}}});
    const double down = -kRobotAnkle_m / kRobotLeg_m;
    rules.push_back({{{ankle}}, ankle, {-0.08, 0, down}});
    rules.push_back({{{ankle}}, ankle, {0.2, 0, down}});
  }
  return scheme;
}

}  // namespace motiondb::tests
