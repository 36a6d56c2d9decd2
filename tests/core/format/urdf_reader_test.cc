#include "core/format/urdf_reader.h"

#include <fmt/format.h>

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>

#include "core/format/asf_file.h"
#include "core/motion/forward_kinematics.h"
#include "tests/core/format/odd_robot.h"
#include "tests/support/compressed.h"
#include "tests/support/real_data.h"

namespace motiondb::tests::urdf_reader_test {
namespace {

using Catch::Contains;
using core::Dof;
using core::Joint;
using core::UrdfRobot;
using Eigen::Vector3d;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

const Joint& JointNamed(const UrdfRobot& robot, std::string_view name) {
  const int at = robot.skeleton.FindJoint(name);
  REQUIRE(at >= 0);
  return robot.skeleton.joints()[at];
}

std::string Chain(int links) {
  std::string text = "<robot name='chain'><link name='l0'/>";
  for (int i = 1; i < links; ++i) {
    text += fmt::format(
        "<link name='l{0}'/><joint name='j{0}' type='fixed'>"
        "<parent link='l{1}'/><child link='l{0}'/></joint>",
        i, i - 1);
  }
  return text + "</robot>";
}

}  // namespace

TEST_CASE("ReadUrdf: joints in depth-first order under a floating base", "[core][format]") {
  const UrdfRobot robot = GoodRobot(kRobot);
  CHECK(robot.skeleton.name() == "odd");
  std::vector<std::string> names;
  std::vector<int> parents;
  for (const Joint& joint : robot.skeleton.joints()) {
    names.push_back(joint.name);
    parents.push_back(joint.parent);
  }
  CHECK(names == std::vector<std::string>{"base", "shoulder", "elbow", "slide", "finger",
                                          "tip_joint", "thumb", "puck", "kite"});
  CHECK(parents == std::vector<int>{-1, 0, 1, 2, 3, 4, 3, 0, 0});
  CHECK(robot.skeleton.dof_count() == 6 + 1 + 1 + 1 + 3 + 6);

  const std::vector<Dof>& base = robot.skeleton.joints()[0].dofs;
  const std::array<Vector3d, 6> axes = {Vector3d::UnitX(), Vector3d::UnitY(), Vector3d::UnitZ(),
                                        Vector3d::UnitZ(), Vector3d::UnitY(), Vector3d::UnitX()};
  for (int k = 0; k < 6; ++k) {
    CHECK(base[k].axis == axes[k]);
    CHECK(base[k].kind == (k < 3 ? Dof::Kind::kTranslation : Dof::Kind::kRotation));
    CHECK(base[k].upper == kInfinity);
  }
  CHECK_THAT(core::Describe(robot.report),
             Contains("unit 1 m (stated), z up (stated)") && Contains("finger, thumb"));
}

TEST_CASE("ReadUrdf: axes, limits and origins", "[core][format]") {
  const UrdfRobot robot = GoodRobot(kRobot);
  const Dof& shoulder = JointNamed(robot, "shoulder").dofs[0];
  CHECK(shoulder.axis == Vector3d::UnitX());  // the default axis
  CHECK(shoulder.lower == -kInfinity);
  CHECK(shoulder.upper == kInfinity);
  const Joint& elbow = JointNamed(robot, "elbow");
  CHECK(elbow.dofs[0].axis == Vector3d::UnitY());
  CHECK(elbow.dofs[0].lower == -0.5);
  CHECK(elbow.dofs[0].upper == 2);
  CHECK((elbow.pre_rotation * Vector3d::UnitX() - Vector3d::UnitY()).norm() < 1e-15);
  // The rail slides along its own z axis, which its origin rotates to the parent's x.
  CHECK((JointNamed(robot, "slide").dofs[0].axis - Vector3d::UnitX()).norm() < 1e-15);
  // The puck slides in the plane normal to its axis and rotates about it.
  const std::vector<Dof>& puck = JointNamed(robot, "puck").dofs;
  REQUIRE(puck.size() == 3);
  CHECK((puck[0].axis.cross(puck[1].axis) - puck[2].axis).norm() < 1e-15);
  CHECK(puck[2].axis == -Vector3d::UnitZ());
}

TEST_CASE("ReadUrdf: speeds, efforts and masses", "[core][format]") {
  const UrdfRobot robot = GoodRobot(R"(<robot name="r">
    <link name="base"><inertial><mass value="3"/></inertial></link>
    <link name="arm"><inertial>
      <origin xyz="1 2 3" rpy="0 0 1.5707963267948966"/><mass value="2"/>
      <inertia ixx="1" ixy="0.1" ixz="0.2" iyy="4" iyz="0.3" izz="5"/>
    </inertial></link>
    <link name="hand"/><link name="wheel"/><link name="finger"/>
    <joint name="shoulder" type="revolute"><parent link="base"/><child link="arm"/>
      <limit lower="-1" upper="1" velocity="6" effort="30"/></joint>
    <joint name="wrist" type="fixed"><parent link="arm"/><child link="hand"/>
      <limit velocity="1" effort="1"/></joint>
    <joint name="spin" type="continuous"><parent link="hand"/><child link="wheel"/>
      <limit velocity="0" effort="7"/></joint>
    <joint name="grip" type="prismatic"><parent link="hand"/><child link="finger"/>
      <limit lower="0" upper="1" velocity="2"/><mimic joint="shoulder" multiplier="-0.5"/></joint>
  </robot>)");
  const core::RobotDynamics& dynamics = robot.dynamics;
  REQUIRE(robot.skeleton.dof_count() == 6 + 2);
  REQUIRE(dynamics.max_speeds.size() == 8);
  REQUIRE(dynamics.links.size() == 5);
  CHECK(dynamics.max_speeds[5] == kInfinity);  // of the base
  CHECK(dynamics.max_speeds[6] == 4);          // of the joint that mimics half of it
  CHECK(dynamics.max_speeds[7] == kInfinity);  // 0: not given
  CHECK(dynamics.max_efforts[6] == 30);
  CHECK(dynamics.max_efforts[7] == 7);
  CHECK(dynamics.has_masses());
  CHECK(dynamics.links[0].mass_kg == 3);
  CHECK(dynamics.links[0].inertia_kg_m2.norm() == 0);
  const core::LinkInertia& arm = dynamics.links[robot.skeleton.FindJoint("shoulder")];
  CHECK(arm.mass_kg == 2);
  CHECK(arm.centre_m == Vector3d(1, 2, 3));
  // A quarter turn about z.
  Eigen::Matrix3d expected;
  expected << 4, -0.1, -0.3, -0.1, 1, 0.2, -0.3, 0.2, 5;
  CHECK((arm.inertia_kg_m2 - expected).norm() < 1e-12);
  CHECK(dynamics.links[robot.skeleton.FindJoint("wrist")].mass_kg == 0);
  CHECK_FALSE(GoodRobot("<robot><link name='a'/></robot>").dynamics.has_masses());
}

TEST_CASE("ReadUrdf: roll, pitch and yaw are about fixed axes, in that order", "[core][format]") {
  const UrdfRobot robot = GoodRobot(
      "<robot><link name='a'/><link name='b'/><joint name='j' type='fixed'><parent link='a'/>"
      "<child link='b'/><origin rpy='0.1 0.2 0.3'/></joint></robot>");
  const Eigen::Matrix3d expected =
      (Eigen::AngleAxisd(0.3, Vector3d::UnitZ()) * Eigen::AngleAxisd(0.2, Vector3d::UnitY()) *
       Eigen::AngleAxisd(0.1, Vector3d::UnitX()))
          .toRotationMatrix();
  CHECK((robot.skeleton.joints()[1].pre_rotation - expected).norm() < 1e-15);
  CHECK(robot.skeleton.name() == "robot");
}

TEST_CASE("ReadUrdf: forward kinematics of a bent arm", "[core][format]") {
  const UrdfRobot robot = GoodRobot(kRobot);
  Eigen::RowVectorXd q = Eigen::RowVectorXd::Zero(robot.skeleton.dof_count());
  const auto set = [&](std::string_view name, double value) {
    q[robot.skeleton.first_dof(robot.skeleton.FindJoint(name))] = value;
  };
  set("shoulder", std::numbers::pi / 2);  // the hanging upper arm swings to the left
  set("slide", 0.1);
  q[0] = 5;                     // the base
  q[3] = std::numbers::pi / 2;  // rotated to the left
  const auto pose = core::ForwardKinematics(robot.skeleton, q);
  const auto at = [&](std::string_view name) -> Vector3d {
    return pose[robot.skeleton.FindJoint(name)].translation();
  };
  // In the base: shoulder (0, 0.2, 0.4), elbow (0, 0.5, 0.4). The lower arm's x is the upper arm's
  // y and points up; the rail is 1.1 m along it.
  CHECK((at("elbow") - Vector3d(5 - 0.5, 0, 0.4)).norm() < 1e-12);
  CHECK((at("slide") - Vector3d(5 - 0.5, 0, 1.5)).norm() < 1e-12);
}

TEST_CASE(
    "ReadUrdf: mimic joints are zero at their offset and refer to the first master of a chain",
    "[core][format]") {
  const UrdfRobot robot = GoodRobot(kRobot);
  REQUIRE(robot.mimics.size() == 2);
  CHECK(robot.mimics[0].joint == "finger");
  CHECK(robot.mimics[0].master == "elbow");
  CHECK(robot.mimics[0].multiplier == 2);
  CHECK(robot.mimics[0].offset == 0.25);
  CHECK(robot.mimics[1].joint == "thumb");
  CHECK(robot.mimics[1].master == "elbow");
  CHECK(robot.mimics[1].multiplier == -6);
  CHECK(robot.mimics[1].offset == 1 - 3 * 0.25);
  const Joint& finger = JointNamed(robot, "finger");
  CHECK(finger.dofs.empty());
  CHECK((finger.pre_rotation * Vector3d::UnitX() - Vector3d(std::cos(0.25), std::sin(0.25), 0))
            .norm() < 1e-15);
  CHECK((JointNamed(robot, "thumb").offset_m - Vector3d(0, 0.25, 0)).norm() < 1e-15);

  CHECK_THAT(ErrorMessageWith("joint=\"elbow\" mult", "joint=\"thumb\" mult"), Contains("cycle"));
  CHECK_THAT(ErrorMessageWith("joint=\"elbow\" mult", "joint=\"finger\" mult"), Contains("cycle"));
  for (const char* master : {"nobody", "puck", "tip_joint"}) {
    CHECK_THAT(ErrorMessageWith("joint=\"elbow\" mult", fmt::format("joint=\"{}\" mult", master)),
               Contains("robot.urdf:") && Contains(master));
  }
  CHECK_THAT(ErrorMessageWith("multiplier=\"2\"", "multiplier=\"inf\""), Contains("multiplier"));
}

TEST_CASE("ReadUrdf: a root link with one floating joint is the world", "[core][format]") {
  const UrdfRobot robot = GoodRobot(
      "<robot><link name='world'/><link name='body'/><link name='leg'/>"
      "<joint name='free' type='floating'><parent link='world'/><child link='body'/>"
      "<origin xyz='0 0 1'/></joint>"
      "<joint name='hip' type='fixed'><parent link='body'/><child link='leg'/></joint></robot>");
  REQUIRE(robot.skeleton.joint_count() == 2);
  CHECK(robot.skeleton.joints()[0].name == "body");
  CHECK(robot.skeleton.joints()[0].offset_m == Vector3d::UnitZ());
  CHECK(robot.skeleton.dof_count() == 6);
  CHECK_THAT(core::Describe(robot.report), Contains("'world'"));
}

TEST_CASE("ReadUrdf: a joint may have the name of the root link", "[core][format]") {
  const UrdfRobot robot = GoodRobot(
      "<robot><link name='hip'/><link name='leg'/><joint name='hip' type='fixed'>"
      "<parent link='hip'/><child link='leg'/></joint></robot>");
  CHECK(robot.skeleton.joints()[0].name == "hip_2");
  CHECK(robot.skeleton.joints()[1].name == "hip");
  CHECK_THAT(core::Describe(robot.report), Contains("'hip_2'"));
}

TEST_CASE("ReadUrdf: a robot may have one link, or a chain of the maximum length",
          "[core][format]") {
  CHECK(GoodRobot("<robot><link name='a'/></robot>").skeleton.joint_count() == 1);
  CHECK(GoodRobot(Chain(2000)).skeleton.joint_count() == 2000);
}

TEST_CASE("ReadUrdf: the number of moving joints is limited", "[core][format]") {
  std::string chain = Chain(400);
  for (std::size_t at = 0; (at = chain.find("'fixed'", at)) != std::string::npos;) {
    chain.replace(at, 7, "'continuous'");
  }
  CHECK_THAT(ErrorMessageOf(ReadRobot(chain)),
             Contains("at most 300 degrees of freedom, found 405"));
}

TEST_CASE("ReadUrdf: links and joints must form a tree", "[core][format]") {
  CHECK_THAT(ErrorMessageOf(ReadRobot("<robot/>")), Contains("expected at least one <link>"));
  CHECK_THAT(ErrorMessageWith("<child link=\"rail\"/>", "<child link=\"rial\"/>"),
             Contains("robot.urdf:26: joint 'slide': expected the name of a link, found 'rial'"));
  CHECK_THAT(ErrorMessageWith("<parent link=\"rail\"/>", "<parent link=\"rial\"/>"),
             Contains("robot.urdf:33: joint 'finger': expected the name of a link, found 'rial'"));
  CHECK_THAT(ErrorMessageWith("<link name=\"tip\"/>", "<link name=\"rail\"/>"),
             Contains("links of different names, found 'rail' twice"));
  CHECK_THAT(ErrorMessageWith("name=\"puck\" type", "name=\"elbow\" type"),
             Contains("joints of different names, found 'elbow' twice"));
  CHECK_THAT(ErrorMessageWith("<child link=\"tip\"/>", "<child link=\"thumb\"/>"),
             Contains("'thumb' to be the child of one joint"));
  CHECK_THAT(ErrorMessageWith("<link name=\"tip\"/>", "<link name=\"tip\"/><link name=\"loose\"/>"),
             Contains("expected one link without a joint above it, found 'base' and 'loose'"));
  CHECK_THAT(ErrorMessageOf(ReadRobot(
                 "<robot><link name='a'/><link name='b'/>"
                 "<joint name='j' type='fixed'><parent link='a'/><child link='b'/></joint>"
                 "<joint name='k' type='fixed'><parent link='b'/><child link='a'/></joint>"
                 "</robot>")),
             Contains("cycle"));
  CHECK_THAT(ErrorMessageOf(ReadRobot(
                 "<robot><link name='r'/><link name='a'/>"
                 "<joint name='j' type='fixed'><parent link='a'/><child link='a'/></joint>"
                 "</robot>")),
             Contains("joint 'j' in a cycle"));
}

TEST_CASE("ReadUrdf: robots of several makers", "[core][format][data]") {
  MOTIONDB_REQUIRE_DATA();
  struct Expected {
    int joints;
    int moving;  // joints without the base and mimic joints
    int mimics;
    const char* base;
    const char* limited;  // a joint; its limits follow
    double lower;
    double upper;
  };
  const std::map<std::string, Expected> robots = {
      {"atlas_minimal_contact", {60, 30, 0, "pelvis", "l_leg_kny", 0, 2.35637}},
      {"g1_29dof_rev_1_0", {39, 29, 0, "pelvis", "left_knee_joint", -0.087267, 2.8798}},
      {"h1", {25, 19, 0, "pelvis", "left_knee_joint", -0.26, 2.05}},
      {"jvrc1", {60, 34, 10, "base_link", "L_KNEE", 0, 2.61799387799}},
      {"nao", {79, 25, 17, "base_link", "LKneePitch", -0.0923279, 2.11255}},
      {"simple_humanoid", {31, 29, 0, "base_link", "RLEG_KNEE", 0, 2.618}}};
  for (const auto& [name, expected] : robots) {
    CAPTURE(name);
    const std::string bytes = ReadFile(DataDir() / "robots" / (name + ".urdf"));
    const UrdfRobot robot = GoodRobot(bytes);
    const core::Skeleton& skeleton = robot.skeleton;
    CHECK(skeleton.joint_count() == expected.joints);
    CHECK(skeleton.dof_count() == 6 + expected.moving);
    CHECK(static_cast<int>(robot.mimics.size()) == expected.mimics);
    CHECK(skeleton.joints()[0].name == expected.base);
    for (int j = 1; j < skeleton.joint_count(); ++j) {
      for (const Dof& dof : skeleton.joints()[j].dofs) {
        CHECK(dof.kind == Dof::Kind::kRotation);
        CHECK(std::isfinite(dof.upper));
      }
    }
    const Dof& limited = JointNamed(robot, expected.limited).dofs.at(0);
    CHECK(limited.lower == expected.lower);
    CHECK(limited.upper == expected.upper);
  }
}

TEST_CASE("ReadUrdf, ReadAsf: files that are compressed with gzip", "[core][format]") {
  const UrdfRobot robot = GoodRobot(Compressed(std::string(kRobot)));
  CHECK(robot.skeleton.joint_count() == GoodRobot(kRobot).skeleton.joint_count());
  const auto refusal = [](const std::string& bytes) { return ErrorMessageOf(ReadRobot(bytes)); };
  // A bomb, a file that is cut, and the position of an error in the content.
  CHECK_THAT(refusal(Compressed(std::string(5 << 20, ' '))),
             Contains("robot.urdf: byte ") && Contains("more than 4194304 decompressed bytes"));
  CHECK_THAT(refusal(Compressed(std::string(kRobot)).substr(0, 100)), Contains("truncated?"));
  CHECK_THAT(refusal(Compressed("\n<robt/>")), Contains("robot.urdf:2: expected <robot>"));
  // Memory is reserved for the content, not for the largest one.
  const std::string csv = "time_s\n0\n";
  const auto reserved = [&](const std::string& urdf) {
    return core::MaxBytesToRead(core::FileFormat::kCsv, {"a.csv", csv},
                                core::SourceFile{"a.urdf", urdf});
  };
  CHECK(reserved(Compressed(std::string(kRobot))) == reserved(std::string(kRobot)));
  const std::string asf = ":root\norder TX TY TZ\n:hierarchy\nbegin\nend\n";
  REQUIRE(core::ReadAsf({"a.asf", asf}).ok());
  const std::string packed = Compressed(asf);
  CHECK(core::ReadAsf({"a.asf.gz", packed}).ok());
}

}  // namespace motiondb::tests::urdf_reader_test
