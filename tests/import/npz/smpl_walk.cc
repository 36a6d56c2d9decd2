#include "tests/import/npz/smpl_walk.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <string_view>

#include "tests/import/npz/npz_files.h"

namespace motiondb::tests {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using importer::SmplModel;

namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kPelvisHeight_m = 0.58 * 1.75;

Vector3d AxisAngle(const Matrix3d& rotation) {
  const Eigen::AngleAxisd turn(rotation);
  return turn.angle() * turn.axis();
}

}  // namespace

std::string NpzOf(const NpzArrays& arrays) {
  std::vector<ZipMember> members;
  for (const auto& [name, npy] : arrays) {
    members.push_back({.name = name + ".npy", .content = npy, .deflated = true});
  }
  return Zip(members);
}

Matrix3d Rodrigues(const Vector3d& v) {
  const double angle = v.norm();
  if (angle < 1e-12) return Matrix3d::Identity();
  const Vector3d k = v / angle;
  Matrix3d cross;
  cross << 0, -k.z(), k.y(), k.z(), 0, -k.x(), -k.y(), k.x(), 0;
  return Matrix3d::Identity() + std::sin(angle) * cross + (1 - std::cos(angle)) * cross * cross;
}

Gait SmplWalk(SmplModel model, bool z_up, double heading) {
  const auto joints = importer::SmplJoints(model);
  const auto index = [&](std::string_view name) {
    const auto found = std::find_if(joints.begin(), joints.end(),
                                    [&](const auto& joint) { return joint.name == name; });
    REQUIRE(found != joints.end());
    return static_cast<std::size_t>(found - joints.begin());
  };
  const Matrix3d stand = z_up ? Rodrigues({kPi / 2, 0, 0}) : Matrix3d(Matrix3d::Identity());
  const Matrix3d root = stand * Rodrigues({0, heading, 0});
  Gait gait;
  for (int frame = 0; frame < kGaitFrames; ++frame) {
    const double t = frame / kGaitRate_hz;
    const double swing = 0.4 * std::sin(2 * kPi * 0.9 * t);
    std::vector<Vector3d> turns(joints.size(), Vector3d::Zero());
    turns[0] = AxisAngle(root);
    turns[index("left_hip")] = {-swing, 0, 0};
    turns[index("right_hip")] = {swing, 0, 0};
    turns[index("left_knee")] = {0.4 + 0.3 * std::cos(2 * kPi * 0.9 * t), 0, 0};
    turns[index("right_knee")] = {0.4 - 0.3 * std::cos(2 * kPi * 0.9 * t), 0, 0};
    turns[index("spine2")] = {0.05, 0.1 * swing, 0.02};
    turns[index("left_shoulder")] = {0.5 * swing, 0.1, -1.2};
    turns[index("right_shoulder")] = {-0.5 * swing, -0.1, 1.2};
    turns[index("left_elbow")] = {0, -0.3 - 0.2 * swing, 0};
    turns[index("right_elbow")] = {0, 0.3 - 0.2 * swing, 0};
    for (const Vector3d& turn : turns)
      gait.poses.insert(gait.poses.end(), turn.begin(), turn.end());
    // The pelvis is at trans + the model's own pelvis.
    const Vector3d pelvis =
        root * Vector3d(0, 0, 1.2 * t) + stand * Vector3d(0, kPelvisHeight_m, 0);
    const Vector3d trans = pelvis - importer::SmplPelvis(model);
    gait.trans.insert(gait.trans.end(), trans.begin(), trans.end());
  }
  return gait;
}

std::size_t PoseColumns(SmplModel model) { return 3 * importer::SmplJoints(model).size(); }

NpzArrays AmassWalk(SmplModel model, const std::string& gender) {
  const Gait gait = SmplWalk(model, true);
  return {{"poses", Float64Npy({kGaitFrames, PoseColumns(model)}, gait.poses)},
          {"trans", Float64Npy({kGaitFrames, 3}, gait.trans)},
          {"mocap_framerate", Float64Npy({}, {kGaitRate_hz})},
          {"gender", TextNpy(gender)},
          {"betas", Float64Npy({16}, std::vector<double>(16, 0.5))},
          {"dmpls", Float64Npy({kGaitFrames, 8}, std::vector<double>(8 * kGaitFrames, 0))}};
}

}  // namespace motiondb::tests
