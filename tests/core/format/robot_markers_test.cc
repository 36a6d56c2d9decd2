// The standard markers on robots with all joints at zero.
#include <catch2/catch.hpp>
#include <cmath>

#include "core/format/marker_set_file.h"
#include "core/format/urdf_reader.h"
#include "core/motion/marker_set.h"
#include "core/motion/states.h"
#include "tests/core/format/reading.h"
#include "tests/support/real_data.h"

namespace motiondb::tests::robot_markers_test {
namespace {

using Eigen::Vector3d;

struct Pose {
  core::MarkerMotion motion;

  Vector3d operator()(std::string_view marker) const {
    for (std::size_t m = 0; m < motion.names.size(); ++m) {
      if (motion.names[m] == marker) {
        return motion.positions_m.row(0).segment<3>(3 * static_cast<int>(m)).cast<double>();
      }
    }
    FAIL("no marker " << marker);
    return {};
  }
};

// The robot with all joints at zero, except those in `bends`.
Pose PoseOf(const core::UrdfRobot& robot,
            const std::vector<std::pair<std::string, double>>& bends) {
  core::JointMotion motion = {std::make_shared<core::Skeleton>(robot.skeleton), 60,
                              core::JointMatrix::Zero(1, robot.skeleton.dof_count())};
  for (const auto& [name, value] : bends) {
    const int joint = robot.skeleton.FindJoint(name);
    REQUIRE(joint >= 0);
    motion.angles(0, robot.skeleton.first_dof(joint)) = value;
  }
  auto markers = core::ApplyScheme(core::StandardScheme(), motion);
  INFO(MessageOf(markers.status()));
  REQUIRE(markers.ok());
  return {*std::move(markers)};
}

core::UrdfRobot Robot(const std::string& name) {
  const std::string bytes = ReadFile(DataDir() / "robots" / (name + ".urdf"));
  auto robot = core::ReadUrdf({.name = name, .bytes = bytes});
  INFO(MessageOf(robot.status()));
  REQUIRE(robot.ok());
  return *std::move(robot);
}

struct Case {
  const char* file;
  const char* mapping;
  double leg_m;     // hip, knee, ankle
  double height_m;  // top of the head above the sole
};

}  // namespace

TEST_CASE("Robot markers: a standing, symmetric body that faces x", "[core][format][data]") {
  MOTIONDB_REQUIRE_DATA();
  const Case robot = GENERATE(
      Case{"g1_29dof_rev_1_0", "unitree-g1", 0.637, 1.25}, Case{"h1", "unitree-h1", 0.8, 1.73},
      Case{"atlas_minimal_contact", "atlas", 0.799, 1.87}, Case{"jvrc1", "jvrc1", 0.749, 1.55},
      Case{"nao", "nao", 0.203, 0.52}, Case{"simple_humanoid", "simple-humanoid", 0.653, 1.45});
  CAPTURE(robot.file);
  const core::UrdfRobot read = Robot(robot.file);
  const auto mapping = core::BindMapping(core::StandardScheme(), core::JointNames(read.skeleton));
  REQUIRE(mapping.ok());
  CHECK(mapping->name == robot.mapping);
  const Pose at = PoseOf(read, {});

  // Symmetric to 1 mm, or to the file's own asymmetry.
  for (const std::string& marker : core::StandardScheme().set.markers) {
    if (marker[0] != 'L') {
      if (marker[0] != 'R') CHECK(std::abs(at(marker).y()) < 1e-3);
      continue;
    }
    CAPTURE(marker);
    const Vector3d left = at(marker);
    const Vector3d right = at('R' + marker.substr(1));
    CHECK((left - Vector3d(right.x(), -right.y(), right.z())).norm() < 1.5e-3);
    CHECK(left.y() > 0.01);
  }

  const auto above = [&](const char* high, const char* low) {
    CAPTURE(high, low);
    CHECK(at(high).z() > at(low).z());
  };
  above("HeadTop", "Head");
  above("Head", "Neck");
  above("Neck", "Spine");
  above("Spine", "Waist");
  above("Waist", "Pelvis");
  above("LHip", "LKnee");
  above("LKnee", "LAnkle");
  above("LAnkle", "LHeel");
  above("LShoulder", "Spine");
  CHECK(at("LToe").z() == Approx(at("LHeel").z()));
  CHECK(at("LToe").x() > at("LAnkle").x() + 0.1 * robot.leg_m);
  CHECK(at("LHeel").x() < at("LAnkle").x());
  CHECK((at("LHand") - at("LElbow")).norm() > (at("LWrist") - at("LElbow")).norm());

  // The leg length, computed from the markers, is the project's measure of size.
  const double leg = (at("LHip") - at("LKnee")).norm() + (at("LKnee") - at("LAnkle")).norm();
  const auto estimated = core::EstimateLegLength(core::StandardScheme().set, at.motion);
  REQUIRE(estimated.ok());
  CHECK(leg == Approx(*estimated).epsilon(1e-5));
  CHECK(leg == Approx(robot.leg_m).margin(1e-3));
  CHECK(at("HeadTop").z() - at("LHeel").z() == Approx(robot.height_m).margin(0.01));
  const auto frames = core::ReferenceFrames(core::StandardScheme().set, at.motion);
  REQUIRE(frames.ok());
  CHECK(std::abs((*frames)(0, 2)) < 1e-3);  // the front is x
}

TEST_CASE("Robot markers: H1's legs keep their length and stay below its hips",
          "[core][format][data]") {
  MOTIONDB_REQUIRE_DATA();
  const core::UrdfRobot h1 = Robot("h1");
  for (const auto& bends : std::vector<std::vector<std::pair<std::string, double>>>{
           {},
           {{"left_hip_pitch_joint", -1}, {"left_knee_joint", 1.5}},
           {{"left_hip_yaw_joint", 0.4}, {"left_hip_roll_joint", 0.3}, {"left_knee_joint", 1}}}) {
    const Pose at = PoseOf(h1, bends);
    CHECK((at("LHip") - at("LKnee")).norm() == Approx(0.4));
    CHECK((at("LKnee") - at("LAnkle")).norm() == Approx(0.4));
  }
  const Pose at = PoseOf(h1, {{"left_hip_pitch_joint", -1}, {"left_knee_joint", 1.5}});
  CHECK(at("LAnkle").y() == Approx(at("LHip").y()));
  CHECK(at("LToe").y() == Approx(at("LHip").y()));
}

TEST_CASE("Robot markers: G1's thigh keeps its length while it swings", "[core][format][data]") {
  MOTIONDB_REQUIRE_DATA();
  const core::UrdfRobot g1 = Robot("g1_29dof_rev_1_0");
  const double still = (PoseOf(g1, {})("LHip") - PoseOf(g1, {})("LKnee")).norm();
  const Pose at = PoseOf(g1, {{"left_hip_pitch_joint", -1.2}});
  CHECK((at("LHip") - at("LKnee")).norm() == Approx(still).margin(1e-4));
}

}  // namespace motiondb::tests::robot_markers_test
