// Tables of a robot's joints: round trips of WriteJointTable, and the layouts of public datasets.
#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <random>

#include "core/export/writers.h"
#include "core/format/readers.h"
#include "core/motion/forward_kinematics.h"
#include "tests/core/format/biped_table.h"
#include "tests/core/format/odd_robot.h"
#include "tests/core/format/reading.h"
#include "tests/support/real_data.h"

namespace motiondb::tests::joint_table_reader_test {
namespace {

using Catch::Contains;
using core::JointMotion;
using core::Provenance;
using core::ReadOptions;
using core::UpAxis;
using core::UrdfRobot;

constexpr double kDegree = std::numbers::pi / 180;

// Values of at most `range`, if `within_limits` also within the limits of the joints.
JointMotion RandomMotion(const UrdfRobot& robot, int frames, double range, bool within_limits) {
  JointMotion motion = {std::make_shared<core::Skeleton>(robot.skeleton), 50, {}};
  motion.angles.resize(frames, robot.skeleton.dof_count());
  std::mt19937 random(5);
  std::uniform_real_distribution<double> value(-range, range);
  int column = 0;
  for (const core::Joint& joint : robot.skeleton.joints()) {
    for (const core::Dof& dof : joint.dofs) {
      for (int t = 0; t < frames; ++t) {
        const double any = value(random);
        motion.angles(t, column) = within_limits ? std::clamp(any, dof.lower, dof.upper) : any;
      }
      ++column;
    }
  }
  return motion;
}

double MaxDistance(const JointMotion& a, const JointMotion& b) {
  REQUIRE(a.angles.rows() == b.angles.rows());
  double distance = 0;
  for (Eigen::Index t = 0; t < a.angles.rows(); ++t) {
    const auto left = core::ForwardKinematics(*a.skeleton, a.angles.row(t));
    const auto right = core::ForwardKinematics(*b.skeleton, b.angles.row(t));
    for (std::size_t j = 0; j < left.size(); ++j) {
      distance = std::max(distance, (left[j].matrix() - right[j].matrix()).cwiseAbs().maxCoeff());
    }
  }
  return distance;
}

void CheckRoundTrip(std::string_view urdf, double range, bool within_limits) {
  const UrdfRobot robot = GoodRobot(urdf);
  const JointMotion motion = RandomMotion(robot, 20, range, within_limits);
  const auto text = core::WriteJointTable(motion, robot.mimics);
  REQUIRE(text.ok());
  const auto file = ReadTable(*text, urdf);
  const JointMotion& read = Joints(file);
  CHECK(read.frame_rate_hz == 50);
  CHECK(MaxDistance(motion, read) < 1e-9);
  CHECK(read.angles.rightCols(read.angles.cols() - 6) ==
        motion.angles.rightCols(motion.angles.cols() - 6));
  CHECK_THAT(NotesOfTable(file), Contains("unit 1 m (stated), z up (stated)") &&
                                     Contains("joint angles in radians (stated)") &&
                                     !Contains("differs from its master"));
}

struct Layout {
  double per_metre = 1;
  double per_radian = 1;
  bool scalar_first = false;
};

// A walk of the biped that turns once about itself: root, then the joints in the file's order.
std::string PlainWalk(const Layout& layout) {
  std::string text;
  for (int t = 0; t < 60; ++t) {
    const double half_yaw = t * std::numbers::pi / 60;
    const double swing = 0.6 * std::sin(0.3 * t);
    const double z = 0.03 + 0.4 * std::cos(swing) + 0.4;
    text += fmt::format("{},{},{},", 0.02 * t * layout.per_metre, 0.5 * layout.per_metre,
                        z * layout.per_metre);
    text += layout.scalar_first ? fmt::format("{},0,0,{},", std::cos(half_yaw), std::sin(half_yaw))
                                : fmt::format("0,0,{},{},", std::sin(half_yaw), std::cos(half_yaw));
    text +=
        fmt::format("{},{},{},{}\n", swing * layout.per_radian, -swing * layout.per_radian,
                    (0.4 + 0.3 * std::cos(0.3 * t)) * layout.per_radian, 0.25 * layout.per_radian);
  }
  return text;
}

}  // namespace

TEST_CASE("ReadJointTable: what WriteJointTable writes", "[core][format]") {
  CheckRoundTrip(kRobot, 3, false);
  CheckRoundTrip(kBiped, 3, false);
  CheckRoundTrip(kBiped, 1, true);
}

TEST_CASE("ReadJointTable: what WriteJointTable writes of real robots", "[core][format][data]") {
  MOTIONDB_REQUIRE_DATA();
  for (const char* name :
       {"g1_29dof_rev_1_0", "h1", "atlas_minimal_contact", "jvrc1", "nao", "simple_humanoid"}) {
    CAPTURE(name);
    const std::string urdf = ReadFile(DataDir() / "robots" / (std::string(name) + ".urdf"));
    CheckRoundTrip(urdf, 3, false);
    CheckRoundTrip(urdf, 1, true);
  }
}

TEST_CASE("ReadJointTable: yaw is continuous through full turns", "[core][format]") {
  const UrdfRobot robot = GoodRobot(kBiped);
  JointMotion motion = RandomMotion(robot, 300, 1, true);
  motion.angles.setZero();
  for (int t = 0; t < 300; ++t) motion.angles(t, 3) = 0.05 * t;
  const auto text = core::WriteJointTable(motion, {});
  REQUIRE(text.ok());
  CHECK((Joints(ReadTable(*text)).angles - motion.angles).cwiseAbs().maxCoeff() < 1e-12);
}

TEST_CASE("ReadJointTable: a table without header, in all units", "[core][format]") {
  const auto expected = ReadTable(PlainWalk({}));
  const JointMotion& walk = Joints(expected);
  CHECK(walk.frame_rate_hz == 30);
  CHECK_THAT(NotesOfTable(expected), Contains("unit 1 m (deduced), z up (assumed)") &&
                                         Contains("joint angles in radians (deduced)") &&
                                         Contains("frame rate 30 Hz (assumed)") &&
                                         Contains("in the order of the joints in the URDF file") &&
                                         !Contains("w x y z") && !Contains("limits"));
  // In the skeleton's order: both joints of the left leg, then those of the right leg.
  const Eigen::RowVectorXd last = walk.angles.row(59);
  const double swing = 0.6 * std::sin(0.3 * 59);
  CHECK(last.head(3).isApprox(Eigen::RowVector3d(1.18, 0.5, 0.43 + 0.4 * std::cos(swing))));
  CHECK(last[3] == Approx(2 * std::numbers::pi * 59 / 60));
  CHECK(last[6] == Approx(swing));
  CHECK(last[7] == Approx(0.4 + 0.3 * std::cos(0.3 * 59)));
  CHECK(last[8] == Approx(-swing));
  CHECK(last[9] == Approx(0.25));
  for (const double per_metre : {1.0, 100.0, 1000.0}) {
    for (const double per_radian : {1.0, 1 / kDegree}) {
      for (const bool scalar_first : {false, true}) {
        CAPTURE(per_metre, per_radian, scalar_first);
        const auto file = ReadTable(PlainWalk({per_metre, per_radian, scalar_first}));
        CHECK(MaxDistance(walk, Joints(file)) < 1e-9);
        CHECK_THAT(NotesOfTable(file), Contains(per_radian > 1 ? "degrees (deduced)" : "radians"));
        CHECK((NotesOfTable(file).find("w x y z") != std::string::npos) == scalar_first);
      }
    }
  }
  const auto given =
      ReadTable(PlainWalk({}), kBiped,
                {.metres_per_unit = 0.5, .up_axis = UpAxis::kY, .frame_rate_hz = 60, .take = {}});
  CHECK(Joints(given).frame_rate_hz == 60);
  CHECK(given->report.unit_provenance == Provenance::kGiven);
  const Eigen::RowVectorXd first = Joints(given).angles.row(0);
  CHECK(first.head(3).isApprox(Eigen::RowVector3d(0, -0.415, 0.25)));
  CHECK(first[5] == Approx(std::numbers::pi / 2));  // rolled: the file's y is up
}

TEST_CASE("ReadJointTable: LAFAN1 retargeting dataset on G1", "[core][format][data]") {
  MOTIONDB_REQUIRE_DATA();
  const std::string urdf = ReadFile(DataDir() / "robots" / "g1_29dof_rev_1_0.urdf");
  const UrdfRobot robot = GoodRobot(urdf);
  JointMotion motion = RandomMotion(robot, 30, 0.7, true);
  motion.angles.col(2).array() = 0.78;
  motion.frame_rate_hz = 30;
  // The dataset's order of joints.
  std::vector<std::string> joints;
  for (const std::string side : {"left", "right"}) {
    for (const char* part :
         {"hip_pitch", "hip_roll", "hip_yaw", "knee", "ankle_pitch", "ankle_roll"}) {
      joints.push_back(fmt::format("{}_{}_joint", side, part));
    }
  }
  for (const char* part : {"yaw", "roll", "pitch"}) {
    joints.push_back(fmt::format("waist_{}_joint", part));
  }
  for (const std::string side : {"left", "right"}) {
    for (const char* part : {"shoulder_pitch", "shoulder_roll", "shoulder_yaw", "elbow",
                             "wrist_roll", "wrist_pitch", "wrist_yaw"}) {
      joints.push_back(fmt::format("{}_{}_joint", side, part));
    }
  }
  std::string text;
  for (Eigen::Index t = 0; t < motion.angles.rows(); ++t) {
    const auto pose = core::ForwardKinematics(robot.skeleton, motion.angles.row(t))[0];
    const Eigen::Quaterniond turn(pose.linear());
    text += fmt::format("{},{},{},{},{},{},{}", pose.translation().x(), pose.translation().y(),
                        pose.translation().z(), turn.x(), turn.y(), turn.z(), turn.w());
    for (const std::string& joint : joints) {
      const int index = robot.skeleton.FindJoint(joint);
      REQUIRE(index > 0);
      text += fmt::format(",{}", motion.angles(t, robot.skeleton.first_dof(index)));
    }
    text += "\n";
  }
  const auto file = ReadTable(text, urdf);
  CHECK(Joints(file).frame_rate_hz == 30);
  CHECK(MaxDistance(Joints(file), motion) < 1e-9);
  CHECK_THAT(NotesOfTable(file),
             Contains("unit 1 m (deduced)") && !Contains("order of the joints"));
  CHECK_THAT(ErrorMessageOf(ReadTable(text, kBiped)),
             Contains("walk.csv:1: expected 11 numbers") && Contains("found 36"));
}

TEST_CASE("ReadJointTable: BONES-SEED", "[core][format]") {
  const std::string header =
      "Frame,root_translateX,root_translateY,root_translateZ,root_rotateX,root_rotateY,"
      "root_rotateZ,l_hip_dof,r_hip_dof,l_knee_dof,r_knee_dof\n";
  const auto file = ReadTable(header +
                              "0,100,-50,85,10,20,30,-20,15,40,30\n"
                              "1,101,-50,85,10,20,179,-20,15,40,30\n"
                              "2,102,-50,85,10,20,-179,-20,15,40,30\n");
  const JointMotion& motion = Joints(file);
  CHECK(motion.frame_rate_hz == 120);
  CHECK_THAT(NotesOfTable(file), Contains("unit 0.01 m (deduced)") &&
                                     Contains("degrees (deduced)") &&
                                     Contains("frame rate 120 Hz (assumed)"));
  const auto pose = core::ForwardKinematics(*motion.skeleton, motion.angles.row(0))[0];
  CHECK(pose.translation().isApprox(Eigen::Vector3d(1, -0.5, 0.85)));
  // Extrinsic x, y, z: about the fixed axes, x first.
  const Eigen::Matrix3d turn = (Eigen::AngleAxisd(30 * kDegree, Eigen::Vector3d::UnitZ()) *
                                Eigen::AngleAxisd(20 * kDegree, Eigen::Vector3d::UnitY()) *
                                Eigen::AngleAxisd(10 * kDegree, Eigen::Vector3d::UnitX()))
                                   .toRotationMatrix();
  CHECK((pose.linear() - turn).norm() < 1e-12);
  CHECK(motion.angles(2, 3) == Approx(181 * kDegree));
  const auto angle = [&](const char* joint) {
    const int index = motion.skeleton->FindJoint(joint);
    return motion.angles(0, motion.skeleton->first_dof(index));
  };
  CHECK(angle("l_hip") == Approx(-20 * kDegree));
  CHECK(angle("r_hip") == Approx(15 * kDegree));
  CHECK(angle("r_knee") == Approx(30 * kDegree));
  // Nothing to deduce: the layout's units.
  const std::string zero = "0,0,0,0,0,0,0,0,0,0,0\n";
  CHECK_THAT(NotesOfTable(ReadTable(header + zero)),
             Contains("unit 0.01 m (assumed)") && Contains("degrees (assumed)"));
  const std::string in_radians = "0,1,-0.5,0.85,0.1,0.2,3,-0.3,0.3,0.7,0.5\n";
  CHECK_THAT(NotesOfTable(ReadTable(header + in_radians)),
             Contains("unit 1 m (deduced)") && Contains("radians (deduced)"));
  CHECK_THAT(ErrorMessageOf(ReadTable(header + zero + "2,0,0,0,0,0,0,0,0,0,0\n")),
             Contains("walk.csv:3: expected frame 1, found 2"));
}

TEST_CASE("ReadJointTable: units in the header, and angles that must be degrees",
          "[core][format]") {
  const std::string stated =
      Replaced(Replaced(TableWith("l_knee,", "l_knee_deg,"), "r_hip,", "r_hip_rad,"),
               "root_x_m,root_y_m,root_z_m", "root_x_cm,root_y_cm,root_z_cm");
  const auto file = ReadTable(stated);
  CHECK(Joints(file).angles(0, 7) == Approx(0.2 * kDegree));
  CHECK(Joints(file).angles(0, 8) == 0.3);
  CHECK(Joints(file).angles(0, 2) == Approx(0.008));
  CHECK_THAT(NotesOfTable(file), Contains("unit 0.01 m (stated)") &&
                                     Contains("joint angles in the units of the header (stated)"));
  CHECK_THAT(ErrorMessageOf(ReadTable(TableWith("root_y_m", "root_y_cm"))),
             Contains("walk.csv:1: expected one unit"));
  // 40 degrees: more than a full turn beyond the knee's limits as radians.
  const auto degrees = ReadTable(TableWith("0.1,0.2,0.3,0.4", "0.1,0.2,0.3,40"));
  CHECK(Joints(degrees).angles(0, 9) == Approx(40 * kDegree));
  CHECK_THAT(NotesOfTable(degrees), Contains("joint angles in degrees (deduced)"));
}

TEST_CASE("ReadJointTable: values outside of limits are reported", "[core][format]") {
  CHECK_THAT(NotesOfTable(ReadTable(kTable)), !Contains("limits"));
  CHECK_THAT(NotesOfTable(ReadTable(TableWith("0.1,0.2,0.3,0.4", "0.1,0.2,-2.5,2.75"))),
             Contains("2 values of 2 joints are outside of their limits, the farthest by 0.5 "
                      "('r_hip')"));
}

TEST_CASE("ReadJointTable: a mimic joint may differ from its master, or be absent",
          "[core][format]") {
  const UrdfRobot robot = GoodRobot(kRobot);
  const JointMotion motion = RandomMotion(robot, 5, 1, true);
  const auto other = core::WriteJointTable(
      motion,
      std::vector<core::MimicJoint>{{"finger", "elbow", 2, 0.5}, {"thumb", "elbow", -6, 0.25}});
  REQUIRE(other.ok());
  const auto differs = ReadTable(*other, kRobot);
  CHECK_THAT(NotesOfTable(differs),
             Contains("mimic joint 'finger' differs from its master's value by up to 0.25"));
  CHECK(MaxDistance(Joints(differs), motion) < 1e-9);
  const auto absent = core::WriteJointTable(motion, {});
  REQUIRE(absent.ok());
  CHECK(MaxDistance(Joints(ReadTable(*absent, kRobot)), motion) < 1e-9);
}

}  // namespace motiondb::tests::joint_table_reader_test
