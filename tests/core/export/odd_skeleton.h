// Skeletons and motion that use everything a JointMotion can express.
#pragma once

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <memory>
#include <random>
#include <utility>
#include <vector>

#include "core/motion/motion.h"

namespace motiondb::tests {

// Returns motion with angles (rad) and translations (m) from -reach to reach, independent in each
// frame.
inline core::JointMotion RandomMotion(std::vector<core::Joint> joints, int frames,
                                      double frame_rate_hz, double reach) {
  auto skeleton = core::Skeleton::Create("figure", std::move(joints));
  REQUIRE(skeleton.ok());
  core::JointMotion motion = {
      std::make_shared<core::Skeleton>(*std::move(skeleton)), frame_rate_hz, {}};
  std::mt19937 random(11);
  std::uniform_real_distribution<double> value(-reach, reach);
  motion.angles = core::JointMatrix::NullaryExpr(frames, motion.skeleton->dof_count(),
                                                 [&] { return value(random); });
  return motion;
}

// Rotations before and after those of the joints, oblique axes, several and sliding joints, three
// roots (one without degrees of freedom), bones without length, names that need care.
inline std::vector<core::Joint> OddJoints() {
  using core::Dof;
  using Eigen::Vector3d;
  const Eigen::Matrix3d pre =
      Eigen::AngleAxisd(1, Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  const Eigen::Matrix3d post =
      Eigen::AngleAxisd(-2, Vector3d(3, -1, 1).normalized()).toRotationMatrix();
  const Dof x = {.axis = Vector3d::UnitX()};
  const Dof y = {.axis = Vector3d::UnitY()};
  const Dof oblique = {.axis = Vector3d(1, 1, 1).normalized()};
  const Dof along_z = {.kind = Dof::Kind::kTranslation, .axis = Vector3d::UnitZ()};
  const Dof along_xy = {.kind = Dof::Kind::kTranslation, .axis = Vector3d(1, 1, 0).normalized()};
  return {{"root", -1, {1, 2, 3}, pre, post, {along_xy, along_z, x, oblique}},
          {"a \"quoted\" \\name", 0, {0, 0.5, 0.2}, pre, pre, {y}},
          {"figure", 1, {0, 0, 0}, post, pre, {along_z, oblique, x, y}},
          {"slider", 2, {0, 0.4, 0}, pre, post, {along_xy}},
          {"tip.of:[1]", 3, {0.1, 0, 0.1}, pre, post, {}},
          {"second", -1, {-1, 0, 1}, post, post, {oblique}},
          {"l\xC3\xA4nge", 5, {0.3, 0.3, 0.3}, pre, post, {}},
          {"fixed", -1, {2, 0, 0}, pre, pre, {}}};
}

}  // namespace motiondb::tests
